// Find errors in the layout of a page.

/** Return the layout errors of a page: overlaps, content that is too wide or cut off, holes. It runs in the page. */
export function faults() {
  const wrong = [];
  const seen = (element) => {
    for (let each = element; each; each = each.parentElement) {
      const style = getComputedStyle(each);
      if (style.visibility === "hidden" || style.display === "none" || Number(style.opacity) === 0) return false;
      if (each.matches(".visually-hidden, .arm-unseen, .skip, noscript, details:not([open]) > :not(summary)"))
        return false;
    }
    return true;
  };
  const scrolled = (element, way = "overflowX") => {
    for (let each = element.parentElement; each && each !== document.body; each = each.parentElement)
      if (/auto|scroll|hidden|clip/.test(getComputedStyle(each)[way])) return true;
    return false;
  };
  const name = (element) =>
    `${element.tagName.toLowerCase()}${[...element.classList].map((one) => `.${one}`).join("")} “${element.textContent.trim().slice(0, 30)}”`;
  const hasText = (element) =>
    [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
  const ATOMS = "img, input, select, textarea, button, svg, canvas, math, math-field, progress";
  const blocks = [...document.querySelectorAll("header *, main *, footer *")].filter(
    (element) =>
      (element.matches(ATOMS) || hasText(element)) &&
      !element.parentElement.closest("svg, math, button, select, .arm-drawing, .arm-map-frame, math-field") &&
      !element.matches(".skill-lines, option, optgroup") &&
      seen(element),
  );
  const boxes = blocks
    .map((element) => ({ element, rects: [...element.getClientRects()] }))
    .filter(({ rects }) => rects.some(({ width, height }) => width > 1 && height > 1));
  for (const { element, rects } of boxes) {
    if (!scrolled(element) && rects.some(({ left, right }) => left < -1 || right > innerWidth + 1))
      wrong.push(`too wide: ${name(element)}`);
  }
  // text that is cut off at its box and can't be scrolled; a select may cut off its choice
  for (const { element } of boxes) {
    const { overflowX, textOverflow } = getComputedStyle(element);
    const isCut = element.scrollWidth > element.clientWidth + 1 && element.clientWidth > 0;
    if (isCut && (/hidden|clip/.test(overflowX) || textOverflow === "ellipsis") && !element.matches(ATOMS))
      wrong.push(`cut off: ${name(element)}`);
    if (element.matches("button") && isCut) wrong.push(`cut off: ${name(element)}`);
  }
  const over = (a, b) => {
    const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    return across > 2 && down > 4; // lines of a text overlap by some pixels
  };
  // content of a scrolling pane is visible only inside the pane
  const placed = boxes
    .map((box) => ({
      ...box,
      top: Math.min(...box.rects.map(({ top }) => top)),
      bottom: Math.max(...box.rects.map(({ bottom }) => bottom)),
      pane: box.element.closest(".arm-pane, .arm-side, .stage, .beside, .live"),
    }))
    .sort((a, b) => a.top - b.top);
  for (const [i, a] of placed.entries()) {
    for (let k = i + 1; k < placed.length && placed[k].top < a.bottom; k += 1) {
      const b = placed[k];
      if (a.pane !== b.pane || a.element.contains(b.element) || b.element.contains(a.element)) continue;
      if (a.rects.some((one) => b.rects.some((other) => over(one, other))))
        wrong.push(`${name(a.element)} and ${name(b.element)} lie over each other`);
    }
  }
  const main = document.querySelector("main").getBoundingClientRect();
  const rows = new Uint8Array(Math.ceil(document.documentElement.scrollHeight) + 1);
  for (const { rects } of boxes)
    for (const { top, bottom } of rects)
      rows.fill(1, Math.max(0, Math.floor(top + scrollY)), Math.ceil(bottom + scrollY));
  for (const frame of document.querySelectorAll(".arm-drawing, .arm-map-frame, .sheet-room, iframe")) {
    const { top, bottom } = frame.getBoundingClientRect();
    rows.fill(1, Math.max(0, Math.floor(top + scrollY)), Math.ceil(bottom + scrollY));
  }
  // a number of lines of its text, which is larger on the widest screens
  const hole = Math.round(12.5 * parseFloat(getComputedStyle(document.documentElement).fontSize));
  const inMain = boxes
    .filter(({ element }) => element.closest("main") && !scrolled(element, "overflowY")) // a list may continue below its box
    .flatMap(({ rects }) => rects);
  const end = Math.floor(Math.max(main.top, ...inMain.map(({ bottom }) => bottom)) + scrollY);
  for (let row = Math.floor(main.top + scrollY), empty = 0; row <= end; row += 1) {
    empty = rows[row] ? 0 : empty + 1;
    if (empty === hole && row < end) wrong.push(`a hole of ${hole} pixels above ${row}`);
  }
  const wider = document.documentElement.scrollWidth - innerWidth;
  if (wider > 0) wrong.push(`${wider} pixels wider than the screen`);
  return [...new Set(wrong)].slice(0, 8);
}
