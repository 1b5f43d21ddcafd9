import { quoted } from '../values.js';

export default {
  title: 'Light maps and a moving spot',
  slide: 'MIT 6.837 (2001), lecture 18, slide 19; Abrash 1997, chapter 68',
  text: ['The resting light of the room lies baked in a map. The spot alone is baked anew for each frame and added; no pixel may differ from a fresh bake of all lights by more than one code. Drop a room of your own: its lights are baked when it is read.'],
  // The figures come after the first picture.
  slow: true,
  formula: 'colour = texel × (resting map + map of the spot)',
  controls: [
    { id: 'frame', kind: 'range', label: 'Place of the spot', min: 0, max: 47, step: 1, value: 6 },
    { id: 'size', kind: 'choice', label: 'Pixels a side', value: '256', options: ['128', '256', '384'] },
    { id: 'own', kind: 'files', label: 'Your own room: a .scene, .glb or .obj with its files (or drop them on the page)', value: '' },
  ],
  files: () => [],
  request: (c) => ({ kind: 'light-map', size: Number(c.size), frame: c.frame, of: 48, ...(c.own ? { file: c.own } : {}) }),
  command: (c) => (c.own
    ? `# The page gives every mesh a map; with the program, for meshes that have coordinates and a spot light NAME in the file:\ntexmap bake ${quoted(c.own)} --light --object all --except NAME --size 256 -o 'maps/{object}.exr'\ntexmap render ${quoted(c.own)} --light-path spot.json --light NAME --frames 48 -o spot%02d.png`
    : `texmap demo light-maps --frames 48 -o spot%02d.png    # draws 384 x 384 pixels`),
};
