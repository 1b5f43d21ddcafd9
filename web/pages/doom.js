// Purple Cow Doom: keys, mouse or touch to the Worker, frames back.

import { call, dragged, hashes, make, number, show, start, tell } from './lab.js';

start();

const main = document.querySelector('main');
const FILES = ['textures/carpet.gif', 'textures/ceilingtile.gif', 'textures/walls.gif', 'textures/fence.png', 'textures/leaf.png', 'textures/cow.png', 'models/cow.obj', 'models/cow.mtl'];
const KEYS = { KeyW: 1, ArrowUp: 1, KeyS: 2, ArrowDown: 2, KeyA: 4, KeyD: 8, ArrowLeft: 16, ArrowRight: 32, KeyE: 64, Space: 64, ShiftLeft: 128, ShiftRight: 128 };
const TAPS = { nearest: 1, bilinear: 4, trilinear: 8, 'mip-nearest': 1 };

const canvas = make('canvas', { role: 'img', 'aria-label': 'The room. W A S D or arrows walk, the mouse looks, E opens the door', tabIndex: 0 });
const select = (label, options, id) => {
  const element = make('select', { id, 'data-control': id }, ...options.map((o) => make('option', { value: o }, o)));
  return [make('label', {}, label, element), element];
};
const [sizeLabel, size] = select('Size', ['640x400', '320x200', '960x600', '1280x720'], 'size');
const [filterLabel, filter] = select('Filter', ['trilinear', 'bilinear', 'nearest', 'mip-nearest'], 'filter');
const affine = make('input', { type: 'checkbox', id: 'affine', 'data-control': 'affine' });
const counter = make('p', { class: 'soft', role: 'status' });
const recorded = make('p', { class: 'hash' });
const pad = make('div', { class: 'pad', role: 'group', 'aria-label': 'Walk by touch' });
let held = 0;
let touched = 0;
for (const [text, name, button] of [['↑', 'ahead', 1], ['↓', 'back', 2], ['⟲', 'turn left', 16], ['⟳', 'turn right', 32], ['E', 'door', 64]]) {
  const key = make('button', { type: 'button', 'aria-label': name }, text);
  key.addEventListener('pointerdown', (event) => { event.preventDefault(); touched |= button; });
  for (const end of ['pointerup', 'pointercancel', 'pointerleave']) key.addEventListener(end, () => { touched &= ~button; });
  pad.append(key);
}
main.append(
  make('h1', {}, 'Purple Cow Doom'),
  make('p', { class: 'soft' }, 'MIT 6.837 (2001), lecture 18, slides 17 and 18: “Now you can all go out and write DOOM!”'),
  make('p', {}, 'W A S D or arrows walk, Shift runs, E opens the door. Click the picture to look around with the mouse, or drag it.'),
  make('div', { class: 'lab' }, make('div', {}, make('div', { class: 'stage' }, canvas), pad, counter),
    make('form', { 'aria-label': 'Controls', onsubmit: (event) => event.preventDefault() }, sizeLabel, filterLabel, make('label', { class: 'check' }, affine, 'Affine interpolation (wrong)'),
      make('button', { type: 'button', id: 'record', onclick: record }, 'Play the recorded walk'), recorded)),
);

addEventListener('keydown', (event) => {
  // Keys of the browser, and those that a control of the page takes itself.
  const taken = event.target.matches('select') || (event.code === 'Space' && event.target.matches('input, button'));
  if (!(event.code in KEYS) || taken || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  held |= KEYS[event.code];
});
addEventListener('keyup', (event) => { held &= ~(KEYS[event.code] ?? 0); });
addEventListener('blur', () => { held = 0; });
let [turn, raise] = [0, 0];
canvas.addEventListener('click', () => { canvas.focus(); if (matchMedia('(pointer: fine)').matches) canvas.requestPointerLock?.(); });
const look = (dx, dy) => {
  turn -= dx * 0.003;
  raise -= dy * 0.003;
};
dragged(canvas, (press) => {
  let [x, y] = [press.clientX, press.clientY];
  return (event) => {
    look(event.clientX - x, event.clientY - y);
    [x, y] = [event.clientX, event.clientY];
  };
});
canvas.addEventListener('pointermove', (event) => { if (document.pointerLockElement === canvas) look(event.movementX, event.movementY); });

let running = true;
let clock = performance.now();
let owed = 0;
const shown = [];
async function frame() {
  const now = performance.now();
  owed = Math.min(owed + (now - clock) * 0.06, 6);
  clock = now;
  const steps = Math.floor(owed);
  if (running && steps > 0) {
    owed -= steps;
    const [width, height] = size.value.split('x').map(Number);
    const input = { steps, buttons: held | touched, turn, raise, width, height, filter: filter.value, affine: affine.checked };
    [turn, raise] = [0, 0];
    let drawn;
    try { drawn = await call('frame', input); } catch (error) { tell(counter, error); return; }
    show(canvas, { ...drawn, width, height });
    shown.push(performance.now());
    while (shown[0] < shown.at(-1) - 1000) shown.shift();
    counter.textContent = `${shown.length} frames/s · ${drawn.ms.toFixed(1)} ms a frame · ${number(drawn.pixels * TAPS[filter.value] / 1000)} thousand texels · ${drawn.triangles} triangles`;
    main.dataset.frames = String(Number(main.dataset.frames ?? 0) + 1);
  }
  requestAnimationFrame(frame);
}

async function record({ target }) {
  target.disabled = true;
  running = false;
  recorded.textContent = 'playing …';
  const [width, height] = size.value.split('x').map(Number);
  recorded.className = 'hash';
  try {
    const { hash, ms, frames } = await call('play', { width, height, every: 1 });
    const native = (await hashes)[`doom ${width}x${height}`]?.[0];
    const same = native ? (native === hash ? ' the bytes of the native program' : ` native: ${native}`) : '';
    recorded.textContent = `${frames} frames in ${(ms / 1000).toFixed(2)} s: ${(1000 * frames / ms).toFixed(1)} frames/s. Last frame ${hash}${same}`;
    recorded.className = native ? `hash ${native === hash ? 'same' : 'differs'}` : 'hash';
    main.dataset.recorded = hash;
    main.dataset.rate = String(1000 * frames / ms);
  } catch (error) {
    tell(recorded, error);
  } finally {
    running = true;
    target.disabled = false;
  }
}

try {
  await call('room', { files: FILES });
  frame();
} catch (error) {
  tell(counter, error);
}
main.dataset.state = 'ready';
