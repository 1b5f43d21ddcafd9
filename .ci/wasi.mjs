// Runs a WASI program with the given folders as /assets, /data and /work: node wasi.mjs PROGRAM.wasm ASSETS DATA WORK [STEP]
import { readFile } from 'node:fs/promises';
import { WASI } from 'node:wasi';

const [program, assets, data, work, ...step] = process.argv.slice(2);
const wasi = new WASI({
  version: 'preview1',
  args: ['texmap-targets', '/assets', '/data', '/work', ...step],
  preopens: { '/assets': assets, '/data': data, '/work': work },
});
const module = await WebAssembly.compile(await readFile(program));
process.exitCode = wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject()));
