"use strict";
// Figures as SVG text. Their colours are classes of the page's style, so a theme changes without drawing again.
const chart = (() => {
  const safe = (text) => String(text).replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
  const px = (value) => Math.round(value * 10) / 10;
  const raised = (digits) => [...digits].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");

  // Three or four digits, powers of ten set out.
  function number(value, digits = 4) {
    const size = Math.abs(value);
    const plain = String(Number(value.toPrecision(digits)));
    if (size === 0 || (size >= 1e-3 && size < 1e6)) return plain.replace("-", "−");
    const [lead, power] = value.toExponential(Math.min(digits - 1, 2)).split("e");
    return `${lead.replace("-", "−")}×10${raised(power.replace("+", ""))}`;
  }

  // A unit with the prefix that makes values up to this size readable, as the page's words have it; of
  // kilograms, grams have one.
  const PREFIXES = { "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M" };
  function scaled(size, unit) {
    const weighed = unit.startsWith("kg");
    const power = 3 * Math.floor(Math.log10(size || 1) / 3 + 1e-9);
    const prefix = PREFIXES[power + (weighed ? 3 : 0)];
    if (!(weighed || unit.startsWith("N")) || (size >= 0.1 && size < 1e4) || !size || prefix === undefined || (weighed && power >= 0)) return { factor: 1, unit };
    return { factor: 10 ** power, unit: prefix + (weighed ? unit.slice(1) : unit) };
  }
  function quantity(value, unit) {
    const { factor, unit: shown } = scaled(Math.abs(value), unit);
    return `${number(value / factor, 3)} ${shown}`;
  }

  // Round numbers between two, about so many, but three where there is any choice.
  function ticks(low, high, most) {
    if (!(high > low)) return [low];
    const rough = (high - low) / Math.max(most, 1), decade = 10 ** Math.floor(Math.log10(rough));
    const steps = [0.2, 0.5, 1, 2, 5, 10].map((lead) => lead * decade);
    let out = [];
    for (let k = steps.findIndex((step) => step >= rough * (1 - 1e-9)); k >= 0 && out.length < 3; k -= 1) {
      out = [];
      for (let m = Math.ceil(low / steps[k] - 1e-9); m * steps[k] <= high + steps[k] * 1e-9; m += 1) out.push(Number((m * steps[k]).toPrecision(12)));
    }
    return out;
  }

  const text = (x, y, words, more = "") => `<text x="${px(x)}" y="${px(y)}" ${more}>${safe(words)}</text>`;
  const line = (x1, y1, x2, y2, kind) => `<line class="${kind}" x1="${px(x1)}" y1="${px(y1)}" x2="${px(x2)}" y2="${px(y2)}"/>`;
  // A line through points; before those numbered in `breaks` it begins anew.
  const path = (points, breaks) => points.map(([x, y], k) => `${k && !(breaks && breaks.includes(k)) ? "L" : "M"}${px(x)},${px(y)}`).join("");

  // Axes of a panel: `body` is drawn between grid and labels; places come from value to pixel.
  function frame({ width, height, x, y, unit, most, names }) {
    const high = Math.max(Math.abs(y[0]), Math.abs(y[1]));
    const { factor, unit: shown } = scaled(high, unit);
    const yTicks = ticks(y[0] / factor, y[1] / factor, most || Math.max(Math.floor(height / 36), 3));
    const labels = yTicks.map((value) => number(value));
    const left = 9 + 6 * Math.max(...labels.map((label) => label.length), 1), right = width - 6, top = unit ? 17 : 6, bottom = height - 18;
    const atX = (value) => left + ((value - x[0]) / (x[1] - x[0] || 1)) * (right - left);
    const atY = (value) => bottom - ((value - y[0]) / (y[1] - y[0] || 1)) * (bottom - top);
    const xTicks = ticks(x[0], x[1], Math.max(Math.floor(width / 80), 2)).filter((value) => !names || names.whole !== true || Number.isInteger(value));
    let under = yTicks.map((value, k) => {
      const at = atY(value * factor);
      return line(left, at, right, at, value === 0 ? "zero" : "grid") + text(left - 5, at + 3.5, labels[k], 'text-anchor="end"');
    }).join("");
    under += line(left, bottom, right, bottom, "edge");
    xTicks.forEach((value, k) => {
      const last = k === xTicks.length - 1;
      const words = number(value) + (last && names && names.unit ? ` ${names.unit}` : "");
      const at = atX(value);
      const anchor = at > right - 3 * words.length ? "end" : at < left + 6 ? "start" : "middle";
      under += line(at, bottom, at, bottom + 4, "edge") + text(anchor === "end" ? Math.min(at + 10, width) : at, height - 4, words, `text-anchor="${anchor}"`);
    });
    if (unit) under += text(0, 10, shown, 'class="unit"');
    return { atX, atY, left, right, top, bottom, under };
  }

  const svg = (width, height, content) => `<svg viewBox="0 0 ${px(width)} ${px(height)}" aria-hidden="true" focusable="false">${content}</svg>`;

  // Lines over time or set points; one set point is a dot.
  function curves(spec, xs, { width, height, range, hidden, names, window }) {
    const [from, to] = window || [0, xs.length - 1];
    const box = frame({ width, height, x: [xs[from], xs[to]], y: range, unit: spec.unit, names });
    const breaks = (spec.breaks || []).map((k) => k - from);
    let body = "";
    if (spec.band) {
      const top = Math.max(box.atY(spec.band), box.top), bottom = Math.min(box.atY(-spec.band), box.bottom);
      body += `<rect class="band" x="${px(box.left)}" width="${px(box.right - box.left)}" y="${px(top)}" height="${px(bottom - top)}"/>`;
    }
    for (const trace of spec.traces) {
      if (hidden.has(trace.role)) continue;
      const points = [];
      for (let k = from; k <= to; k += 1) points.push([box.atX(xs[k]), box.atY(trace.y[k])]);
      body += points.length > 1 ? `<path class="curve ${trace.role}" d="${path(points, breaks)}"/>` : `<circle class="dot ${trace.role}" cx="${px(box.left + 20)}" cy="${px(points[0][1])}" r="4"/>`;
    }
    return { content: svg(width, height, box.under + body), box, from, to };
  }

  // What a torque consists of, piled up from zero upward and downward, under the line of the whole.
  function pile(spec, xs, { width, height, range, hidden, names }) {
    const box = frame({ width, height, x: [xs[0], xs[xs.length - 1]], y: range, unit: spec.unit, names });
    let body = "";
    for (const clip of [(v) => Math.max(v, 0), (v) => Math.min(v, 0)]) {
      const inner = xs.map(() => 0);
      for (const trace of spec.traces) {
        if (trace.role === "total" || hidden.has(trace.role)) continue;
        const outer = inner.map((edge, k) => edge + clip(trace.y[k]));
        if (outer.some((edge, k) => edge !== inner[k])) {
          const ends = [0, ...(spec.breaks || []), xs.length];
          const around = ends.slice(1).map((end, part) => {
            const at = xs.slice(ends[part], end).map((x, k) => [box.atX(x), ends[part] + k]);
            const forth = at.map(([x, k]) => [x, box.atY(outer[k])]), back = at.map(([x, k]) => [x, box.atY(inner[k])]).reverse();
            return `${path([...forth, ...back])}Z`;
          });
          body += `<path class="area ${trace.role}" d="${around.join("")}"/>`;
        }
        outer.forEach((edge, k) => { inner[k] = edge; });
      }
    }
    const total = spec.traces.find((trace) => trace.role === "total");
    body += `<path class="curve total" d="${path(xs.map((x, k) => [box.atX(x), box.atY(total.y[k])]), spec.breaks)}"/>`;
    for (const limit of spec.limit ? [spec.limit, -spec.limit] : []) {
      if (limit > range[0] && limit < range[1]) body += line(box.left, box.atY(limit), box.right, box.atY(limit), "limit");
    }
    return { content: svg(width, height, box.under + body), box, from: 0, to: xs.length - 1 };
  }

  return { safe, px, number, quantity, scaled, ticks, text, line, path, svg, frame, curves, pile };
})();
