"use strict";
// Operations against error, both on logarithmic scales: a curve for every way to simplify, and this report's model.
function tradeOff(spec, { width, height }) {
  // On a logarithmic scale no error (or one that is next to nothing) and no operations stand at its end.
  const nothing = 1e-3;
  const end = (values, from) => {
    const placed = values.filter((value) => value >= from);
    return placed.length ? Math.min(...placed) / 2 : from;
  };
  const every = (key) => [...spec.traces.flatMap((trace) => trace[key]), ...spec.path[key], spec.model[key]];
  const lowX = end(every("x"), nothing), lowY = end([...every("y"), spec.exact], 1);
  const onX = (x) => Math.log10(x < nothing ? lowX : x), onY = (y) => Math.log10(y || lowY);
  const span = (values, place, margin) => {
    const placed = values.map(place);
    return [Math.min(...placed) - margin, Math.max(...placed) + margin];
  };
  const x = span(every("x"), onX, 0.1), y = span([...every("y"), spec.exact], onY, 0.06);
  const left = 46, right = width - 8, top = 18, bottom = height - 34;
  const atX = (value) => left + ((onX(value) - x[0]) / (x[1] - x[0])) * (right - left);
  const atY = (value) => bottom - ((onY(value) - y[0]) / (y[1] - y[0])) * (bottom - top);
  const leads = (low, high, room) => (room / (high - low) > 150 ? [1, 2, 5] : room / (high - low) > 70 ? [1, 3] : [1]);
  const ticks = ([low, high], room) => {
    const out = [];
    for (let decade = Math.floor(low); decade <= high; decade += 1) {
      for (const lead of leads(low, high, room)) if (Math.log10(lead) + decade >= low && Math.log10(lead) + decade <= high) out.push(Number(`${lead}e${decade}`));
    }
    return out;
  };
  const { line, text, px } = chart;
  // Too narrow a span for 1, 2 and 5 has round numbers at equal distances.
  const some = (values, [low, high]) => (values.length > 2 ? values : chart.ticks(10 ** low, 10 ** high, 4));
  let content = "";
  const ended = every("x").some((value) => value < nothing);
  for (const value of ticks(x, right - left).filter((tick) => !ended || tick > 1.6 * lowX)) {
    content += line(atX(value), top, atX(value), bottom, "grid") + text(atX(value), bottom + 14, `${chart.number(value)} %`, 'text-anchor="middle"');
  }
  if (ended) content += text(atX(0), bottom + 14, "≈ 0", 'text-anchor="middle"');
  for (const value of some(ticks(y, bottom - top), y)) {
    content += line(left, atY(value), right, atY(value), "grid") + text(left - 6, atY(value) + 3.5, value, 'text-anchor="end"');
  }
  content += text(0, 10, "operations", 'class="unit"') + text(right, height - 5, `largest torque error, of the ${spec.shares_of}`, 'text-anchor="end"');
  content += line(left, atY(spec.exact), right, atY(spec.exact), "exact") + text(right, atY(spec.exact) - 4, `exact: ${spec.exact}`, 'text-anchor="end"');
  const tell = (trace, k) => `<b>${chart.safe(trace.label)}</b><br>budget ${chart.safe(trace.budget[k])}<br>error ${trace.x[k] === 0 ? "0" : trace.x[k] < 0.01 ? "below 0.01" : Number(trace.x[k].toPrecision(2))} %<br>${trace.y[k]} operations`;
  const MARK = {
    circle: (cx, cy) => `<circle cx="${px(cx)}" cy="${px(cy)}" r="3.6"/>`,
    square: (cx, cy) => `<rect x="${px(cx - 3.3)}" y="${px(cy - 3.3)}" width="6.6" height="6.6"/>`,
    triangle: (cx, cy) => `<path d="M${px(cx - 4.2)},${px(cy + 3.4)}h8.4l-4.2,-7.6Z"/>`,
    diamond: (cx, cy) => `<path d="M${px(cx)},${px(cy - 4.6)}l4.6,4.6l-4.6,4.6l-4.6,-4.6Z"/>`,
    star: (cx, cy) => `<path d="${chart.path([...Array(10).keys()].map((k) => { const r = k % 2 ? 4.2 : 10, a = (k * Math.PI) / 5; return [cx + r * Math.sin(a), cy - r * Math.cos(a)]; }))}Z"/>`,
  };
  const points = [];
  for (const trace of spec.traces) {
    const placed = trace.x.map((value, k) => [atX(value), atY(trace.y[k])]);
    placed.forEach(([cx, cy], k) => points.push({ x: cx, y: cy, words: tell(trace, k) }));
    content += `<g class="kind${trace.refit ? " refit" : ""}" style="--kind:var(--${trace.colour})"><path class="curve" d="${chart.path(placed)}"/>${placed.map((at) => MARK[trace.mark](...at)).join("")}</g>`;
  }
  content += `<path class="path" d="${chart.path(spec.path.x.map((value, k) => [atX(value), atY(spec.path.y[k])]))}"/>`;
  const star = { ...spec.model, x: [spec.model.x], y: [spec.model.y], budget: [spec.model.budget] };
  const [cx, cy] = [atX(spec.model.x), atY(spec.model.y)];
  points.push({ x: cx, y: cy, words: tell(star, 0) });
  content += `<g class="star">${MARK.star(cx, cy)}</g><g class="at-budget"></g>`;
  return { content: chart.svg(width, height, content), box: { atX, atY }, points };
}
