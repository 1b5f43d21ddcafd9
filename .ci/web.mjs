// The pages of web/dist in a headless Chromium: every page opens, every control changes its picture, the pictures of the first values have
// the hashes of the native program, on both builds of the module; nothing is asked from elsewhere, no error is logged.
//   node .ci/web.mjs FOLDER [--shots DIR] [--short] [PAGE...]
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { mkdirSync, readFileSync, existsSync, statSync } from 'node:fs';
import { join, normalize } from 'node:path';

const { chromium } = createRequire(new URL('../web/', import.meta.url))('playwright-core');
const args = process.argv.slice(2);
const taken = (flag) => { const i = args.indexOf(flag); return i < 0 ? null : args.splice(i, 2)[1]; };
const shots = taken('--shots');
const short = args.includes('--short') && args.splice(args.indexOf('--short'), 1);
const [root, ...wanted] = args;
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
const hashes = JSON.parse(readFileSync(join(root, 'hashes.json'), 'utf8'));
const names = wanted.length ? wanted : ['index', ...list];
const faults = [];
const fault = (page, text) => { faults.push(`${page}: ${text}`); console.error(`web: ${page}: ${text}`); };

async function open(name, { query = '', width = 1280, height = 960, dark = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: dark ? 'dark' : 'light', hasTouch: width < 600, isMobile: width < 600 });
  const page = await context.newPage();
  page.on('console', (message) => { if (message.type() === 'error') fault(name, `console: ${message.text()}`); });
  page.on('pageerror', (error) => fault(name, `error: ${error.message}`));
  page.on('request', (request) => { if (!/^(blob|data):/.test(request.url()) && !request.url().startsWith(`${site}/`)) fault(name, `asks ${request.url()}`); });
  await page.goto(`${site}/${name}.html${query}`);
  await ready(page);
  return { page, context };
}
const ready = (page) => page.waitForFunction(() => document.querySelector('main').dataset.state === 'ready', null, { timeout: 120000 });
const pictures = (page) => page.$$eval('canvas', (all) => all.map((canvas) => canvas.dataset.hash).join());
const words = (page) => page.$eval('.error', (p) => p.textContent).catch(() => null);

/// Moves a control to another value; false where it cannot move.
async function move(page, control) {
  const at = `[data-control="${control}"]`;
  const kind = await page.$eval(at, (e) => (e.tagName === 'SELECT' ? 'select' : e.type));
  if (await page.$eval(at, (e) => e.disabled)) return false;
  if (kind === 'select') await page.$eval(at, (e) => { e.selectedIndex = (e.selectedIndex + 1) % e.options.length; e.dispatchEvent(new Event('change', { bubbles: true })); });
  else if (kind === 'checkbox') await page.$eval(at, (e) => e.click());
  else if (kind === 'range') await page.$eval(at, (e) => { const span = e.max - e.min; e.value = Number(e.value) + (Number(e.value) - e.min > span / 2 ? -0.3 : 0.3) * span; e.dispatchEvent(new Event('input', { bubbles: true })); });
  else { await page.focus(at); for (let i = 0; i < 5; i++) await page.keyboard.press('ArrowRight'); }
  return true;
}

/// The page of an applet: hashes first, then every control.
async function applet(name) {
  const { default: definition } = await import(new URL(`../web/pages/applets/${name}.js`, import.meta.url));
  const { page, context } = await open(name);
  const took = await page.evaluate(() => performance.now());
  const error = await words(page);
  if (error) fault(name, error);
  const shown = (await pictures(page)).split(',');
  for (const [i, hash] of shown.entries()) if (hash !== hashes[name]?.[i]) fault(name, `picture ${i} is ${hash}, natively ${hashes[name]?.[i]}`);
  if (shots) await page.screenshot({ path: join(shots, `${name}.png`), fullPage: true });
  let moved = 0;
  for (const control of short ? [] : definition.controls.filter((control) => control.kind !== 'picture')) {
    for (const [other, wanted] of Object.entries(control.when ?? {})) {
      await page.selectOption(`[data-control="${other}"]`, String([wanted].flat()[0]));
      await ready(page);
    }
    const before = await pictures(page);
    await move(page, control.id);
    await page.waitForTimeout(30);
    await ready(page);
    const error = await words(page);
    if (error) fault(name, `${control.id}: ${error}`);
    if ((await pictures(page)) === before) fault(name, `${control.id} changes nothing`);
    moved++;
    await page.click('#reset');
    await page.waitForTimeout(30);
    await ready(page);
  }
  if (!short && (await pictures(page)) !== shown.join()) fault(name, 'reset does not bring the first pictures back');
  console.log(`web: ${name}: ${shown.length} pictures, ${moved} controls, ready after ${Math.round(took)} ms`);
  await context.close();
  if (!short) {
    const plain = await open(name, { query: '?simd=0' });
    const other = await pictures(plain.page);
    if (other !== shown.join()) fault(name, `without simd128: ${other}`);
    await plain.context.close();
  }
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
  for (const size of short ? ['640x400'] : ['640x400', '1280x720']) {
    await page.selectOption('#size', size);
    await page.$eval('main', (main) => delete main.dataset.recorded);
    await page.click('#record');
    await page.waitForFunction(() => document.querySelector('main').dataset.recorded, null, { timeout: 240000 });
    const { recorded, rate } = await page.$eval('main', (main) => ({ ...main.dataset }));
    if (size === '640x400' && recorded !== hashes.doom?.[0]) fault('doom', `the last frame is ${recorded}, natively ${hashes.doom?.[0]}`);
    console.log(`web: doom: ${size}: ${Number(rate).toFixed(1)} frames a second`);
  }
  await context.close();
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
  console.log('web: scene: own file drawn, downloaded, a bad one told');
  await context.close();
}

async function chart() {
  const { page, context } = await open('chart');
  if (shots) await page.screenshot({ path: join(shots, 'chart.png'), fullPage: true });
  const before = await pictures(page);
  await page.click('circle[data-point="8"]');
  if ((await pictures(page)) === before) fault('chart', 'a point shows no picture');
  await page.selectOption('#panel', 'interpolation');
  await page.waitForTimeout(50);
  await ready(page);
  if (shots) await page.screenshot({ path: join(shots, 'chart-interpolation.png'), fullPage: true });
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
for (const name of names) await (special[name] ?? applet)(name).catch((error) => fault(name, error.message));
if (shots) {
  for (const name of ['index', 'affine', 'doom']) {
    for (const [label, view] of [['phone', { width: 390, height: 844 }], ['dark', { dark: true }]]) {
      const { page, context } = await open(name, view);
      await page.screenshot({ path: join(shots, `${name}-${label}.png`), fullPage: label === 'phone' });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (wide > 1) fault(name, `${label}: ${wide} pixels too wide`);
      await context.close();
    }
  }
}
await browser.close();
server.close();
console.log(`web: ${names.length} pages, ${faults.length} faults`);
process.exitCode = faults.length ? 1 : 0;
