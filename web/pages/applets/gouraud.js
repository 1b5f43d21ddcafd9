import { n } from './scenes.js';

// Two rows of quads that share an edge, whose middle is a vertex of the lower row alone; bright at the near end, dark at the far one.
function mesh(c) {
  const [near, far] = [1.6, 1.6 * c.ratio];
  const point = (part, x) => `${n(x)} ${n(-0.9 + 0 * part)} ${n(-(near + part * (far - near)))} ${[0.95, 0.35, 0.2].map((top) => n(top + part * (0.15 - top))).join(' ')}`;
  const rows = [point(0, -1.6), point(1, -1.6), point(1, 0), point(0, 0), point(0.5, 0), point(0.5, 1.6), point(1, 1.6), point(0, 1.6)];
  const faces = c.joint ? 'f 1 4 3\nf 1 3 2\nf 4 8 6\nf 4 6 5\nf 5 6 7\nf 5 7 3' : 'f 1 4 3\nf 1 3 2\nf 4 8 7\nf 4 7 3';
  return `${rows.map((row) => `v ${row}`).join('\n')}\ns off\n${faces}\n`;
}

export default {
  title: 'Gouraud shading and the T-joint',
  slide: 'MIT 6.837 (2001), lecture 18, slides 14 and 15',
  text: ['Colours interpolated on the screen make the same error as affine texture. At a T-joint the two sides of an edge disagree by it, and a seam shows; on the surface they agree.'],
  formula: 'seam in the middle of an edge: |c₂ − c₁| |1 − r| / (2 (1 + r)), r = z₂/z₁',
  controls: [
    { id: 'gouraud', kind: 'choice', label: 'Colours are linear', value: 'screen', options: [['screen', 'on the screen (Gouraud)'], ['perspective', 'on the surface']] },
    { id: 'ratio', kind: 'range', label: 'r = far / near', min: 1.1, max: 12, step: 0.1, value: 5 },
    { id: 'joint', kind: 'check', label: 'T-joint: the right side has a vertex in the middle', value: true },
    { id: 'height', kind: 'range', label: 'Eye', min: -0.2, max: 3, step: 0.05, value: 1 },
  ],
  files: () => [],
  request(c) {
    const scene = (gouraud) => `color raw\neye 0 ${n(c.height)} 1\nlook 0 -0.9 -3\nfov 74\nbackground 0.85 0.88 0.92\nla 1 1 1\nsurf 1 1 1 1 0 0 5\nshade vertex\ngouraud ${gouraud}\nobj joint.obj\n`;
    const size = [640, 480];
    return { kind: 'draw', file: 'page.scene', text: scene(c.gouraud), texts: { 'joint.obj': mesh(c) }, size,
      reference: { text: scene('perspective'), ...(c.gouraud === 'perspective' ? { expected_color: 0 } : {}) } };
  },
};
