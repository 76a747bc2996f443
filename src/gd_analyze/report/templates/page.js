"use strict";
// Theme, values of curves under the pointer, tables that sort, folds that open for links and paper.
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const root = document.documentElement;

document.getElementById("theme").addEventListener("click", () => {
  const dark = root.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  root.dataset.theme = dark === "dark" ? "light" : "dark";
});

// Three digits, powers of ten set out.
function number(value, digits = 3) {
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e6)) return String(Number(value.toPrecision(digits))).replace("-", "−");
  const [lead, power] = value.toExponential(digits - 1).split("e");
  const raised = [...power.replace("+", "")].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  return `${lead.replace("-", "−")}×10${raised}`;
}

// Corners of a path as the program writes them: M and L to places, l by steps, z back to the start.
function corners(path) {
  const runs = [];
  let how = "", x = 0, y = 0, pending = null;
  for (const word of path.getAttribute("d").match(/[a-zA-Z]|-?\d+/g)) {
    if (/[a-zA-Z]/.test(word)) { how = word; continue; }
    if (pending === null) { pending = Number(word); continue; }
    [x, y] = how === "l" ? [x + pending, y + Number(word)] : [pending, Number(word)];
    if (how === "M") runs.push([]);
    runs[runs.length - 1].push([x, y]);
    pending = null;
  }
  return runs;
}
// Heights at which a path passes a place: one of a line, the outer and the inner edge of an area.
function heights(path, at) {
  path.runs ||= corners(path);
  const found = [];
  for (const run of path.runs) {
    for (let k = 1; k < run.length; k += 1) {
      const [[x, y], [u, v]] = [run[k - 1], run[k]];
      if ((x <= at && at < u) || (u < at && at <= x)) found.push(y + ((v - y) * (at - x)) / (u - x));
    }
  }
  return found;
}

// The bar's height, which grows where its links take two lines.
const bar = document.querySelector(".bar");
new ResizeObserver(() => root.style.setProperty("--bar", `${bar.offsetHeight}px`)).observe(bar);

const tip = document.body.appendChild(document.createElement("div"));
tip.className = "tip";
tip.hidden = true;
function tell(event, words) {
  tip.innerHTML = words;
  tip.hidden = false;
  const box = tip.getBoundingClientRect(), below = event.clientY + 18;
  tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, root.clientWidth - box.width - 4))}px`;
  tip.style.top = `${below + box.height > innerHeight ? event.clientY - box.height - 12 : below}px`;
}
function lineAt(svg, kind, at) {
  let line = svg.querySelector(`.${kind}`);
  if (at === null) return line && line.remove();
  if (!line) {
    line = svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "path"));
    line.setAttribute("class", kind);
  }
  const [, top, , height] = svg.dataset.frame.split(" ");
  line.setAttribute("d", `M${at} ${top}v${height}`);
}
function follow(svg) {
  const [left, top, width, height] = svg.dataset.frame.split(" ").map(Number);
  const [x0, x1, ...xUnit] = svg.dataset.x.split(" "), [y0, y1, ...yUnit] = svg.dataset.y.split(" ");
  svg.scale = { at: (x) => left + (width * (x - x0)) / (x1 - x0) };
  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    const at = ((event.clientX - box.left) * svg.viewBox.baseVal.width) / box.width;
    if (at < left || at > left + width) return leave();
    lineAt(svg, "cursor", at);
    const cells = svg.querySelector("[data-cells]");
    if (cells) {
      const { x, words, numbers } = (cells.told ||= JSON.parse(cells.dataset.cells));
      const time = Number(x0) + ((x1 - x0) * (at - left)) / width;
      const row = Math.floor(((event.clientY - box.top) * svg.viewBox.baseVal.height / box.height - top) / height * words.length);
      if (!(row in words)) return leave();
      const column = Math.min(Math.max(x.findIndex((edge) => edge > time) - 1, 0), numbers[row].length - 1);
      const said = words[row].replace(/\{(\d)\}/g, (_, k) => number(numbers[row][column][k]));
      return tell(event, `<b>${number(time)} ${xUnit.join(" ")}</b><br>${said}`);
    }
    const value = (y) => Number(y1) - ((y1 - y0) * (y - top)) / height;
    const told = new Map();
    for (const path of all("[data-label]", svg)) {
      if (getComputedStyle(path).display === "none") continue;
      const ys = heights(path, at).map(value), area = path.style.fill && !path.style.stroke;
      if (!ys.length || (area && ys.length < 2)) continue;
      told.set(path.dataset.label, (told.get(path.dataset.label) || 0) + (area ? ys[0] - ys[1] : ys[0]));
    }
    const small = Math.abs(y1 - y0) * 5e-4;
    const rows = [...told].map(([label, y]) => `<br>${label}: ${number(Math.abs(y) < small ? 0 : y)} ${yUnit.join(" ")}`);
    tell(event, `<b>${number(Number(x0) + ((x1 - x0) * (at - left)) / width)} ${xUnit.join(" ")}</b>${rows.join("")}`);
  });
  const leave = () => { tip.hidden = true; lineAt(svg, "cursor", null); };
  svg.addEventListener("pointerleave", leave);
}
for (const svg of all("svg.panel[data-frame]")) follow(svg);

for (const table of all("table.sortable")) {
  all("thead th", table).forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending";
    for (const other of all("thead th", table)) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = (row) => row.cells[column].dataset.v ?? row.cells[column].textContent;
    const order = (a, b) => (isNaN(key(a)) || isNaN(key(b)) ? key(a).localeCompare(key(b)) : key(a) - key(b));
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort((a, b) => (up ? order(a, b) : order(b, a))));
  }));
}

// Buttons that show curves by their role.
for (const button of all("button[data-role]")) {
  button.addEventListener("click", () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    for (const curve of all(`svg.panel .${button.dataset.role}`)) curve.style.display = on ? "inline" : "none";
  });
}

function reveal() {
  const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  for (let fold = target.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", reveal);
document.addEventListener("click", (event) => {
  const link = event.target.closest('a[href^="#"]');
  if (link && link.hash === location.hash) setTimeout(reveal);
});
reveal();
const folds = all("details"), openAll = document.getElementById("open-all");
openAll?.addEventListener("click", () => {
  const open = !folds.every((fold) => fold.open);
  for (const fold of folds) fold.open = open;
  openAll.textContent = open ? "Fold all" : "Unfold all";
});
let opened = [];
addEventListener("beforeprint", () => {
  opened = folds.filter((fold) => !fold.open);
  for (const fold of opened) fold.open = true;
});
addEventListener("afterprint", () => { for (const fold of opened) fold.open = false; });
