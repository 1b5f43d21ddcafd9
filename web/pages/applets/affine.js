import { affineError, filter, ownPicture, picked, quad, texelsOf, texture, v } from './scenes.js';

const aspect = 640 / 480;
export default {
  title: 'Affine against perspective',
  slide: 'MIT 6.837 (2001), lecture 18, slides 4 to 13',
  text: ['Drag the corners of the quad. Its two triangles bend an affine texture along their diagonal; one division a pixel cures it.'],
  formula: 'affine: u = u₁ + t (u₂ − u₁)\nperspective: u = (u₁w₁ + t (u₂w₂ − u₁w₁)) / (w₁ + t (w₂ − w₁)), w = 1/z\nlargest error of an edge: |u₂ − u₁| |√w₂ − √w₁| / (√w₂ + √w₁)',
  controls: [
    { id: 'corners', kind: 'points', label: 'Corner', value: [[0.12, 0.1], [0.8, 0.3], [0.86, 0.78], [0.18, 0.93]] },
    { id: 'interp', kind: 'choice', label: 'Interpolation', value: 'affine', options: ['affine', 'perspective', 'subdivided:2', 'subdivided:4', 'span:16', 'within:0.5'] },
    texture, filter, ownPicture,
  ],
  files: (c) => [picked(c)],
  request(c, sizes) {
    const texels = texelsOf(picked(c), sizes);
    const found = quad(c.corners, aspect);
    if (!found) throw new Error('these four points are no convex quad: move one');
    const text = `eye 0 0 0\nlook 0 0 -1\nfov 90\nbackground 0.8 0.85 0.9\nfilter ${c.filter}\ntexture ${picked(c)}\n${v(...found.points)}\ntf 0 0 0 1 1 0 2 1 1 3 0 1\n`;
    const expected = c.interp === 'affine' ? affineError(found.w, texels) : c.interp === 'perspective' ? 0 : undefined;
    return { kind: 'draw', file: 'page.scene', text, size: [640, 480], interp: c.interp, texels, reference: { interp: 'perspective', expected } };
  },
};
