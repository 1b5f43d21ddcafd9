// The Worker that holds the wasm module: the build for simd128 where the browser has it.

// (module (func (result v128) (i32.const 0) (i8x16.splat))): valid only with simd128.
const PROBE = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 8, 1, 6, 0, 65, 0, 253, 15, 11]);
const wanted = new URL(self.location).searchParams.get('simd');
const simd = wanted === null ? WebAssembly.validate(PROBE) : wanted === '1';
const name = simd ? 'simd' : 'plain';
const module = fetch(new URL(`./wasm/${name}_bg.wasm`, self.location));
const ready = (async () => {
  const wasm = await import(`./wasm/${name}.js`);
  const { memory } = await wasm.default({ module_or_path: module });
  return { wasm, memory, lab: new wasm.Lab() };
})();

// Files come while the module is compiled.
const fetched = new Map();
function fetchFile(file) {
  if (!fetched.has(file)) {
    const bytes = fetch(`assets/${file}`).then(async (answer) => {
      if (!answer.ok) throw new Error(`${file}: ${answer.status}`);
      return new Uint8Array(await answer.arrayBuffer());
    });
    // A fault is told by the request that needs the file.
    bytes.catch(() => {});
    fetched.set(file, bytes);
  }
  return fetched.get(file);
}

const loaded = new Map();
function load(lab, file) {
  if (!loaded.has(file)) loaded.set(file, fetchFile(file).then((bytes) => lab.add(file, bytes)));
  return loaded.get(file);
}

let room = null;
const commands = {
  async ask({ lab, memory }, { files, request }) {
    await Promise.all((files ?? []).map((file) => load(lab, file)));
    const began = performance.now();
    const answer = JSON.parse(lab.ask(JSON.stringify(request)));
    answer.ms = performance.now() - began;
    for (const panel of answer.panels) panel.rgba = new Uint8ClampedArray(memory.buffer, panel.at, panel.bytes).slice().buffer;
    return [answer, answer.panels.map((panel) => panel.rgba)];
  },
  async add({ lab }, { name, bytes }) {
    lab.add(name, new Uint8Array(bytes));
    loaded.set(name, Promise.resolve());
    return [null, []];
  },
  async remove({ lab }, { name }) {
    lab.remove(name);
    loaded.delete(name);
    return [null, []];
  },
  async png({ lab }, { panel }) {
    const bytes = lab.png(panel).buffer;
    return [bytes, [bytes]];
  },
  async room({ lab }, { files }) {
    await Promise.all(files.map((file) => load(lab, file)));
    room = lab.room();
    return [simd, []];
  },
  async frame({ memory }, { steps, buttons, turn, raise, width, height, filter, affine }) {
    for (let i = 0; i < steps; i++) room.step(buttons, turn / steps, raise / steps);
    const began = performance.now();
    const at = room.draw(width, height, filter, affine);
    const ms = performance.now() - began;
    const rgba = new Uint8ClampedArray(memory.buffer, at, width * height * 4).slice().buffer;
    return [{ rgba, ms, pixels: room.pixels(), triangles: room.triangles() }, [rgba]];
  },
  async play({ lab }, { width, height, every }) {
    const walk = lab.room();
    const frames = walk.frames() + 1;
    const began = performance.now();
    const hash = walk.play(width, height, every);
    const ms = performance.now() - began;
    walk.free();
    return [{ hash, ms, frames }, []];
  },
};

// After a trap the memory of the module is in no known state.
let failed = false;
self.onmessage = async ({ data }) => {
  data.files?.filter((file) => !loaded.has(file)).forEach(fetchFile);
  try {
    const lab = await ready;
    if (failed) throw new Error('the module has failed');
    const [result, moved] = await commands[data.command](lab, data);
    self.postMessage({ id: data.id, result, simd }, moved);
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError || /recursive use/.test(error.message)) failed = true;
    self.postMessage({ id: data.id, error: typeof error === 'string' ? error : `${failed ? 'the module has failed' : error.message ?? error}\nreload the page` });
  }
};
