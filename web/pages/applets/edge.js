export default {
  title: 'One edge, seen from the side',
  slide: 'MIT 6.837 (2001), lecture 18, slides 6 to 11',
  text: ['Even steps on the screen (black, at z = 1) meet the edge at uneven places (blue). Red marks where linear interpolation puts them. On the right s against t.'],
  formula: 's = t z₁ / (z₂ + t (z₁ − z₂)) = t w₂ / (w₁ + t (w₂ − w₁))\nlargest |s − t| = |√r − 1| / (√r + 1) at t = 1 / (1 + √r), r = w₂/w₁',
  controls: [
    { id: 'z1', kind: 'range', label: 'z₁', min: 1, max: 8, step: 0.05, value: 1.5 },
    { id: 'x1', kind: 'range', label: 'x₁', min: -2.5, max: 2.5, step: 0.05, value: -0.9 },
    { id: 'z2', kind: 'range', label: 'z₂', min: 1, max: 8, step: 0.05, value: 6 },
    { id: 'x2', kind: 'range', label: 'x₂', min: -2.5, max: 2.5, step: 0.05, value: 2 },
    { id: 't', kind: 'range', label: 't', min: 0, max: 1, step: 0.01, value: 0.5 },
    { id: 'steps', kind: 'range', label: 'Steps', min: 1, max: 32, step: 1, value: 10 },
  ],
  files: () => [],
  request: (c) => ({ kind: 'edge', size: [900, 420], x1: c.x1, z1: c.z1, x2: c.x2, z2: c.z2, t: c.t, steps: c.steps }),
};
