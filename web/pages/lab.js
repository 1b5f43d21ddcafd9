// Calls of the Worker, and small parts that all pages share.

const query = new URLSearchParams(location.search);
const waiting = new Map();
let last = 0;
let worker = null;
let lost = false;
const unloaded = () => new Error('the module cannot be loaded\nreload the page');

/// Starts the Worker, which loads the module: pages that draw call this first of all.
export function start() {
  if (worker) return;
  worker = new Worker(`worker.js${query.has('simd') ? `?simd=${query.get('simd')}` : ''}`, { type: 'module' });
  worker.onmessage = ({ data }) => {
    const { resolve, reject } = waiting.get(data.id);
    waiting.delete(data.id);
    if (data.error !== undefined) reject(new Error(data.error));
    else resolve(data.result);
  };
  // A script that cannot be loaded answers nothing, neither now nor later.
  worker.onerror = () => {
    lost = true;
    for (const { reject } of waiting.values()) reject(unloaded());
    waiting.clear();
  };
}

export function call(command, values = {}, moved = []) {
  start();
  if (lost) return Promise.reject(unloaded());
  return new Promise((resolve, reject) => {
    waiting.set(++last, { resolve, reject });
    worker.postMessage({ id: last, command, ...values }, moved);
  });
}

// A file beside those that take it would replace the page.
for (const name of ['dragover', 'drop']) addEventListener(name, (event) => event.preventDefault());

const KINDS = ['scene', 'glb', 'gltf', 'obj', 'ply', 'stl'];
const PARTS = ['mtl', 'bin', 'json', 'path', 'inc', 'png', 'jpg', 'jpeg', 'webp', 'gif', 'bmp', 'tga', 'tif', 'tiff', 'qoi', 'dds', 'ktx2', 'hdr', 'exr', 'npy'];

/// Gives the Worker files of the user: all names, that of the scene or model among them if there is one, and a note on files that are no
/// part of one.
export async function add(files) {
  const names = [];
  for (const file of files) {
    const name = file.webkitRelativePath || file.name;
    // Folders are dropped as files that cannot be read.
    const bytes = await file.arrayBuffer().catch((error) => { throw new Error(`${name} cannot be read: ${error.message}`); });
    await call('add', { name, bytes }, [bytes]);
    names.push(name);
  }
  const ending = (name) => name.split('.').pop().toLowerCase();
  const rank = (name) => KINDS.indexOf(ending(name));
  const [main] = names.filter((name) => rank(name) >= 0).sort((a, b) => rank(a) - rank(b));
  // A model comes with files of any kind.
  const others = main ? [] : names.filter((name) => !PARTS.includes(ending(name)));
  return { names, main, note: others.length ? `${others.join(', ')}: not a scene, model or picture` : '' };
}

/// An element with attributes and children; `on...` attributes are listeners.
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name in element && typeof value !== 'string') element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

/// Follows drags with the main button: `begin` gets the press and returns what its moves call, until the pointer is released or lost.
export function dragged(element, begin) {
  element.addEventListener('pointerdown', (press) => {
    if (press.button !== 0 || document.pointerLockElement) return;
    element.setPointerCapture(press.pointerId);
    const step = begin(press);
    const move = (event) => { if (event.pointerId === press.pointerId) step(event); };
    const ends = ['pointerup', 'pointercancel', 'lostpointercapture'];
    const end = (event) => {
      if (event.pointerId !== press.pointerId) return;
      element.removeEventListener('pointermove', move);
      for (const name of ends) element.removeEventListener(name, end);
    };
    element.addEventListener('pointermove', move);
    for (const name of ends) element.addEventListener(name, end);
  });
}

export function show(canvas, panel) {
  if (canvas.width !== panel.width || canvas.height !== panel.height) [canvas.width, canvas.height] = [panel.width, panel.height];
  canvas.style.imageRendering = panel.width < 200 ? 'pixelated' : '';
  if (!performance.getEntriesByName('first picture').length) performance.mark('first picture');
  canvas.getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(panel.rgba), panel.width, panel.height), 0, 0);
}

/// Tells an error in an element of words.
export function tell(words, error) {
  words.className = 'error';
  words.textContent = error.message;
}

export function number(value) {
  if (value === null) return 'not finite';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e7) return String(value);
  return size < 1e-3 || size >= 1e5 ? value.toExponential(2) : value.toPrecision(4);
}

export function save(name, bytes, type) {
  const link = make('a', { href: URL.createObjectURL(new Blob([bytes], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export const hashes = fetch('hashes.json').then((answer) => (answer.ok ? answer.json() : {})).catch(() => ({}));

const theme = document.getElementById('theme');
try {
  const kept = localStorage.getItem('theme');
  if (kept) document.documentElement.dataset.theme = kept;
} catch { /* no storage: the system's theme */ }
theme?.addEventListener('click', () => {
  const root = document.documentElement;
  const dark = getComputedStyle(root).colorScheme === 'dark' || (getComputedStyle(root).colorScheme !== 'light' && matchMedia('(prefers-color-scheme: dark)').matches);
  root.dataset.theme = dark ? 'light' : 'dark';
  try { localStorage.setItem('theme', root.dataset.theme); } catch { /* not kept */ }
});
