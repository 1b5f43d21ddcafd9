import { n, orbit, radians } from './scenes.js';

export default {
  title: 'Shadow maps: bias and taps',
  slide: 'MIT 6.837 (2001), lecture 18, slide 27',
  text: ['The light\'s depth map (near is light, far dark, nothing white) is looked up from the eye. No bias gives acne, too much detaches shadows. The error is against shadows by rays in f64.'],
  formula: 'lit where depth of the point ≤ depth in the map + bias; K × K comparisons are averaged',
  drag: ['yaw', 'pitch'],
  controls: [
    { id: 'bias', kind: 'choice', label: 'Bias', value: 'planes', options: [['planes', 'planes of both surfaces (default)'], 'constant', 'slope', 'normal-offset'] },
    { id: 'amount', kind: 'range', label: 'Amount of the bias', min: 0, max: 0.5, step: 0.005, value: 0.05, when: { bias: ['constant', 'slope', 'normal-offset'] } },
    { id: 'taps', kind: 'choice', label: 'Taps', value: '3', options: ['1', '3', '5', '9', '15'] },
    { id: 'size', kind: 'choice', label: 'Texels a side', value: '256', options: ['64', '128', '256', '512', '1024'] },
    { id: 'sun', kind: 'range', label: 'Sun around', unit: '°', min: -180, max: 180, step: 1, value: -60 },
    { id: 'low', kind: 'range', label: 'Sun above the horizon', unit: '°', min: 10, max: 85, step: 1, value: 40 },
    { id: 'yaw', kind: 'range', label: 'Eye around', unit: '°', min: -180, max: 180, step: 1, value: 20 },
    { id: 'pitch', kind: 'range', label: 'Eye up', unit: '°', min: 5, max: 85, step: 1, value: 26 },
  ],
  files: () => ['models/ball_plain.obj', 'models/cube_plain.obj', 'textures/fence.png'],
  request(c) {
    const [a, b] = [radians(c.sun), radians(c.low)];
    const way = [-Math.sin(a) * Math.cos(b), -Math.sin(b), -Math.cos(a) * Math.cos(b)].map(n).join(' ');
    const bias = c.bias === 'planes' ? '' : c.bias === 'normal-offset' ? ` normal-offset ${n(c.amount * 10)}` : ` ${c.bias} ${n(c.amount)}`;
    const text = `${orbit([0, 0.4, 0], 6.6, c.yaw, c.pitch)}\nfov 44\nbackground 0.60 0.74 0.90\nla 0.3 0.3 0.34\nld 0.7 0.68 0.62 ${way}\nshadow ${c.size} taps ${c.taps}${bias}
surf 0.86 0.84 0.80 1 1 0 20\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nv -4 0 -4\nf 0 1 2 3\nshade modulate pixel\ntexture textures/fence.png\nwrap repeat clamp-to-edge
v -2.6 0 1.4\nv -0.2 0 2.2\nv -0.2 1 2.2\nv -2.6 1 1.4\ntf 4 0 1 5 4 1 6 4 0 7 0 0\ntexture none\nsurf 0.78 0.42 0.30 1 1 0 30
push\ntranslate 1 0.5 0.6\nobj models/ball_plain.obj\npop\nsurf 0.5 0.62 0.8 1 1 0 30\npush\ntranslate -0.9 0.5 -1.2\nrotate 30 0 1 0\nobj models/cube_plain.obj\npop\n`;
    return { kind: 'depth-map', text, size: [480, 360], map: 256, rays: [120, 90] };
  },
};
