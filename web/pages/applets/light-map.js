export default {
  title: 'Light maps and a moving spot',
  slide: 'MIT 6.837 (2001), lecture 18, slide 19; Abrash 1997, chapter 68',
  text: ['The resting light of the room lies baked in a map. The spot alone is baked anew for each frame and added; no pixel may differ from a fresh bake of all lights by more than one code.'],
  formula: 'colour = texel × (resting map + map of the spot)',
  controls: [
    { id: 'frame', kind: 'range', label: 'Place of the spot', min: 0, max: 47, step: 1, value: 6 },
    { id: 'size', kind: 'choice', label: 'Pixels a side', value: '256', options: ['128', '256', '384'] },
  ],
  files: () => [],
  request: (c) => ({ kind: 'light-map', size: Number(c.size), frame: c.frame, of: 48 }),
  command: (c) => `texmap demo light-maps --frames 48 --size ${c.size} -o spot%02d.png`,
};
