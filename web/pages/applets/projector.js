import { n, radians } from './scenes.js';

export default {
  title: 'The slide projector',
  slide: 'MIT 6.837 (2001), lecture 18, slides 21 to 26',
  text: ['A picture is thrown on the teapot, as light or as paint. Without its shadow map it shines through: the back of the pot and the floor behind it are lit too. The error is against rays in f64.'],
  formula: '(tᵢ, tⱼ, t) = P⁻¹ (X − origin), i = tᵢ/t, j = tⱼ/t, P = [u v l′]; points with t ≤ 0 lie behind',
  drag: ['yaw', 'height'],
  controls: [
    { id: 'mode', kind: 'choice', label: 'The picture is', value: 'light', options: ['light', 'paint'] },
    { id: 'shadow', kind: 'check', label: 'Shadow map', value: true },
    { id: 'angle', kind: 'range', label: 'Projector around', unit: '°', min: -180, max: 180, step: 1, value: -48 },
    { id: 'fov', kind: 'range', label: 'Field of view', unit: '°', min: 6, max: 60, step: 1, value: 26 },
    { id: 'soft', kind: 'range', label: 'Soft edge', min: 0, max: 0.5, step: 0.01, value: 0 },
    { id: 'yaw', kind: 'range', label: 'Eye around', unit: '°', min: -180, max: 180, step: 1, value: 4 },
    { id: 'height', kind: 'range', label: 'Eye up', min: 0.6, max: 7, step: 0.1, value: 3.6 },
    { id: 'texture', kind: 'choice', label: 'Slide', value: 'textures/uv_grid.png', options: [['textures/uv_grid.png', 'grid'], ['textures/brick.png', 'bricks'], ['textures/face.png', 'photo']] },
  ],
  files: (c) => [c.texture, 'models/teapot_white.obj', 'models/teapot_white.mtl'],
  request(c) {
    const [a, b] = [radians(c.angle), radians(c.yaw)];
    const text = `eye ${n(7.6 * Math.sin(b))} ${n(c.height)} ${n(7.6 * Math.cos(b))}\nlook 0.1 1.2 0\nfov 48\nbackground 0.10 0.11 0.14\nla 0.2 0.2 0.2
${c.mode === 'paint' ? 'ld 0.6 0.6 0.6 -1 -1 -1\n' : ''}projector ${c.texture} ${c.mode} ${n(9.2 * Math.sin(a))} 4.5 ${n(9.2 * Math.cos(a))} 0 1.2 0 0 1 0 ${n(c.fov)} soft ${n(c.soft)}${c.shadow ? ' shadow 1024' : ''}
surf 0.85 0.83 0.80 1 1 0 30\nv -6 0 6\nv 6 0 6\nv 6 0 -6\nv -6 0 -6\nf 0 1 2 3\nobj models/teapot_white.obj\n`;
    return { kind: 'draw', file: 'page.scene', text, size: [480, 360], reference: { rays: [120, 90] } };
  },
};
