// The engine of the applets: controls from a list, a request from their values, pictures and figures from the answer.

import { add, call, dragged, hashes, make, number, save, show, start } from './lab.js';
import { defaults, quick } from './values.js';

start();

const main = document.querySelector('main');
const name = main.dataset.page;
const { default: page } = await import(`./applets/${name}.js`);
const values = defaults(page);
const form = make('form', { 'aria-label': 'Controls', onsubmit: (event) => event.preventDefault() });
const panels = make('div', { class: 'panels' + (page.even ? ' even' : '') });
const figures = make('table', {});
const words = make('p', { class: 'soft', role: 'status' });
const source = make('pre', {});
const own = new Set();

main.append(
  make('h1', {}, page.title),
  make('p', { class: 'soft' }, page.slide),
  ...page.text.map((text) => make('p', {}, text)),
  make('div', { class: 'formula' }, page.formula),
  make('div', { class: 'lab' }, make('div', {}, panels, words), make('div', {}, form, figures)),
  make('details', {}, make('summary', {}, 'The scene and its command'), source),
);

// A canvas with its handles for each picture.
const stages = [];
function stage(index) {
  while (stages.length <= index) {
    const canvas = make('canvas', { role: 'img' });
    const box = make('div', { class: 'stage' }, canvas);
    const caption = make('figcaption', {});
    panels.append(make('figure', {}, box, caption));
    stages.push({ canvas, box, caption });
    const number = stages.length - 1;
    page.controls.filter((control) => control.kind === 'points' && (control.panel ?? 0) === number).forEach((control) => handles(control, box));
    if (number === 0 && page.drag) drag(box);
  }
  return stages[index];
}

function handles(control, box) {
  control.handles = control.value.map((_, i) => {
    const put = (x, y) => {
      values[control.id][i] = [Math.min(1, Math.max(0, x)), Math.min(1, Math.max(0, y))];
      place(control);
      changed();
    };
    const handle = make('button', { type: 'button', class: 'handle', 'aria-label': `${control.label} ${control.names?.[i] ?? i + 1}: arrow keys move it`,
      'data-control': control.id, onkeydown: (event) => {
        const step = event.shiftKey ? 0.05 : 0.01;
        const way = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
        if (!way) return;
        event.preventDefault();
        const [x, y] = values[control.id][i];
        put(x + way[0], y + way[1]);
      } }, control.names?.[i] ?? String(i + 1));
    dragged(handle, (press) => {
      press.preventDefault();
      press.stopPropagation();
      handle.focus();
      return (event) => {
        const rect = box.getBoundingClientRect();
        put((event.clientX - rect.left) / rect.width, (event.clientY - rect.top) / rect.height);
      };
    });
    box.append(handle);
    return handle;
  });
  place(control);
}

function place(control) {
  control.handles?.forEach((handle, i) => {
    const [x, y] = values[control.id][i];
    handle.style.left = `${100 * x}%`;
    handle.style.top = `${100 * y}%`;
  });
}

// Dragging the picture moves two sliders.
function drag(box) {
  dragged(box, (press) => {
    let [x, y] = [press.clientX, press.clientY];
    return (event) => {
      for (const [id, way] of [[page.drag[0], x - event.clientX], [page.drag[1], event.clientY - y]]) {
        const control = page.controls.find((control) => control.id === id);
        if (!control) continue;
        const value = values[id] + way * (control.max - control.min) / 600;
        control.set(Math.min(control.max, Math.max(control.min, value)));
      }
      [x, y] = [event.clientX, event.clientY];
      changed();
    };
  });
}

for (const control of page.controls) {
  const id = `control-${control.id}`;
  if (control.kind === 'range') {
    const shown = make('output', { for: id });
    const input = make('input', { type: 'range', id, 'data-control': control.id, min: String(control.min), max: String(control.max), step: String(control.step ?? 'any'), value: String(control.value) });
    const tell = () => { shown.textContent = `${number(values[control.id])}${control.unit ? ` ${control.unit}` : ''}`; };
    control.set = (value) => { values[control.id] = value; input.value = String(value); tell(); };
    input.addEventListener('input', () => { values[control.id] = Number(input.value); tell(); changed(); });
    tell();
    // The label's own control: without `for` it would be the output, which comes first.
    form.append(make('label', { for: id }, control.label, shown, input));
  } else if (control.kind === 'choice') {
    const select = make('select', { id, 'data-control': control.id });
    for (const option of control.options) {
      const [value, text] = Array.isArray(option) ? option : [option, option];
      select.append(make('option', { value, selected: value === control.value }, text));
    }
    control.set = (value) => { values[control.id] = value; select.value = value; };
    select.addEventListener('change', () => {
      values[control.id] = select.value;
      page.controls.find(({ id }) => id === control.clears)?.set('');
      changed();
    });
    form.append(make('label', {}, control.label, select));
  } else if (control.kind === 'check') {
    const input = make('input', { type: 'checkbox', id, 'data-control': control.id, checked: control.value });
    input.addEventListener('change', () => { values[control.id] = input.checked; changed(); });
    form.append(make('label', { class: 'check' }, input, control.label));
  } else if (control.kind === 'picture' || control.kind === 'files') {
    const many = control.kind === 'files';
    const input = make('input', { type: 'file', id, multiple: many, ...(many ? {} : { accept: 'image/*' }) });
    const take = (files) => files.length && (many ? scene(control, files) : picture(control, files[0]));
    input.addEventListener('change', () => take([...input.files]));
    control.set = (value) => { values[control.id] = value; input.value = ''; given++; };
    form.append(make('label', {}, control.label, input));
    document.addEventListener('drop', (event) => take([...event.dataTransfer.files]));
  }
}
form.append(make('div', {}, make('button', { type: 'button', id: 'reset', onclick: reset }, 'Reset'), ' ',
  make('button', { type: 'button', id: 'save', onclick: async () => save(`${name}.png`, await call('png', { panel: 0 }), 'image/png') }, 'Download PNG')));

// Width and height of the user's pictures, by name.
const sizes = {};
let given = 0;
// Files that are being read: until then the page is busy.
let taking = 0;
async function picture(control, file) {
  // A name of its own for each file: the old picture stays until the new one is there, and of two that come together the later one wins.
  const mine = ++given;
  const [ending] = file.name.match(/\.[A-Za-z0-9]{1,5}$/) ?? [''];
  const known = `own-${mine}${ending}`;
  let note = '';
  let size = null;
  taking++;
  main.dataset.state = 'busy';
  try {
    const bytes = await file.arrayBuffer();
    await call('add', { name: known, bytes }, [bytes]);
    // The module refuses what is no picture; of others the corners tell the size.
    const request = { kind: 'rectify', photo: known, from: [[0, 0], [1, 0], [1, 1], [0, 1]], size: [1, 1], filter: 'nearest', shown: 64 };
    const { figures } = await call('ask', { request });
    size = figures.filter((figure) => figure.unit === 'point').slice(4, 6).map((figure) => figure.value);
  } catch (error) {
    note = `${file.name}: ${error.message.replace(/^texture\.scene:[\d:]+ /, '').replace(`${known}: `, '')}`;
  }
  taking--;
  if (size && mine === given) {
    own.add(known);
    sizes[known] = size;
    values[control.id] = known;
  } else call('remove', { name: known }).catch(() => {});
  changed(mine === given ? note : noted);
}

// A scene or model with its files; maps that come later belong to the one that is shown.
async function scene(control, files) {
  taking++;
  main.dataset.state = 'busy';
  const { names, main: first, note } = await add(files).catch((error) => ({ names: [], note: error.message }));
  taking--;
  names.forEach((name) => own.add(name));
  if (first) values[control.id] = first;
  changed(note);
}

function reset() {
  for (const [id, value] of Object.entries(defaults(page))) {
    const control = page.controls.find((control) => control.id === id);
    values[id] = value;
    if (control.kind === 'check') form.querySelector(`#control-${id}`).checked = value;
    else control.set?.(value);
    place(control);
  }
  changed();
}

// Controls that another one switches off.
function match() {
  for (const { id, when } of page.controls) {
    if (!when) continue;
    const element = form.querySelector(`[data-control="${id}"]`);
    element.disabled = !Object.entries(when).every(([other, wanted]) => [wanted].flat().includes(values[other]));
  }
}

// One request at a time; a quick one without its reference while controls move, the whole when they rest.
let busy = false;
let pending = null;
let took = 0;
let resting = 0;
// A note stays until something changes again.
let noted = '';
function changed(note = '') {
  noted = note;
  match();
  main.dataset.state = 'busy';
  clearTimeout(resting);
  if (took < 60) return draw(true);
  draw(false);
  resting = setTimeout(() => draw(true), 180);
}

async function draw(all) {
  if (busy) { pending = all || pending === true; return; }
  busy = true;
  const drawn = structuredClone(values);
  let whole = all;
  try {
    const asked = page.request(drawn, sizes);
    const short = quick(page, asked);
    whole ||= !short;
    const request = whole ? asked : short;
    const files = page.files(drawn).filter((file) => !own.has(file));
    const answer = await call('ask', { files, request });
    if (all) took = answer.ms;
    // Pictures that were replaced are let go.
    for (const old of Object.keys(sizes).filter((old) => !Object.values(values).includes(old))) {
      delete sizes[old];
      call('remove', { name: old }).catch(() => {});
    }
    tell(answer, request, whole, drawn);
  } catch (error) {
    words.className = 'error';
    words.textContent = [noted, error.message].filter(Boolean).join('\n');
  }
  busy = false;
  if (pending !== null) {
    const next = pending;
    pending = null;
    draw(next);
  } else if (whole && !taking) {
    main.dataset.state = 'ready';
    main.dataset.draws = String(Number(main.dataset.draws ?? 0) + 1);
  }
}

let told = 0;
async function tell(answer, request, all, drawn) {
  const mine = ++told;
  const resting = JSON.stringify(drawn) === JSON.stringify(defaults(page));
  answer.panels.forEach((panel, i) => {
    const { canvas, caption } = stage(i);
    show(canvas, panel);
    canvas.setAttribute('aria-label', panel.name);
    canvas.dataset.hash = panel.hash;
    caption.replaceChildren(panel.name);
  });
  words.className = noted ? 'error' : 'soft';
  words.textContent = (noted && `${noted}\n`) + [`${Math.round(answer.ms)} ms`, ...answer.warnings].join(' · ');
  if (!all) return;
  while (stages.length > answer.panels.length) stages.pop().box.parentElement.remove();
  figures.replaceChildren(...answer.figures.filter((figure) => !['point', 'camera'].includes(figure.unit)).map((figure) => make('tr', {},
    make('td', {}, figure.name), make('td', { class: 'number' }, `${number(figure.value)} ${figure.unit}`,
      ...(figure.expected === undefined ? [] : [make('br', {}), make('small', {}, `theory ${number(figure.expected)}`)])))));
  source.textContent = page.command ? page.command(drawn, answer) : request.text ? commandOf(request) : JSON.stringify(request, null, 1);
  answer.panels.forEach((panel, i) => stages[i].caption.append(make('span', { class: 'hash' }, ` ${panel.hash} `)));
  const known = (await hashes)[name];
  if (mine !== told) return;
  answer.panels.forEach((panel, i) => {
    if (resting && known?.[i]) {
      const same = known[i] === panel.hash;
      stages[i]?.caption.append(make('span', { class: same ? 'same' : 'differs' }, same ? 'the bytes of the native program' : `native: ${known[i]}`));
    }
  });
  if (resting && known) main.dataset.same = String(answer.panels.every((panel, i) => known[i] === panel.hash));
}

// The command of a scene and the files that it reads, which are no assets.
function commandOf(request) {
  const flags = ['interp', 'filter', 'wrap'].filter((flag) => request[flag]).map((flag) => ` --${flag} ${request[flag]}`).join('');
  const files = Object.entries({ 'page.scene': request.text, ...request.texts });
  return [`texmap render page.scene -o page.png --resolution ${request.size?.join('x')}${flags}\n${page.remark ? `# ${page.remark}\n` : ''}`, ...files.map(([name, text]) => `${name}:\n${text}`)].join('\n');
}

// The first picture does not wait for its reference.
main.dataset.state = 'busy';
match();
if (quick(page, page.request(values))) draw(false);
draw(true);
