import { n, v } from './scenes.js';

export default {
  title: 'Tiling and the five wraps',
  slide: 'MIT 6.837 (2001), lecture 18, slide 16; Brackeen 2003, chapter 8',
  text: ['Coordinates beyond 0 and 1. Floor, not truncation, keeps every texel equally wide on both sides of 0. The error is against rays in f64.'],
  formula: 'repeat: u − ⌊u⌋\nmirrored: distance to the nearest even whole number\nclamp: min(max(u, 0), 1)',
  controls: [
    { id: 'wrap', kind: 'choice', label: 'Wrap', value: 'repeat', options: ['repeat', 'mirrored-repeat', 'clamp-to-edge', 'clamp-to-border', 'mirror-clamp-to-edge'] },
    { id: 'size', kind: 'range', label: 'Pictures across', min: 0.5, max: 8, step: 0.1, value: 3.2 },
    { id: 'u', kind: 'range', label: 'Offset of u', min: -4, max: 4, step: 0.05, value: -1.1 },
    { id: 'v', kind: 'range', label: 'Offset of v', min: -4, max: 4, step: 0.05, value: -1.1 },
    { id: 'texture', kind: 'choice', label: 'Texture', value: 'textures/uv_grid.png', options: [['textures/uv_grid.png', 'grid'], ['textures/brick.png', 'bricks'], ['textures/face.png', 'photo']] },
  ],
  files: (c) => [c.texture],
  request(c) {
    const [u, w, s] = [c.u, c.v, c.size];
    const text = `eye -0.5 0.3 2.6\nlook 0 0 0\nfov 52\nbackground 0.2 0.22 0.26\nfilter bilinear\nwrap ${c.wrap}\nborder 1 0.6 0.1 1\ntexture ${c.texture}
${v([-1.2, -0.9, 0], [1.2, -0.9, -0.6], [1.2, 0.9, -0.6], [-1.2, 0.9, 0])}\ntf 0 ${n(u)} ${n(w + s * 0.75)} 1 ${n(u + s)} ${n(w + s * 0.75)} 2 ${n(u + s)} ${n(w)} 3 ${n(u)} ${n(w)}\n`;
    return { kind: 'draw', file: 'page.scene', text, size: [640, 480], reference: { rays: [320, 240] } };
  },
};
