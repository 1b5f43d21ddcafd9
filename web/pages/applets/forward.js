import { ownPicture, picked, texture } from './scenes.js';

export default {
  title: 'Forward against inverse mapping',
  slide: 'Brackeen 2003, chapter 8; SUSTech lecture 08',
  text: ['Texel to pixel leaves holes near the eye (pink) and writes pixels many times far away. Pixel to texel reads one texel for each pixel. Drag the corners.'],
  formula: 'forward: pixel = H texel\ninverse: texel = H⁻¹ pixel',
  even: true,
  controls: [
    { id: 'corners', kind: 'points', label: 'Corner', value: [[0.06, 0.08], [0.9, 0.4], [0.9, 0.62], [0.06, 0.94]] },
    { id: 'texels', kind: 'range', label: 'Texels a side', min: 8, max: 256, step: 1, value: 120 },
    { ...texture, value: 'textures/uv_grid.png' }, ownPicture,
  ],
  files: (c) => [picked(c)],
  request: (c) => ({ kind: 'forward', picture: picked(c), texels: c.texels, size: [360, 270], corners: c.corners }),
};
