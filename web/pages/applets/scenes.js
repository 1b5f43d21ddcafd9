// Parts of scene texts that several applets share; no browser needed.

// The choice of a texture takes a picture of one's own away.
export const texture = { id: 'texture', kind: 'choice', label: 'Texture', value: 'textures/checker.png', clears: 'own',
  options: [['textures/checker.png', 'checker'], ['textures/face.png', 'photo'], ['textures/brick.png', 'bricks'], ['textures/uv_grid.png', 'grid']] };
export const ownPicture = { id: 'own', kind: 'picture', label: 'Your own picture (or drop it on the page)', value: '' };
export const filter = { id: 'filter', kind: 'choice', label: 'Filter', value: 'trilinear',
  options: ['nearest', 'bilinear', 'bicubic:mitchell', 'mip-nearest', 'trilinear', 'anisotropic:16', 'ewa:16'] };

export const picked = (c) => c.own || c.texture;

/// Width and height of a texture, texels. `sizes` are those of pictures of the user, by their names.
export const texelsOf = (name, sizes = {}) => sizes[name] ?? (name === 'textures/face.png' || name === 'textures/uv_grid.png' ? [512, 512] : [256, 256]);

/// A number of a scene file.
export const n = (value) => String(Math.round(value * 1e6) / 1e6);
export const v = (...points) => points.map((p) => `v ${p.map(n).join(' ')}`).join('\n');

export const radians = (degrees) => degrees * Math.PI / 180;

/// The eye at a distance from a point, turned about it: yaw about +y, pitch upwards, degrees.
export function orbit([x, y, z], distance, yaw, pitch) {
  const [a, b] = [radians(yaw), radians(pitch)];
  return `eye ${n(x + distance * Math.sin(a) * Math.cos(b))} ${n(y + distance * Math.sin(b))} ${n(z + distance * Math.cos(a) * Math.cos(b))}\nlook ${n(x)} ${n(y)} ${n(z)}`;
}

/// A flat quad in space that is seen at four points of the screen (parts of width and height, in order around), for an eye at the origin
/// that looks along -z with a horizontal field of view of 90 degrees. Its distances follow from the homography of the unit square
/// (Heckbert 1989). Null where the points are no convex quad.
export function quad(points, aspect) {
  const [p0, p1, p2, p3] = points.map(([x, y]) => [2 * x - 1, (1 - 2 * y) / aspect]);
  const cross = (a, b, c) => (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
  const turns = [cross(p0, p1, p2), cross(p1, p2, p3), cross(p2, p3, p0), cross(p3, p0, p1)];
  if (turns.some((t) => Math.abs(t) < 1e-3 || Math.sign(t) !== Math.sign(turns[0]))) return null;
  const s = [0, 1].map((k) => p0[k] - p1[k] + p2[k] - p3[k]);
  const [d1, d2] = [[0, 1].map((k) => p1[k] - p2[k]), [0, 1].map((k) => p3[k] - p2[k])];
  const det = d1[0] * d2[1] - d1[1] * d2[0];
  const g = (s[0] * d2[1] - s[1] * d2[0]) / det;
  const h = (d1[0] * s[1] - d1[1] * s[0]) / det;
  const w = [1, 1 + g, 1 + g + h, 1 + h];
  return { w, points: [p0, p1, p2, p3].map(([x, y], i) => [4 * x * w[i], 4 * y * w[i], -4 * w[i]]) };
}

/// The largest affine error of a quad that carries a texture of this width and height once, drawn as two triangles: over its edges and
/// its diagonal.
export function affineError(w, [width, height]) {
  const of = (i, j, change) => change * Math.abs(Math.sqrt(w[i]) - Math.sqrt(w[j])) / (Math.sqrt(w[i]) + Math.sqrt(w[j]));
  return Math.max(of(0, 1, width), of(1, 2, height), of(2, 3, width), of(3, 0, height), of(0, 2, Math.hypot(width, height)));
}

/// A tilted plane that runs to the horizon, with a texture repeated over it.
export function plane(tilt, repeat, lines) {
  const a = radians(tilt);
  const far = [0, 20 * Math.sin(a) * 1, -20 * Math.cos(a)];
  const [u, depth] = [[4, 0, 0], far];
  const at = (x, d) => [x * u[0], -1 + d * depth[1], -1.2 + d * depth[2]];
  return `eye 0 0 0\nlook 0 ${n(-0.35 + 0.6 * Math.sin(a))} -1\nfov 70\nbackground 0.75 0.82 0.9\n${lines}
${v(at(-1.5, 0), at(1.5, 0), at(1.5, 1), at(-1.5, 1))}\ntf 0 0 ${n(repeat * 20 / 12)} 1 ${n(repeat)} ${n(repeat * 20 / 12)} 2 ${n(repeat)} 0 3 0 0\n`;
}
