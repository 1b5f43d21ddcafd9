import { n, radians, v } from './scenes.js';

// The eye looks straight at the plane z = 0 from 5 in front of it; the picture is 6 wide.
const place = ([x, y]) => [6 * (x - 0.5), 4.5 * (0.5 - y)];
const polygon = [[-2, -1.5], [0, -1.9], [2, -1.5], [2, 1.2], [0, 1.8], [-2, 1.2]];

export default {
  title: 'The O-U-V frame',
  slide: 'Brackeen 2003, chapter 8: texture mapping equations',
  text: ['Drag O, U and V: the polygon gets its texture from the frame, not from its vertices. A frame out of the plane slides over it as the eye moves.'],
  formula: 'A = V × O, B = O × U, C = U × V\nu = A·W / C·W, v = B·W / C·W, W on the view plane',
  controls: [
    { id: 'frame', kind: 'points', label: 'Frame', names: ['O', 'U', 'V'], value: [[0.28, 0.22], [0.62, 0.3], [0.22, 0.68]] },
    { id: 'tilt', kind: 'range', label: 'V leaves the plane by', unit: '°', min: -60, max: 60, step: 1, value: 0 },
    { id: 'eye', kind: 'range', label: 'Eye to the side', min: -4, max: 4, step: 0.1, value: 0 },
    { id: 'wrap', kind: 'choice', label: 'Wrap', value: 'repeat', options: ['repeat', 'mirrored-repeat', 'clamp-to-edge', 'clamp-to-border'] },
  ],
  files: () => ['textures/uv_grid.png'],
  request(c) {
    const [o, u, w] = c.frame.map(place);
    const [U, V] = [u, w].map((p) => [p[0] - o[0], p[1] - o[1]]);
    const a = radians(c.tilt);
    const head = `eye ${n(c.eye)} 0 5\nlook 0 0 0\nfov ${n(2 * Math.atan(3 / 5) * 180 / Math.PI)}\nbackground 0.14 0.15 0.18\ntexture textures/uv_grid.png\nwrap ${c.wrap}\nborder 0.3 0.3 0.34 1\n${v(...polygon.map((p) => [...p, 0]))}\n`;
    const text = `${head}frame ${[...o, 0, ...U, 0, V[0] * Math.cos(a), V[1] * Math.cos(a), Math.hypot(...V) * Math.sin(a)].map(n).join(' ')}\nff 0 1 2 3 4 5\n`;
    const det = U[0] * V[1] - U[1] * V[0];
    const uv = polygon.map(([x, y]) => [x - o[0], y - o[1]]).map(([x, y]) => [(x * V[1] - y * V[0]) / det, (U[0] * y - U[1] * x) / det]);
    const flat = `${head}tf ${uv.map((p, i) => `${i} ${p.map((k) => k.toPrecision(12)).join(' ')}`).join(' ')}\n`;
    return { kind: 'draw', file: 'page.scene', text, size: [640, 480], texels: [512, 512], reference: { text: flat, ...(c.tilt === 0 ? { expected: 0 } : {}) } };
  },
};
