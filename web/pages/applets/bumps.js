import { n, orbit, radians } from './scenes.js';

export default {
  title: 'Bump, normal and displacement maps',
  slide: 'SUSTech lecture 08; Blinn 1978',
  text: ['A bump map turns light and leaves the outline; a displacement map moves the surface. The error is against the displaced surface, which both stand for.'],
  formula: 'N′ = N + Bᵤ (n × Oᵥ) − Bᵥ (n × Oᵤ)\ndisplaced: O′ = O + B n',
  drag: ['yaw', 'pitch'],
  controls: [
    { id: 'method', kind: 'choice', label: 'Method', value: 'bump', options: ['none', 'bump', ['normalmap', 'normal map (of another relief)'], ['displace', 'displacement']] },
    { id: 'height', kind: 'range', label: 'Height', min: -0.2, max: 0.2, step: 0.005, value: 0.06, when: { method: ['bump', 'displace'] } },
    { id: 'light', kind: 'range', label: 'Light around', unit: '°', min: -180, max: 180, step: 1, value: -70 },
    { id: 'low', kind: 'range', label: 'Light above the surface', unit: '°', min: 5, max: 85, step: 1, value: 30 },
    { id: 'yaw', kind: 'range', label: 'Eye around', unit: '°', min: -75, max: 75, step: 1, value: 25 },
    { id: 'pitch', kind: 'range', label: 'Eye up', unit: '°', min: -60, max: 60, step: 1, value: 20 },
  ],
  files: () => ['textures/brick.png', 'textures/brick_heights.png', 'textures/normals.png'],
  request(c) {
    const [a, b] = [radians(c.light), radians(c.low)];
    const way = [-Math.sin(a) * Math.cos(b), -Math.cos(a) * Math.cos(b), -Math.sin(b)].map(n).join(' ');
    const scene = (method) => {
      const line = { none: '', bump: `bump textures/brick_heights.png ${n(c.height)}`, normalmap: 'normalmap textures/normals.png', displace: `displace textures/brick_heights.png ${n(c.height)} texels 1` }[method];
      return `${orbit([0, 0, 0], 3.4, c.yaw, c.pitch)}\nfov 42\nbackground 0.20 0.22 0.26\nla 0.2 0.2 0.22\nld 0.8 0.78 0.72 ${way}\nsurf 0.9 0.9 0.9 1 1 0.2 24\nshade modulate pixel\ntexture textures/brick.png\n${line}
v -1.2 -1.2 0\nv 1.2 -1.2 0\nv 1.2 1.2 0\nv -1.2 1.2 0\ntf 0 0 1 1 1 1 2 1 0 3 0 0\n`;
    };
    return { kind: 'draw', file: 'page.scene', text: scene(c.method), size: [560, 420], reference: { text: scene('displace') } };
  },
};
