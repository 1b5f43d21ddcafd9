// The values that the controls of an applet begin with, and the moves that tests make; no browser needed.

/// A name as a word of a shell.
export const quoted = (name) => (/^[\w./-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);

export function defaults(page) {
  return Object.fromEntries(page.controls.map((control) => [control.id, structuredClone(control.value)]));
}

/// The request without what is only measured: its pictures are the first ones of the whole. Null where that is the whole.
export function quick(page, request) {
  const { reference, rays, ...rest } = request;
  if (!(reference || rays || page.slow)) return null;
  return page.slow ? { ...rest, quick: true } : rest;
}

/// One move of each control: the values before and after it. A control that others switch off comes after the ones that switch it on; a
/// picture of one's own is another texture, a scene of one's own a model.
export function moves(page) {
  return page.controls.map((control) => {
    const before = defaults(page);
    for (const [other, wanted] of Object.entries(control.when ?? {})) before[other] = [wanted].flat()[0];
    const after = structuredClone(before);
    after[control.id] = moved(control, before[control.id]);
    return { control, before, after };
  });
}

function moved(control, value) {
  if (control.kind === 'check') return !value;
  if (control.kind === 'picture') return 'textures/label.png';
  if (control.kind === 'files') return 'models/cube_plain.obj';
  if (control.kind === 'choice') {
    const options = control.options.map((option) => [option].flat()[0]);
    return options[(options.indexOf(value) + 1) % options.length];
  }
  if (control.kind === 'points') {
    // Five presses of an arrow key on the first handle.
    const [[x, y], ...rest] = value;
    return [[[...'12345'].reduce((sum) => sum + 0.01, x), y], ...rest];
  }
  const step = control.step ?? 1;
  const way = (value - control.min > (control.max - control.min) / 2 ? -0.3 : 0.3) * (control.max - control.min);
  return Number((control.min + Math.round((value + way - control.min) / step) * step).toFixed(6));
}
