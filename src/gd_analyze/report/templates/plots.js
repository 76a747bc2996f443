"use strict";
// Keeps the figures of the data block drawn: each when it is first given room, before it is seen, and again
// when its room or a switch changes.
const report = (() => {
  const data = JSON.parse(document.getElementById("report-data").textContent);
  const state = { x: "time", shared: false, hidden: new Set(["centrifugal", "coriolis"]) };
  const plots = new Map();
  const tip = document.body.appendChild(document.createElement("div"));
  tip.className = "tip";
  tip.hidden = true;

  const visible = (spec) => spec.traces.filter((trace) => !state.hidden.has(trace.role));

  function extent(specs) {
    const zero = specs.every((spec) => spec.zero);
    let low = zero ? 0 : Infinity, high = zero ? 0 : -Infinity;
    const reach = (value) => { low = Math.min(low, value); high = Math.max(high, value); };
    for (const spec of specs) {
      if (spec.band) { reach(-spec.band); reach(spec.band); }
      if (spec.kind === "pile") {
        const parts = spec.traces.filter((trace) => trace.role !== "total");
        spec.traces[0].y.forEach((_, k) => {
          for (const clip of [Math.max, Math.min]) reach(parts.reduce((sum, trace) => sum + clip(trace.y[k], 0), 0));
        });
        // Of the two limits, the one that the torque comes near.
        if (spec.limit) reach(high > -low ? spec.limit : -spec.limit);
      } else for (const trace of visible(spec)) trace.y.forEach(reach);
    }
    if (!(low < high)) {
      const size = low === high && Math.abs(low);
      return size ? [low - 0.05 * size, high + 0.05 * size] : [-1, 1];
    }
    const margin = 0.06 * (high - low);
    return [low - (zero && low === 0 ? 0 : margin), high + margin];
  }

  function range(spec) {
    if (!state.shared || !spec.scale) return extent([spec]);
    return extent(Object.values(data.figures).filter((other) => other.scale === spec.scale));
  }

  function draw(div) {
    const width = div.clientWidth, height = div.clientHeight;
    if (!width || !height) return;
    const plot = plots.get(div), spec = data.figures[div.dataset.figure];
    const names = state.x === "time" ? { unit: "s" } : { whole: true };
    const how = { width, height, range: spec.traces && spec.kind !== "trade-off" && range(spec), hidden: state.hidden, names, window: plot.window };
    const made = spec.kind === "trade-off" ? tradeOff(spec, how) : chart[spec.kind === "pile" ? "pile" : "curves"](spec, data.axes[spec.axis][state.x], how);
    div.innerHTML = made.content;
    Object.assign(plot, made, { width, height, drawn: `${width}×${height}` });
    div.dispatchEvent(new Event("drawn"));
  }

  const observer = new ResizeObserver((entries) => {
    for (const { target } of entries) if (plots.get(target).drawn !== `${target.clientWidth}×${target.clientHeight}`) draw(target);
  });
  for (const div of document.querySelectorAll(".plot")) {
    plots.set(div, { drawn: "" });
    observer.observe(div);
  }
  const drawAll = () => { for (const div of plots.keys()) draw(div); };
  function show(div, figure) {
    div.dataset.figure = figure;
    plots.get(div).window = null;
    draw(div);
  }

  const MARKS = { translation: "T", rotation: "R", combined: "=", centrifugal: "cf", coriolis: "Co" };
  // What the curves are worth at one set point: a line across the figure, and values below or beside it.
  function point(div, index, event) {
    const plot = plots.get(div), spec = data.figures[div.dataset.figure], axis = data.axes[spec.axis];
    plot.index = index;
    const at = plot.box.atX(axis[state.x][index]);
    let cursor = div.querySelector(".cursor");
    if (!cursor) {
      cursor = document.createElementNS("http://www.w3.org/2000/svg", "g");
      cursor.setAttribute("class", "cursor");
      div.querySelector("svg").append(cursor);
    }
    const shown = visible(spec);
    cursor.innerHTML = chart.line(at, plot.box.top, at, plot.box.bottom, "edge") + (spec.kind === "pile" ? [] : shown).map((trace) => `<circle class="dot ${trace.role}" cx="${chart.px(at)}" cy="${chart.px(plot.box.atY(trace.y[index]))}" r="3"/>`).join("");
    const head = `#${axis.point[index]}, ${chart.number(axis.time[index])} s`;
    const readout = div.dataset.size !== "medium" && div.closest("figure").querySelector(".readout");
    if (readout) {
      readout.innerHTML = `${head}: ${shown.map((trace) => `<b class="${trace.role}">${shown.length > 1 ? `${MARKS[trace.role]} ` : ""}${chart.number(trace.y[index])}</b>`).join(" ")} ${chart.safe(spec.unit)}`;
    } else {
      const rows = shown.filter((trace) => trace.y[index] !== 0 || shown.length < 3);
      tell(event, `<b>${head}</b>${rows.map((trace) => `<br><i class="key-of ${trace.role}"></i>${chart.safe(trace.label)}: ${chart.quantity(trace.y[index], spec.unit)}`).join("")}`);
    }
  }
  function tell(event, words) {
    tip.innerHTML = words;
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, document.documentElement.clientWidth - box.width - 4))}px`;
    tip.style.top = `${event.clientY + 18 + box.height > innerHeight ? event.clientY - box.height - 12 : event.clientY + 18}px`;
  }
  function leave(div) {
    tip.hidden = true;
    const cursor = div.querySelector(".cursor");
    if (cursor) cursor.remove();
  }
  function nearest(plot, xs, x) {
    let best = plot.from;
    for (let k = plot.from; k <= plot.to; k += 1) if (Math.abs(plot.box.atX(xs[k]) - x) < Math.abs(plot.box.atX(xs[best]) - x)) best = k;
    return best;
  }

  for (const [div, plot] of plots) {
    const place = (event) => {
      const box = div.getBoundingClientRect();
      return [((event.clientX - box.left) * plot.width) / box.width, ((event.clientY - box.top) * plot.height) / box.height];
    };
    const find = (event) => nearest(plot, data.axes[data.figures[div.dataset.figure].axis][state.x], place(event)[0]);
    div.addEventListener("pointermove", (event) => {
      if (!plot.box) return;
      if (plot.points) {
        const [x, y] = place(event);
        const near = plot.points.reduce((a, b) => (Math.hypot(a.x - x, a.y - y) < Math.hypot(b.x - x, b.y - y) ? a : b));
        if (Math.hypot(near.x - x, near.y - y) < 28) tell(event, near.words); else tip.hidden = true;
      } else point(div, find(event), event);
    });
    div.addEventListener("pointerleave", () => leave(div));
    if (div.dataset.size !== "large") continue;
    // The enlarged figure can be dragged over to zoom, and read with the arrow keys.
    let begin = null;
    div.addEventListener("pointerdown", (event) => { begin = event.pointerType === "mouse" ? find(event) : null; });
    div.addEventListener("pointerup", (event) => {
      const end = begin === null ? null : find(event);
      if (end !== null && Math.abs(end - begin) > 1) { plot.window = [Math.min(begin, end), Math.max(begin, end)]; draw(div); }
      begin = null;
    });
    div.addEventListener("dblclick", () => { plot.window = null; draw(div); });
    div.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === "Escape") { plot.window = null; draw(div); }
      if (!step || !plot.box) return;
      event.preventDefault();
      const index = plot.index === undefined ? plot.from : plot.index + step;
      point(div, Math.max(plot.from, Math.min(plot.to, index)), event);
    });
  }

  // A line at one set point across all torques, which follows the arm.
  function mark(index, shown) {
    for (const [div, plot] of plots) {
      const spec = data.figures[div.dataset.figure];
      if (spec.kind !== "pile" || !plot.box) continue;
      const { point: points, [state.x]: xs } = data.axes[spec.axis];
      const near = points.findIndex((number) => number >= index + 1);
      const old = div.querySelector(".now");
      if (old) old.remove();
      const at = plot.box.atX(xs[near < 0 ? xs.length - 1 : near]);
      if (shown) div.querySelector("svg").insertAdjacentHTML("beforeend", chart.line(at, plot.box.top, at, plot.box.bottom, "now"));
    }
  }
  return { data, state, plots, draw, drawAll, show, mark };
})();
