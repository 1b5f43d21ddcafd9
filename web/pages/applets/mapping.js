export default {
  title: 'Sphere, cylinder, box and plane mapping',
  slide: 'SUSTech lecture 08; CS184 lecture 20; Bier and Sloan 1986',
  text: ['Coordinates for a model that has none. The checker shows stretch, the heat map measures it, the layout shows overlaps.'],
  formula: 'sphere: u = θ/2π, v = φ/π\ncylinder: u = θ/2π, v = y\nplane: drop z\nbox: one plane a side',
  controls: [
    { id: 'shape', kind: 'choice', label: 'Shape', value: 'sphere', options: ['sphere', 'cylinder', 'box', 'plane'] },
    { id: 'by', kind: 'choice', label: 'By', value: 'position', options: ['position', 'normal', 'centroid'] },
    { id: 'model', kind: 'choice', label: 'Model', value: 'teapot_white', options: [['teapot_white', 'teapot'], ['house', 'house'], ['twisted_box', 'twisted box'], ['ball_plain', 'ball'], ['head', 'head']] },
    { id: 'repeat', kind: 'range', label: 'Repeats', min: 1, max: 6, step: 1, value: 1 },
    { id: 'seams', kind: 'check', label: 'Repair the seam and the poles', value: true },
    { id: 'view', kind: 'choice', label: 'View', value: 'three-quarter', options: ['three-quarter', 'front', 'back', 'left', 'right', 'top', 'bottom', 'iso'] },
  ],
  // The figures come after the first picture.
  slow: true,
  even: true,
  files: (c) => [`models/${c.model}.obj`, ...(['ball_plain'].includes(c.model) ? [] : [`models/${c.model}.mtl`])],
  request: (c) => ({ kind: 'mapping', model: `models/${c.model}.obj`, shape: c.shape, by: c.by, repeat: [c.repeat, c.repeat], seams: c.seams, view: c.view, size: 360 }),
  // The program knows seams and poles of the cylinder and the sphere alone.
  command: (c) => `texmap uv models/${c.model}.obj -o new.obj --map ${c.shape} --by ${c.by} --repeat ${c.repeat},${c.repeat}${c.seams && ['sphere', 'cylinder'].includes(c.shape) ? ' --fix-seams' : ''} --report`,
};
