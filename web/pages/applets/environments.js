import { orbit } from './scenes.js';

export default {
  title: 'Environment charts',
  slide: 'MIT 6.837 (2001), lecture 18, slides 28 to 31: "What\'s the best chart?"',
  text: ['All directions on one picture, and a ball that mirrors it. Charts of as many texels differ in where they spend them. The error is against the whole picture.'],
  formula: 'R = 2 (N·V) N − V; the chart takes R to a texel; all rays start at the centre',
  remark: 'the picture that the error is against: the mirror of the whole sky, without the chart',
  drag: ['yaw', 'pitch'],
  controls: [
    { id: 'layout', kind: 'choice', label: 'Layout', value: 'cube', options: ['cube', 'tan-cube', 'lat-long', 'octahedron', 'equal-area-octahedron', 'dual-paraboloid', 'sphere-map'] },
    { id: 'texels', kind: 'range', label: 'Texels of the chart', min: 96, max: 12288, step: 96, value: 1536 },
    { id: 'yaw', kind: 'range', label: 'Eye around', unit: '°', min: -180, max: 180, step: 1, value: 10 },
    { id: 'pitch', kind: 'range', label: 'Eye up', unit: '°', min: -80, max: 80, step: 1, value: 12 },
    { id: 'model', kind: 'choice', label: 'Mirror', value: 'ball_plain', options: [['ball_plain', 'ball'], ['teapot_white', 'teapot']] },
  ],
  files: (c) => ['textures/sky.png', `models/${c.model}.obj`, ...(c.model === 'teapot_white' ? ['models/teapot_white.mtl'] : [])],
  request(c) {
    const model = c.model === 'ball_plain' ? 'scale 2' : 'translate 0 -0.8 0\nscale 0.6';
    const text = `${orbit([0, 0, 0], 4, c.yaw, c.pitch)}\nfov 36\nbackground 0.2 0.2 0.24\nsurf 0 0 0 0 0 0 1\nenv textures/sky.png lat-long 1\npush\n${model}\nobj models/${c.model}.obj\npop\n`;
    return { kind: 'charts', text, size: [480, 480], layout: c.layout, texels: c.texels };
  },
};
