// Speed against accuracy, measured in this browser: a point for each method, its picture behind it.

import { call, make, number, show, start, tell } from './lab.js';
import { affineError, plane, quad, v } from './applets/scenes.js';

start();

const main = document.querySelector('main');
const SIZE = [320, 240];
const corners = quad([[0.06, 0.05], [0.94, 0.35], [0.94, 0.65], [0.06, 0.95]], 4 / 3);
const PANELS = {
  filters: { text: plane(2, 8, 'texture textures/checker.png'), methods: ['nearest', 'bilinear', 'bicubic:mitchell', 'mip-nearest', 'bilinear-mip-nearest', 'trilinear', 'anisotropic:2', 'anisotropic:4', 'anisotropic:16', 'ewa:4', 'ewa:16'].map((filter) => ({ filter })),
    reference: { filter: 'trilinear', supersample: 8 }, error: 'RMSE of the colours' },
  interpolation: { text: `eye 0 0 0\nlook 0 0 -1\nfov 90\nbackground 0.8 0.85 0.9\nfilter nearest\ntexture textures/checker.png\n${v(...corners.points)}\ntf 0 0 0 1 1 0 2 1 1 3 0 1\n`,
    methods: ['affine', 'subdivided:2', 'subdivided:4', 'subdivided:8', 'span:64', 'span:16', 'span:8', 'within:1', 'within:0.1', 'perspective'].map((interp) => ({ interp })),
    reference: { interp: 'perspective' }, texels: [256, 256], error: 'largest shift of the texture', affine: affineError(corners.w, [256, 256]) },
};
const choice = make('select', { id: 'panel', 'data-control': 'panel' }, make('option', { value: 'filters' }, 'filters on a tilted plane'), make('option', { value: 'interpolation' }, 'interpolation of a quad'));
const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
for (const [name, value] of [['width', '100%'], ['role', 'img'], ['aria-label', 'Time against error']]) svg.setAttribute(name, value);
const canvas = make('canvas', { role: 'img', 'aria-label': 'picture of the chosen method' });
const caption = make('figcaption', {});
const table = make('table', {});
const words = make('p', { role: 'status' });
main.append(
  make('h1', {}, 'Speed against accuracy'),
  make('p', { class: 'soft' }, 'Every method of a scene, timed in this browser: left is faster, lower is more accurate. A time is that of a whole request: reading the scene and decoding its texture are in it, the same for every method. Choose a point for its picture.'),
  make('div', { class: 'lab' }, make('div', {}, svg, make('figure', {}, make('div', { class: 'stage' }, canvas), caption), words),
    make('div', {}, make('form', { 'aria-label': 'Controls', onsubmit: (event) => event.preventDefault() }, make('label', {}, 'Scene', choice), make('button', { type: 'button', onclick: begin }, 'Measure again')), table)),
);

let run = 0;
let chosen = 0;
async function measure(mine) {
  main.dataset.state = 'busy';
  const panel = PANELS[choice.value];
  const points = [];
  const files = ['textures/checker.png'];
  const ask = (method) => ({ kind: 'draw', file: 'page.scene', text: panel.text, size: SIZE, ...method });
  // The first picture does not wait for its reference.
  const first = await call('ask', { files, request: ask(panel.methods[0]) });
  if (mine !== run) return;
  show(canvas, first.panels[0]);
  for (const method of panel.methods) {
    const request = ask(method);
    const full = await call('ask', { files, request: { ...request, texels: panel.texels, reference: panel.reference } });
    const times = [];
    for (let i = 0; i < 5; i++) times.push((await call('ask', { files, request })).ms);
    if (mine !== run) return;
    const figure = full.figures.find((figure) => figure.name === panel.error);
    points.push({ name: method.filter ?? method.interp, ms: Math.min(...times), error: figure.value, unit: figure.unit, panel: full.panels[0] });
    plot(points, panel);
    if (points.length === 1) pick(points, 0);
  }
  main.dataset.state = 'ready';
  main.dataset.points = String(points.length);
}

const shape = (tag, attributes, text = '') => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  return element;
};

function plot(points, panel) {
  // Narrow pages have a narrow chart: a small one of a wide chart could not be read.
  const wide = Math.max(320, Math.min(560, svg.clientWidth));
  svg.setAttribute('viewBox', `0 0 ${wide} 340`);
  const least = Math.max(1e-4, Math.min(...points.filter((p) => p.error > 0).map((p) => p.error)) / 2);
  const log = (p) => Math.log10(Math.max(p.error, least));
  const most = { ms: Math.max(...points.map((p) => p.ms)) * 1.15, error: Math.max(...points.map(log)) + 0.1 };
  const low = Math.log10(least) - 0.1;
  const at = (p) => [60 + (wide - 90) * p.ms / most.ms, 300 - 270 * (log(p) - low) / Math.max(0.2, most.error - low)];
  const axis = [shape('path', { d: `M60 20V300H${wide - 15}`, fill: 'none', class: 'axis' }), shape('text', { x: 60, y: 330 }, '0'), shape('text', { x: wide - 20, y: 330, 'text-anchor': 'end' }, `${number(most.ms / 1.15)} ms a frame →`), shape('text', { x: 4, y: 13 }, `${panel.error} (log), ${points[0].unit}`)];
  for (let power = Math.ceil(low); power <= most.error; power++) {
    const y = 300 - 270 * (power - low) / Math.max(0.2, most.error - low);
    axis.push(shape('path', { d: `M60 ${y}H${wide - 15}`, class: 'axis' }), shape('text', { x: 54, y: y + 4, 'text-anchor': 'end' }, String(Number((10 ** power).toPrecision(1)))));
  }
  svg.replaceChildren(...axis);
  // A name stands where it covers no dot and no other name, right of its dot if it can.
  const taken = points.map(at).map(([x, y]) => [x - 8, y - 8, x + 8, y + 8]);
  points.forEach((p, i) => {
    const [cx, cy] = at(p);
    const dot = shape('circle', { cx, cy, r: 7, tabindex: 0, role: 'button', 'aria-label': `${p.name}: ${number(p.ms)} ms, ${number(p.error)} ${p.unit}`, 'data-point': i, ...(i === chosen ? { class: 'on' } : {}) });
    dot.addEventListener('click', () => pick(points, i));
    dot.addEventListener('keydown', (event) => { if (['Enter', ' '].includes(event.key)) { event.preventDefault(); pick(points, i); } });
    const width = 7 * p.name.length;
    const places = [0, -14, 14, -28, 28, -42, 42].flatMap((rise) => [[cx + 11, cy + rise], [cx - 11 - width, cy + rise]]);
    const free = ([x, y]) => x > 62 && x + width < wide - 2 && y > 8 && y < 296 && !taken.some(([x0, y0, x1, y1]) => x < x1 && x + width > x0 && y - 7 < y1 && y + 7 > y0);
    const [x, y] = places.find(free) ?? [Math.min(cx + 11, wide - 4 - width), cy];
    taken.push([x, y - 7, x + width, y + 7]);
    svg.append(dot, shape('text', { x, y: y + 4 }, p.name));
  });
  table.replaceChildren(...points.map((p) => make('tr', {}, make('td', {}, p.name), make('td', { class: 'number' }, `${number(p.ms)} ms`), make('td', { class: 'number' }, `${number(p.error)} ${p.unit}`))));
}

function pick(points, i) {
  chosen = i;
  show(canvas, points[i].panel);
  canvas.dataset.hash = points[i].panel.hash;
  caption.textContent = `${points[i].name}: ${number(points[i].ms)} ms, ${panelError(points[i])}`;
  svg.querySelectorAll('circle').forEach((dot, k) => dot.classList.toggle('on', k === i));
}
const panelError = (p) => `error ${number(p.error)} ${p.unit}`;

/// Measures, and tells why it cannot.
async function begin() {
  const mine = ++run;
  words.textContent = '';
  try {
    await measure(mine);
  } catch (error) {
    if (mine !== run) return;
    tell(words, error);
    main.dataset.state = 'ready';
  }
}

choice.addEventListener('change', begin);
begin();
