import { filter, plane, texelsOf, texture } from './scenes.js';

const scene = (c, method) => plane(c.tilt, c.repeat, `filter ${method}\ntexture ${c.texture}`);
export default {
  title: 'Filters on a tilted plane',
  slide: 'SUSTech lecture 08; Greene and Heckbert 1986',
  text: ['The pixel under the handle covers the red quad of the texture. Filters average it by one texel, four, a level of the chain, or along its longer axis. The error is against 8 × 8 samples a pixel.'],
  formula: 'level = log₂ of the longer axis\nanisotropic: N probes along it\nEWA: a Gaussian over the ellipse',
  remark: 'the picture without the frame around the pixel of the handle',
  controls: [
    filter,
    { id: 'pixel', kind: 'points', label: 'Pixel', value: [[0.5, 0.45]], names: ['+'] },
    { id: 'tilt', kind: 'range', label: 'Tilt', unit: '°', min: 0, max: 45, step: 1, value: 2 },
    { id: 'repeat', kind: 'range', label: 'Pictures across', min: 1, max: 24, step: 1, value: 8 },
    { id: 'window', kind: 'range', label: 'Window', unit: 'texels', min: 8, max: 512, step: 1, value: 24 },
    texture,
  ],
  files: (c) => [c.texture],
  request(c) {
    const [texels] = texelsOf(c.texture);
    return { kind: 'footprint', text: scene(c, c.filter), texture: c.texture, texels, size: [640, 400], pixel: c.pixel[0], window: c.window, reference: scene(c, 'trilinear') };
  },
};
