import { filter, n, orbit } from './scenes.js';

export default {
  title: 'Transparency: holes by alpha',
  slide: 'MIT 6.837 (2001), lecture 18, slide 17; SUSTech lecture 08',
  text: ['A texel of alpha 0 is a hole: neither colour nor depth is written. A test is all or nothing; blending mixes, in the order of the file. The error is against 8 × 8 samples a pixel.'],
  formula: 'test: draw where α ≥ t\nblend: C = α F + (1 − α) B',
  drag: ['yaw', 'pitch'],
  controls: [
    { id: 'alpha', kind: 'choice', label: 'Alpha', value: 'test', options: ['test', 'blend', 'opaque'] },
    { id: 't', kind: 'range', label: 'Threshold t', min: 0.05, max: 1, step: 0.05, value: 0.5, when: { alpha: 'test' } },
    filter,
    { id: 'yaw', kind: 'range', label: 'Turn', unit: '°', min: -80, max: 80, step: 1, value: -20 },
    { id: 'pitch', kind: 'range', label: 'Rise', unit: '°', min: 0, max: 40, step: 1, value: 8 },
  ],
  files: () => ['textures/brick.png', 'textures/leaf.png', 'textures/fence.png'],
  request(c) {
    const alpha = c.alpha === 'test' ? `test ${n(c.t)}` : c.alpha;
    const text = `${orbit([0, 0.8, 0], 5.2, c.yaw, c.pitch)}\nfov 50\nbackground 0.66 0.82 0.96\nla 1 1 1\nsurf 0.36 0.62 0.26 1 0 0 1
v -30 0 12\nv 30 0 12\nv 30 0 -40\nv -30 0 -40\nf 0 1 2 3\nfilter ${c.filter}\ntexture textures/brick.png
v -5 0 -3\nv 5 0 -3\nv 5 2.4 -3\nv -5 2.4 -3\ntf 4 0 1.5 5 6 1.5 6 6 0 7 0 0\nalpha ${alpha}\ntexture textures/leaf.png\nwrap clamp-to-edge
v -1 0.1 -1\nv 0.4 0.1 -1\nv 0.4 1.5 -1.2\nv -1 1.5 -1.2\ntf 8 0 1 9 1 1 10 1 0 11 0 0\ntexture textures/fence.png\nwrap repeat clamp-to-edge
v -3 0 0.4\nv 3 0 0.4\nv 3 1.2 0.4\nv -3 1.2 0.4\ntf 12 0 1 13 5 1 14 5 0 15 0 0\n`;
    return { kind: 'draw', file: 'page.scene', text, size: [640, 480], reference: { supersample: 8 } };
  },
};
