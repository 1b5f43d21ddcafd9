import { ownPicture } from './scenes.js';

export default {
  title: 'Rectify a photo by four points',
  slide: 'MIT 6.837 (2001), lecture 18, slide 20: a photo is a texture only without its perspective',
  text: ['Put the four points on the corners of something flat, from its upper left corner clockwise. The homography of the points makes it a texture; your photo stays in this browser.'],
  formula: '(x′ w, y′ w, w) = H (x, y, 1): four points, eight unknowns',
  even: true,
  controls: [
    { id: 'from', kind: 'points', panel: 1, label: 'Point', value: [[0.717, 0.201], [0.928, 0.192], [0.912, 0.728], [0.709, 0.716]] },
    { id: 'width', kind: 'range', label: 'Width', unit: 'pixels', min: 32, max: 1024, step: 1, value: 300 },
    { id: 'height', kind: 'range', label: 'Height', unit: 'pixels', min: 32, max: 1024, step: 1, value: 420 },
    { id: 'filter', kind: 'choice', label: 'Filter', value: 'anisotropic:16', options: ['nearest', 'bilinear', 'bicubic:mitchell', 'anisotropic:16', 'ewa:8'] },
    { ...ownPicture, label: 'Your own photo (or drop it on the page)' },
  ],
  files: (c) => [c.own || 'photos/room.png'],
  request: (c) => ({ kind: 'rectify', photo: c.own || 'photos/room.png', from: c.from.map((point) => point.map((part) => Math.round(part * 1e4) / 1e4)), size: [c.width, c.height], filter: c.filter, shown: 480 }),
  command(c, answer) {
    // All digits, for the same bytes.
    const at = answer.figures.filter((figure) => figure.unit === 'point').map((figure) => figure.value);
    const points = [0, 2, 4, 6].map((i) => `${at[i]},${at[i + 1]}`).join(' ');
    return `texmap warp ${c.own ? 'photo' : 'docs/images/purple_cow.png'} -o plane.png --size ${c.width}x${c.height} --filter ${c.filter} --from ${points}`;
  },
};
