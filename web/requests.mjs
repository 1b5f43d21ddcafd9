// Prints the requests of all applets with their first values, by name: the input of the program `native`, which makes `hashes.json`.
import { readdirSync } from 'node:fs';
import { defaults } from './pages/values.js';

const folder = new URL('./pages/applets/', import.meta.url);
const names = readdirSync(folder).filter((name) => name.endsWith('.js') && name !== 'scenes.js').map((name) => name.slice(0, -3)).sort();
const requests = {};
for (const name of names) {
  const { default: page } = await import(new URL(`${name}.js`, folder));
  requests[name] = page.request(defaults(page));
}
console.log(JSON.stringify(requests, null, 1));
