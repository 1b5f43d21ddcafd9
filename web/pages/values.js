// The values that the controls of an applet begin with; no browser needed.

export function defaults(page) {
  return Object.fromEntries(page.controls.map((control) => [control.id, structuredClone(control.value)]));
}
