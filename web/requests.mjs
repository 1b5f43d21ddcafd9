// Prints the requests of all applets with their first values, by name, and those after one move of each control, by
// `name/control` and without references: the input of the program `native`, which makes `hashes.json` and `moves.json`.
import { readdirSync } from 'node:fs';
import { defaults, moves, quick } from './pages/values.js';

const folder = new URL('./pages/applets/', import.meta.url);
const names = readdirSync(folder).filter((name) => name.endsWith('.js') && name !== 'scenes.js').map((name) => name.slice(0, -3)).sort();
const requests = {};
for (const name of names) {
  const { default: page } = await import(new URL(`${name}.js`, folder));
  requests[name] = page.request(defaults(page));
  for (const { control, after } of moves(page)) requests[`${name}/${control.id}`] = quick(page, page.request(after)) ?? page.request(after);
}
console.log(JSON.stringify(requests, null, 1));
