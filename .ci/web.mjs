// The pages of web/dist in a headless Chromium: every page opens, every control changes its picture, the pictures of the first values have
// the hashes of the native program, on both builds of the module; nothing is asked from elsewhere, no error is logged.
//   node .ci/web.mjs FOLDER [--shots DIR] [--short] [PAGE...]
//   node .ci/web.mjs FOLDER --looks [--shots DIR] [PAGE...]     layouts alone
//   node .ci/web.mjs FOLDER first [RUNS] [PAGE...]     milliseconds to the first picture of each page, the least of the runs
//   node .ci/web.mjs FOLDER rates [RUNS]               frames a second of the recorded walk, the most of the runs
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { mkdirSync, readFileSync, existsSync, statSync } from 'node:fs';
import { join, normalize } from 'node:path';

const { chromium } = createRequire(new URL('../web/', import.meta.url))('playwright-core');
const args = process.argv.slice(2);
const taken = (flag) => { const i = args.indexOf(flag); return i < 0 ? null : args.splice(i, 2)[1]; };
const shots = taken('--shots');
const short = args.includes('--short') && args.splice(args.indexOf('--short'), 1);
const alone = args.includes('--looks') && args.splice(args.indexOf('--looks'), 1);
const [root, ...wanted] = args;
const timed = ['first', 'rates'].includes(wanted[0]) && wanted.shift();
const runs = timed && /^\d+$/.test(wanted[0]) ? Number(wanted.shift()) : timed === 'rates' ? 3 : 5;
if (shots) mkdirSync(shots, { recursive: true });
const kinds = { html: 'text/html', js: 'text/javascript', css: 'text/css', json: 'application/json', wasm: 'application/wasm', svg: 'image/svg+xml', png: 'image/png' };
const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(request.url.split('?')[0]));
  const file = join(root, path === '/' ? 'index.html' : path);
  if (!existsSync(file) || !statSync(file).isFile()) { response.writeHead(404).end(); return; }
  response.writeHead(200, { 'content-type': kinds[file.split('.').pop()] ?? 'application/octet-stream' }).end(readFileSync(file));
}).listen(0, '127.0.0.1');
await new Promise((resolve) => server.once('listening', resolve));
const site = `http://127.0.0.1:${server.address().port}`;

const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((path) => existsSync(path));
const browser = await chromium.launch({ executablePath, args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'] });
const list = JSON.parse(readFileSync(join(root, 'pages.json'), 'utf8')).map(({ name }) => name);
const { moves } = await import(new URL('../web/pages/values.js', import.meta.url));
const moved = JSON.parse(readFileSync(new URL('../web/moves.json', import.meta.url), 'utf8'));
const hashes = JSON.parse(readFileSync(join(root, 'hashes.json'), 'utf8'));
const names = wanted.length ? wanted : ['index', ...list];
const faults = [];
const fault = (page, text) => { faults.push(`${page}: ${text}`); console.error(`web: ${page}: ${text}`); };

async function open(name, { query = '', width = 1280, height = 960, dark = false, until = 'ready' } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: dark ? 'dark' : 'light', hasTouch: width < 600, isMobile: width < 600 });
  const page = await context.newPage();
  page.on('console', (message) => { if (message.type() === 'error') fault(name, `console: ${message.text()}`); });
  page.on('pageerror', (error) => fault(name, `error: ${error.message}`));
  page.on('request', (request) => { if (!/^(blob|data):/.test(request.url()) && !request.url().startsWith(`${site}/`)) fault(name, `asks ${request.url()}`); });
  await page.goto(`${site}/${name}.html${query}`);
  if (until === 'ready') await ready(page);
  else await page.waitForFunction(() => performance.getEntriesByName('first picture').length, null, { timeout: 120000 });
  return { page, context };
}
const ready = (page) => page.waitForFunction(() => document.querySelector('main').dataset.state === 'ready', null, { timeout: 120000 });
const pictures = (page) => page.$$eval('canvas', (all) => all.map((canvas) => canvas.dataset.hash).join());
const words = (page) => page.$eval('.error', (p) => p.textContent).catch(() => null);

const first = (page) => page.evaluate(() => Math.round(performance.getEntriesByName('first picture')[0]?.startTime ?? NaN));

/// Gives a control of an applet a value, as a user does.
async function set(page, control, value, from) {
  const at = `[data-control="${control.id}"]`;
  if (control.kind === 'picture') await page.setInputFiles(`#control-${control.id}`, join(root, 'assets', value));
  else if (control.kind === 'files') await page.setInputFiles(`#control-${control.id}`, [value, value.replace('.obj', '.mtl')].map((file) => join(root, 'assets', file)).filter(existsSync));
  else if (control.kind === 'choice') await page.selectOption(at, value);
  else if (control.kind === 'check') await page.setChecked(at, value);
  else if (control.kind === 'points') { await page.focus(at); for (let x = from[0][0]; x < value[0][0]; x += 0.01) await page.keyboard.press('ArrowRight'); }
  else await page.$eval(at, (e, value) => { e.value = String(value); e.dispatchEvent(new Event('input', { bubbles: true })); }, value);
  await page.waitForTimeout(30);
  await ready(page);
}

/// Sizes of the textures that pages offer, which figures in texels need.
const { texelsOf, texture } = await import(new URL('../web/pages/applets/scenes.js', import.meta.url));
for (const [file] of texture.options) {
  const header = readFileSync(join(root, 'assets', file));
  const size = [header.readUInt32BE(16), header.readUInt32BE(20)].join();
  if (texelsOf(file).join() !== size) fault('scenes.js', `${file} has ${size} texels, not ${texelsOf(file)}`);
}

/// The page of an applet: the hashes of its first pictures, then those after a move of each control.
async function applet(name) {
  const { default: definition } = await import(new URL(`../web/pages/applets/${name}.js`, import.meta.url));
  for (const query of short ? [''] : ['', '?simd=0']) {
    const label = query ? `${name} without simd128` : name;
    const { page, context } = await open(name, { query });
    const took = await first(page);
    const expect = async (key, what) => {
      const [shown, error] = [(await pictures(page)).split(','), await words(page)];
      if (error) fault(label, `${what}: ${error}`);
      // After a move those are known that need no reference: the first ones.
      const wanted = (key === name ? hashes : moved)[key];
      if (!wanted || shown.slice(0, wanted.length).join() !== wanted.join() || (key === name && shown.length !== wanted.length)) fault(label, `${what}: pictures ${shown}, natively ${wanted}`);
      return shown;
    };
    const shown = await expect(name, 'first values');
    if (!query && shots) await page.screenshot({ path: join(shots, `${name}.png`), fullPage: true });
    let count = 0;
    // The build without simd128 takes long in a browser: its moves are made without one (`.ci/web-modules.mjs`).
    for (const { control, before, after } of short || query ? [] : moves(definition)) {
      for (const other of definition.controls.filter(({ id }) => id in (control.when ?? {}))) await set(page, other, before[other.id]);
      const still = await pictures(page);
      await set(page, control, after[control.id], before[control.id]);
      const pictured = await expect(`${name}/${control.id}`, control.id);
      if (pictured.join() === still) fault(label, `${control.id} changes nothing`);
      count++;
      await page.click('#reset');
      await page.waitForTimeout(30);
      await ready(page);
    }
    if (count && (await pictures(page)) !== shown.join()) fault(label, 'reset does not bring the first pictures back');
    console.log(`web: ${label}: ${shown.length} pictures, ${count} controls moved, first picture after ${took} ms`);
    await context.close();
  }
}

/// Sizes of the recorded walk that have a native hash.
const WALKS = Object.keys(hashes).filter((key) => key.startsWith('doom ')).map((key) => key.slice(5));

/// Plays the recorded walk at a size, and returns its frames a second.
async function walk(page, size) {
  await page.selectOption('#size', size);
  await page.$eval('main', (main) => delete main.dataset.recorded);
  await page.click('#record');
  await page.waitForFunction(() => document.querySelector('main').dataset.recorded, null, { timeout: 240000 });
  const { recorded, rate } = await page.$eval('main', (main) => ({ ...main.dataset }));
  const wanted = hashes[`doom ${size}`][0];
  if (recorded !== wanted) fault('doom', `the last frame of ${size} is ${recorded}, natively ${wanted}`);
  return Number(rate);
}

async function rates() {
  const { page, context } = await open('doom');
  for (const size of WALKS) {
    const all = [];
    for (let run = 0; run < runs; run++) all.push((await walk(page, size)).toFixed(1));
    console.log(`web: doom: ${size}: ${Math.max(...all).toFixed(1)} frames a second (${all.join(', ')})`);
  }
  await context.close();
}

async function doom() {
  const { page, context } = await open('doom');
  await page.waitForFunction(() => Number(document.querySelector('main').dataset.frames) > 5);
  const grab = () => page.$eval('canvas', (canvas) => canvas.toDataURL());
  if (shots) await page.screenshot({ path: join(shots, 'doom.png'), fullPage: true });
  const still = await grab();
  await page.keyboard.down('KeyW');
  await page.waitForTimeout(600);
  await page.keyboard.up('KeyW');
  if ((await grab()) === still) fault('doom', 'walking changes nothing');
  await page.$eval('#affine', (box) => box.click());
  await page.waitForTimeout(400);
  if (shots) await page.screenshot({ path: join(shots, 'doom-affine.png') });
  // In scalar code the walk takes long; without a browser only its last frame is drawn.
  for (const size of short ? [] : WALKS) console.log(`web: doom: ${size}: ${(await walk(page, size)).toFixed(1)} frames a second`);
  // Frames come one after the other, also after walks; a second click on the button plays nothing more.
  await page.evaluate(() => {
    const post = Worker.prototype.postMessage;
    window.asked = { play: 0, frame: 0, most: 0 };
    Worker.prototype.postMessage = function (message, ...rest) {
      window.asked[message.command]++;
      if (message.command === 'frame') {
        window.asked.most = Math.max(window.asked.most, window.asked.frame);
        this.addEventListener('message', ({ data }) => { if (data.id === message.id) window.asked.frame--; });
      }
      return post.call(this, message, ...rest);
    };
  });
  await page.waitForTimeout(500);
  await page.$eval('#record', (button) => { button.click(); button.click(); });
  const { play, most } = await page.evaluate(() => window.asked);
  if (play !== 1 || most > 1) fault('doom', `two clicks play ${play} walks; ${most} frames are asked for at once`);
  await context.close();
}

/// Moves a control of the scene page to another value.
async function move(page, control) {
  const at = `[data-control="${control}"]`;
  if (await page.$eval(at, (e) => e.tagName === 'SELECT')) await page.$eval(at, (e) => { e.selectedIndex = (e.selectedIndex + 1) % e.options.length; e.dispatchEvent(new Event('change', { bubbles: true })); });
  else await page.$eval(at, (e) => { e.value = String(Number(e.value) + 0.3 * (e.max - e.min)); e.dispatchEvent(new Event('input', { bubbles: true })); });
}

async function scene() {
  const { page, context } = await open('scene');
  const before = await pictures(page);
  if (shots) await page.screenshot({ path: join(shots, 'scene.png'), fullPage: true });
  for (const control of short ? ['yaw'] : ['yaw', 'pitch', 'zoom', 'filter', 'interp', 'wrap', 'aov', 'size', 'file']) {
    const before = await pictures(page);
    await move(page, control);
    if (control === 'interp') await page.selectOption('#interp', 'affine');
    if (control === 'wrap') await page.selectOption('#wrap', 'clamp-to-border');
    await page.waitForTimeout(50);
    await ready(page);
    const error = await words(page);
    if (error) fault('scene', `${control}: ${error}`);
    if ((await pictures(page)) === before) fault('scene', `${control} changes nothing`);
  }
  // Another file is turned from its own first view.
  const turned = async () => {
    await move(page, 'yaw');
    await page.waitForTimeout(50);
    await ready(page);
    return page.$eval('pre', (pre) => pre.textContent);
  };
  await page.selectOption('#file', 'models/cow.obj');
  const chosen = await turned();
  await page.click('#reset');
  await page.waitForTimeout(50);
  await ready(page);
  if (!chosen.includes('models/cow.obj') || (await turned()) !== chosen) fault('scene', `a second file is turned from another view: ${chosen}`);
  // A file of the user, and its download.
  await page.setInputFiles('#files', [{ name: 'own.obj', mimeType: 'text/plain', buffer: Buffer.from('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n') }]);
  await page.waitForTimeout(50);
  await ready(page);
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save')]);
  const bytes = readFileSync(await download.path());
  if (bytes.toString('latin1', 1, 4) !== 'PNG') fault('scene', 'the download is no PNG');
  if (await words(page)) fault('scene', `own.obj: ${await words(page)}`);
  if (shots) await page.screenshot({ path: join(shots, 'scene-own.png'), fullPage: true });
  // A bad file tells its line.
  await page.setInputFiles('#files', [{ name: 'bad.scene', mimeType: 'text/plain', buffer: Buffer.from('v 0 0 0\nf 0 1 2\n') }]);
  await page.waitForTimeout(50);
  await ready(page);
  if (!(await words(page))?.includes('bad.scene:2')) fault('scene', `a bad file tells ${await words(page)}`);
  if (before === '') fault('scene', 'no picture');
  // So does one that is none, beside the picture of the file before.
  await page.selectOption('#file', 'models/cow.obj');
  await page.waitForTimeout(50);
  await ready(page);
  await page.setInputFiles('#files', [{ name: 'pack.zip', mimeType: 'application/zip', buffer: Buffer.from('PK') }]);
  await page.waitForTimeout(50);
  await ready(page);
  if (!(await words(page))?.includes('pack.zip: not a scene, model or picture')) fault('scene', `pack.zip tells ${await words(page)}`);
  console.log('web: scene: own file drawn, downloaded, a bad one told');
  await context.close();
}

async function chart() {
  const { page, context } = await open('chart');
  if (shots) await page.screenshot({ path: join(shots, 'chart.png'), fullPage: true });
  for (const panel of ['filters', 'interpolation']) {
    if (panel !== 'filters') {
      await page.selectOption('#panel', panel);
      await page.waitForTimeout(50);
      await ready(page);
      if (shots) await page.screenshot({ path: join(shots, `chart-${panel}.png`), fullPage: true });
    }
    const points = Number(await page.$eval('main', (main) => main.dataset.points));
    const behind = new Set();
    for (let i = 0; i < points; i++) {
      const name = await page.$eval(`circle[data-point="${i}"]`, (dot) => { dot.focus(); return dot.getAttribute('aria-label').split(':').slice(0, -1).join(':'); });
      await page.keyboard.press('Enter');
      behind.add(await pictures(page));
      const caption = await page.$eval('figcaption', (caption) => caption.textContent);
      if (!caption.startsWith(name)) fault('chart', `point ${name} shows "${caption}"`);
    }
    // Two methods may give the same bytes, as small spans do.
    if (behind.size < points - 2) fault('chart', `${panel}: ${behind.size} pictures behind ${points} points`);
  }
  console.log(`web: chart: ${await page.$eval('main', (main) => main.dataset.points)} points`);
  await context.close();
}

async function index() {
  const { page, context } = await open('index');
  const links = await page.$$eval('.cards a', (all) => all.map((a) => a.getAttribute('href')));
  if (links.length !== list.length) fault('index', `${links.length} links for ${list.length} pages`);
  if (shots) await page.screenshot({ path: join(shots, 'index.png'), fullPage: true });
  await context.close();
}

const special = { doom, scene, chart, index };
if (timed === 'rates') await rates();
else if (timed) {
  for (const name of names.filter((name) => name !== 'index')) {
    const times = [];
    for (let run = 0; run < runs; run++) {
      const { page, context } = await open(name, { until: 'first' });
      times.push(await first(page));
      await context.close();
    }
    console.log(`web: ${name}: first picture after ${Math.min(...times)} ms (${times.join(', ')})`);
  }
} else if (!alone) for (const name of names) await (special[name] ?? applet)(name).catch((error) => fault(name, error.message));

/// Faults of the looks of a page, found by its layout: too wide, text cut, a control without a name or out of the keyboard's reach, faint text.
function looks() {
  const found = [];
  const say = (element, text) => found.push(`${element.tagName.toLowerCase()}${element.id ? `#${element.id}` : ''} "${(element.textContent ?? '').trim().slice(0, 30)}": ${text}`);
  const wide = document.documentElement.scrollWidth - innerWidth;
  if (wide > 1) found.push(`${wide} pixels too wide`);
  const seen = (element) => element.checkVisibility() && element.getClientRects().length > 0;
  for (const element of [...document.querySelectorAll('button, select, input, canvas, a, summary, [role=button]')].filter(seen)) {
    const name = element.getAttribute('aria-label') || element.textContent.trim() || [...(element.labels ?? [])].map((label) => label.textContent.trim()).join(' ');
    if (!name) say(element, 'no accessible name');
    if (element.matches('button, select, input, summary, [role=button]') && element.tabIndex < 0) say(element, 'out of reach of the keyboard');
    const box = element.getBoundingClientRect();
    if (element.matches('button, select, input[type=file], .handle') && Math.min(box.width, box.height) < 24) say(element, `${Math.round(box.width)} x ${Math.round(box.height)} pixels are small for a finger`);
  }
  const light = (rgb) => rgb.map((c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4).reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const parts = (color) => color.match(/[\d.]+/g).map(Number);
  const paper = (element) => { for (; element; element = element.parentElement) { const [r, g, b, a = 1] = parts(getComputedStyle(element).backgroundColor); if (a === 1) return [r, g, b]; } return [255, 255, 255]; };
  for (const element of [...document.querySelectorAll('h1, p, td, small, label, output, button, select, figcaption, .formula, pre, summary, a, b, span')].filter(seen)) {
    if (!element.textContent.trim() || element.disabled || element.matches('.handle')) continue;
    const [ink, ground] = [light(parts(getComputedStyle(element).color).slice(0, 3)), light(paper(element))];
    const ratio = (Math.max(ink, ground) + 0.05) / (Math.min(ink, ground) + 0.05);
    if (ratio < 4.5) say(element, `contrast ${ratio.toFixed(1)}`);
    if (element.scrollWidth > element.clientWidth + 1 && element.clientWidth && !['auto', 'scroll'].includes(getComputedStyle(element).overflowX)) say(element, 'cut or too wide');
  }
  for (const text of document.querySelectorAll('svg text')) {
    const [box, all] = [text.getBBox(), text.ownerSVGElement.viewBox.baseVal];
    if (box.x < 0 || box.y < 0 || box.x + box.width > all.width || box.y + box.height > all.height) say(text, 'beyond the chart');
  }
  return found;
}
for (const name of short || timed ? [] : names) {
  for (const [label, view] of [['desktop', {}], ['desktop-dark', { dark: true }], ['phone', { width: 390, height: 844 }], ['phone-dark', { width: 390, height: 844, dark: true }]]) {
    const { page, context } = await open(name, view);
    for (const text of await page.evaluate(looks)) fault(name, `${label}: ${text}`);
    // Those of the desktop are taken by the checks of the pages, where these run.
    if (shots && (alone || label !== 'desktop')) await page.screenshot({ path: join(shots, `${name}-${label}.png`), fullPage: true });
    await context.close();
  }
}
await browser.close();
server.close();
console.log(`web: ${names.length} pages, ${faults.length} faults`);
process.exitCode = faults.length ? 1 : 0;
