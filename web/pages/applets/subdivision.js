import { affineError, quad, v } from './scenes.js';

const aspect = 640 / 480;
export default {
  title: 'Subdivision, spans and an error bound',
  slide: 'MIT 6.837 (2001), lecture 18, slide 13; Brackeen 2003, chapter 8',
  text: ['Smaller triangles, or one division every n pixels, shrink the error with n² and do not end it. A tolerance picks the length of each span instead.'],
  formula: 'n parts in space: error ≤ |Δu| (r − 1) / (4 n²)\nn parts of the screen: error ≤ |Δu| r (r − 1) / (4 n²), r = z₂/z₁',
  controls: [
    { id: 'method', kind: 'choice', label: 'Method', value: 'subdivided', options: [['subdivided', 'subdivided triangles'], ['span', 'spans of n pixels'], ['within', 'spans within a tolerance']] },
    { id: 'n', kind: 'range', label: 'n, parts of an edge', min: 1, max: 16, step: 1, value: 2, when: { method: 'subdivided' } },
    { id: 'span', kind: 'range', label: 'n, length of a span', unit: 'pixels', min: 2, max: 64, step: 1, value: 16, when: { method: 'span' } },
    { id: 'tolerance', kind: 'range', label: 'Tolerance', unit: 'texels', min: 0.05, max: 8, step: 0.05, value: 1, when: { method: 'within' } },
    { id: 'tilt', kind: 'range', label: 'Narrow end', min: 0.08, max: 0.9, step: 0.01, value: 0.25 },
  ],
  files: () => ['textures/checker.png'],
  request(c) {
    const half = 0.45 * c.tilt;
    const found = quad([[0.06, 0.05], [0.94, 0.5 - half], [0.94, 0.5 + half], [0.06, 0.95]], aspect);
    const text = `eye 0 0 0\nlook 0 0 -1\nfov 90\nbackground 0.8 0.85 0.9\ntexture textures/checker.png\n${v(...found.points)}\ntf 0 0 0 1 1 0 2 1 1 3 0 1\n`;
    const interp = c.method === 'within' ? `within:${c.tolerance}` : `${c.method}:${c.method === 'span' ? c.span : c.n}`;
    const expected = c.method === 'subdivided' && c.n === 1 ? affineError(found.w, [256, 256]) : undefined;
    return { kind: 'draw', file: 'page.scene', text, size: [640, 480], interp, texels: [256, 256], reference: { interp: 'perspective', expected } };
  },
};
