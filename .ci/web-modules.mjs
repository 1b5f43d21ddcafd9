// The modules of web/dist without a browser: both builds answer the requests of all applets, with their first values and after a move of
// each control, and play the recorded walk; every picture must have the hash of the native program.
//   node .ci/web-modules.mjs FOLDER [--first] [BUILD...]     default: simd plain; --first: no moves
import { existsSync, readFileSync } from 'node:fs';
import { execFileSync } from 'node:child_process';
import { join, resolve } from 'node:path';

const args = process.argv.slice(2);
const first = args.includes('--first') && args.splice(args.indexOf('--first'), 1);
const [folder, ...wanted] = args;
const root = resolve(folder);
const read = (path) => JSON.parse(readFileSync(new URL(`../web/${path}`, import.meta.url), 'utf8'));
const hashes = { ...read('hashes.json'), ...read('moves.json') };
const all = JSON.parse(execFileSync('node', [new URL('../web/requests.mjs', import.meta.url).pathname]));
const requests = Object.fromEntries(Object.entries(all).filter(([key]) => !first || !key.includes('/')));
// File names in a request: those of web/pages/applets, below assets.
const named = (text) => [...text.matchAll(/(?:models|textures|photos)\/[\w./-]+/g)].map(([name]) => name).flatMap((name) => (name.endsWith('.obj') ? [name, name.replace('.obj', '.mtl')] : [name]));
const walks = Object.keys(hashes).filter((key) => key.startsWith('doom '));
const filesOfWalks = ['textures/carpet.gif', 'textures/ceilingtile.gif', 'textures/walls.gif', 'textures/fence.png', 'textures/leaf.png', 'textures/cow.png', 'models/cow.obj', 'models/cow.mtl'];
let faults = 0;
for (const name of wanted.length ? wanted : ['simd', 'plain']) {
  // As text, for a folder that says of no script whether it is a module.
  const wasm = await import(`data:text/javascript,${encodeURIComponent(readFileSync(join(root, 'wasm', `${name}.js`), 'utf8'))}`);
  await wasm.default({ module_or_path: readFileSync(join(root, 'wasm', `${name}_bg.wasm`)) });
  const lab = new wasm.Lab();
  const held = new Set();
  const hold = (files) => files.filter((file) => !held.has(file) && existsSync(join(root, 'assets', file))).forEach((file) => { lab.add(file, readFileSync(join(root, 'assets', file))); held.add(file); });
  const compare = (key, shown) => { if (shown.join() !== hashes[key]?.join()) { faults++; console.error(`web: ${name}: ${key}: ${shown}, natively ${hashes[key]}`); } };
  const began = performance.now();
  for (const [key, request] of Object.entries(requests)) {
    const text = JSON.stringify(request);
    hold(named(text));
    try { compare(key, JSON.parse(lab.ask(text)).panels.map(({ hash }) => hash)); } catch (error) { faults++; console.error(`web: ${name}: ${key}: ${error}`); }
  }
  hold(filesOfWalks);
  for (const key of walks) {
    const [width, height] = key.slice(5).split('x').map(Number);
    compare(key, [lab.room().play(width, height, 0)]);
  }
  console.log(`web: ${name}: ${Object.keys(requests).length + walks.length} requests without a browser, ${((performance.now() - began) / 1000).toFixed(1)} s`);
}
process.exitCode = faults ? 1 : 0;
