// The scene page: files that are dropped, drawn as `texmap render` draws them.

import { add as addFiles, call, dragged, make, number, save, show, start } from './lab.js';
import { quoted } from './values.js';

start();

const main = document.querySelector('main');
const textures = ['carpet.gif', 'ceilingtile.gif', 'walls.gif', 'cow.png', 'fence.png', 'brick.png', 'leaf.png', 'leaf.gif', 'sky.png', 'lamps.png', 'uv_grid.png', 'face.png', 'label.png'].map((name) => `textures/${name}`);
const pair = (name) => [`models/${name}.obj`, `models/${name}.mtl`];
const SAMPLES = {
  'models/teapot.obj': [...pair('teapot'), 'textures/checker.png', 'textures/uv_grid.png', 'textures/brick.png'],
  'gltf/materials.glb': ['gltf/materials.glb'],
  'models/cow.obj': [...pair('cow'), 'textures/cow.png'],
  'scenes/purple_cow.scene': ['scenes/purple_cow.scene', ...textures, ...pair('cow')],
  'scenes/fence.scene': ['scenes/fence.scene', ...textures],
  'scenes/mirrors.scene': ['scenes/mirrors.scene', ...textures, 'models/ball_plain.obj', ...pair('teapot_white')],
};
const state = { file: 'models/teapot.obj', files: SAMPLES['models/teapot.obj'], camera: null, moved: false };
const dropped = [];

const option = (label, id, values, listener = () => changed()) => {
  const element = make('select', { id, 'data-control': id, onchange: listener }, ...values.map((v) => make('option', { value: v }, v || 'of the file')));
  return [make('label', {}, label, element), element];
};
const [fileLabel, file] = option('File', 'file', Object.keys(SAMPLES), () => choose(file.value, SAMPLES[file.value] ?? []));
const [sizeLabel, size] = option('Size', 'size', ['640x480', '1024x768', '320x240', '512x512'], () => {
  // The first view is framed for the size.
  if (!state.moved) forget();
  changed();
});
const [filterLabel, filter] = option('Filter', 'filter', ['', 'nearest', 'bilinear', 'bicubic:mitchell', 'mip-nearest', 'trilinear', 'anisotropic:16', 'ewa:16', 'summed-area']);
const [interpLabel, interp] = option('Interpolation', 'interp', ['', 'perspective', 'affine', 'subdivided:4', 'span:16']);
const [wrapLabel, wrap] = option('Wrap', 'wrap', ['', 'repeat', 'mirrored-repeat', 'clamp-to-edge', 'clamp-to-border']);
const [aovLabel, aov] = option('Array', 'aov', ['', 'depth', 'inv_w', 'uv', 'lod', 'face', 'mesh', 'normal', 'position']);
aov.firstChild.textContent = 'none';
const input = make('input', { type: 'file', id: 'files', multiple: true, 'aria-label': 'Files: .glb, .obj with its .mtl and textures, .scene' });
const slider = (label, id, min, max) => {
  const element = make('input', { type: 'range', id, 'data-control': id, min: String(min), max: String(max), step: 'any', value: '0' });
  element.addEventListener('input', () => { state.moved = true; changed(); });
  return [make('label', {}, label, element), element];
};
const [yawLabel, yaw] = slider('Around', 'yaw', -180, 180);
const [pitchLabel, pitch] = slider('Up and down', 'pitch', -80, 80);
const [zoomLabel, zoom] = slider('Nearer, farther', 'zoom', -1.5, 1.5);
const canvas = make('canvas', { role: 'img', 'aria-label': 'picture' });
const array = make('canvas', { role: 'img', 'aria-label': 'array' });
const second = make('figure', { hidden: true }, make('div', { class: 'stage' }, array), make('figcaption', {}));
const words = make('p', { class: 'soft', role: 'status' });
const hash = make('p', { class: 'hash' });
const command = make('pre', {});
const box = make('div', { class: 'stage' }, canvas);
main.append(
  make('h1', {}, 'A scene or model of your own'),
  make('p', {}, 'Drop a .glb, an .obj with its .mtl and textures, a .ply, an .stl or a .scene with its files on this page; all stay in this browser. Drag the picture to turn it. The PNG has the bytes of the command below.'),
  make('div', { class: 'lab' }, make('div', { class: 'panels' }, make('figure', {}, box, hash), second, words),
    make('form', { 'aria-label': 'Controls', onsubmit: (event) => event.preventDefault() }, fileLabel, make('label', {}, 'Your own files', input), sizeLabel, filterLabel, interpLabel, wrapLabel, aovLabel, yawLabel, pitchLabel, zoomLabel,
      make('div', {}, make('button', { type: 'button', id: 'reset', onclick: home }, 'First view'), ' ', make('button', { type: 'button', id: 'save', onclick: async () => save('picture.png', await call('png', { panel: 0 }), 'image/png') }, 'Download PNG')))),
  make('details', { open: true }, make('summary', {}, 'The command'), command),
);

dragged(box, (press) => {
  let at = [press.clientX, press.clientY];
  return (event) => {
    yaw.value = String(Number(yaw.value) - (event.clientX - at[0]) * 0.4);
    pitch.value = String(Number(pitch.value) + (event.clientY - at[1]) * 0.3);
    at = [event.clientX, event.clientY];
    state.moved = true;
    changed();
  };
});
box.addEventListener('wheel', (event) => { event.preventDefault(); zoom.value = String(Number(zoom.value) + event.deltaY * 0.001); state.moved = true; changed(); }, { passive: false });
input.addEventListener('change', () => take([...input.files]));
addEventListener('drop', (event) => take([...event.dataTransfer.files]));

async function take(files) {
  if (!files.length) return;
  main.dataset.state = 'busy';
  let found;
  try { found = await addFiles(files); } catch (error) { changed(error.message); return; }
  dropped.push(...found.names);
  if (!found.main) { changed(found.note); return; }
  if (![...file.options].some((o) => o.value === found.main)) file.append(make('option', { value: found.main }, found.main));
  file.value = found.main;
  choose(found.main, []);
}

function choose(name, files) {
  [state.file, state.files] = [name, files];
  home();
}

// Answers that were asked for before do not give the camera.
let views = 0;
function forget() {
  views++;
  state.camera = null;
}

function home() {
  forget();
  state.moved = false;
  for (const control of [yaw, pitch, zoom]) control.value = '0';
  changed();
}

const add = (a, b) => a.map((x, i) => x + b[i]);
const times = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => times(a, 1 / Math.hypot(...a));
function turned(p, axis, degrees) {
  const a = degrees * Math.PI / 180;
  return add(add(times(p, Math.cos(a)), times(cross(axis, p), Math.sin(a))), times(axis, dot(axis, p) * (1 - Math.cos(a))));
}

/// The eye after the orbit, rounded as the command shows it.
function eye() {
  const { eye, look, up } = state.camera;
  const axis = unit(up);
  const way = add(eye, times(look, -1));
  const rise = Math.asin(dot(unit(way), axis)) * 180 / Math.PI;
  const by = Math.min(85 - rise, Math.max(-85 - rise, Number(pitch.value)));
  const raised = turned(way, unit(cross(way, axis)), by);
  return add(look, times(turned(raised, axis, Number(yaw.value)), Math.exp(Number(zoom.value)))).map((x) => Number(x.toPrecision(7)));
}

let busy = false;
let pending = false;
let noted = '';
// A note stays until something changes again.
async function changed(note = '') {
  noted = note;
  main.dataset.state = 'busy';
  if (busy) { pending = true; return; }
  busy = true;
  const [width, height] = size.value.split('x').map(Number);
  const view = views;
  const request = { kind: 'draw', file: state.file, size: [width, height], where_from: true };
  for (const control of [filter, interp, wrap, aov]) if (control.value) request[control.id] = control.value;
  if (state.moved && state.camera) request.camera = { eye: eye(), look: state.camera.look };
  try {
    const answer = await call('ask', { files: state.files.filter((name) => !dropped.includes(name)), request });
    show(canvas, answer.panels[0]);
    canvas.dataset.hash = answer.panels[0].hash;
    hash.textContent = answer.panels[0].hash;
    second.hidden = answer.panels.length < 2;
    if (answer.panels[1]) { show(array, answer.panels[1]); array.dataset.hash = answer.panels[1].hash; second.lastChild.textContent = answer.panels[1].name; }
    if (!state.camera && view === views) {
      const at = answer.figures.map((figure) => figure.value);
      state.camera = { eye: at.slice(0, 3), look: at.slice(3, 6), up: at.slice(6, 9) };
    }
    words.className = noted ? 'error' : 'soft';
    words.textContent = (noted && `${noted}\n`) + [`${Math.round(answer.ms)} ms`, ...answer.warnings].join(' · ');
    const flags = ['filter', 'interp', 'wrap', 'aov'].filter((name) => request[name]).map((name) => ` --${name} ${request[name]}`).join('');
    const camera = request.camera ? ` --camera-eye=${request.camera.eye.join(',')} --camera-look=${request.camera.look.join(',')}` : '';
    command.textContent = `texmap render ${quoted(request.file)} -o picture.png --resolution ${width}x${height}${flags}${camera}\ntexmap hash picture.png    # ${answer.panels[0].hash}`;
  } catch (error) {
    words.className = 'error';
    words.textContent = [noted, error.message].filter(Boolean).join('\n');
  }
  busy = false;
  if (pending) { pending = false; changed(noted); return; }
  main.dataset.state = 'ready';
  main.dataset.draws = String(Number(main.dataset.draws ?? 0) + 1);
}
changed();
