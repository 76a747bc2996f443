"use strict";
// Operations against error, both on logarithmic scales: one curve for every way to simplify.
function tradeOff(spec, { color, look, mouse }) {
  // On a logarithmic scale no error (or one that is next to nothing) and no operations stand at its end.
  const nothing = 1e-3;
  const end = (values, from) => {
    const placed = values.filter((value) => value >= from);
    return placed.length ? Math.min(...placed) / 2 : from;
  };
  const every = (key) => [...spec.traces.flatMap((trace) => trace[key]), spec.model[key]];
  const lowX = end(every("x"), nothing);
  const lowY = end([...every("y"), spec.exact], 1);
  const tell = (x, y, budget) => `budget ${budget}<br>error ${x === 0 ? "0" : x < 0.01 ? "below 0.01" : Number(x.toPrecision(2))} %<br>${y} operations`;
  const onAxes = (points) => ({ x: points.x.map((x) => (x < nothing ? lowX : x)), y: points.y.map((y) => y || lowY) });
  const traces = spec.traces.map((trace) => {
    const { colour: stroke, mark: symbol, refit } = trace;
    return {
      type: "scatter", mode: "lines+markers", ...onAxes(trace), name: trace.label, meta: trace.role,
      line: { color: color(stroke), width: 2, dash: refit ? "dot" : "solid" },
      marker: { color: refit ? color("paper") : color(stroke), size: 7, symbol, line: { color: color(stroke), width: 1.5 } },
      text: trace.x.map((x, k) => tell(x, trace.y[k], trace.budget[k])), hovertemplate: "<b>%{fullData.name}</b><br>%{text}<extra></extra>",
    };
  });
  const { model } = spec;
  traces.push({
    type: "scatter", mode: "markers", ...onAxes({ x: [model.x], y: [model.y] }), name: model.label, meta: "model",
    marker: { color: color("accent"), size: 17, symbol: "star", line: { color: color("paper"), width: 1.5 } },
    text: [tell(model.x, model.y, model.budget)], hovertemplate: "<b>%{fullData.name}</b><br>%{text}<extra></extra>",
  });
  const xs = traces.flatMap((trace) => trace.x), ys = [...traces.flatMap((trace) => trace.y), spec.exact];
  const range = (values, below, above) => [Math.log10(Math.min(...values)) - below, Math.log10(Math.max(...values)) + above];
  // Plotly would label 1, 2 and 5 of a decade, or whole decades where a small screen has room for no more.
  const ticks = (values, low, endLabel, unit) => {
    const top = Math.max(...values) * 2;
    const found = [];
    for (let decade = -3; decade < 7; decade += 1) {
      for (const lead of innerWidth < 640 && top / low > 100 ? [1] : [1, 2, 5]) found.push(Number(`${lead}e${decade}`));
    }
    const ended = values.includes(low);
    const shown = found.filter((value) => value <= top && (ended ? value > 1.4 * low : value >= low / 2));
    return { tickvals: ended ? [low, ...shown] : shown, ticktext: [...(ended ? [endLabel] : []), ...shown.map((value) => `${value}${unit}`)] };
  };
  const axis = { ...look.axis, type: "log", tickangle: 0, fixedrange: !mouse };
  const layout = {
    ...look.layout, showlegend: true, hovermode: "closest", dragmode: mouse ? "zoom" : false, margin: { l: 58, r: 12, t: 12, b: 92 },
    legend: { orientation: "h", x: 0, y: -0.2, yanchor: "top", font: { size: 12 } },
    xaxis: { ...axis, range: range(xs, 0.12, 0.12), ...ticks(xs, lowX, "≈ 0", " %"), title: { text: `largest torque error, of the ${spec.shares_of}`, standoff: 8 } },
    yaxis: { ...axis, range: range(ys, 0.12, 0.14), ...ticks(ys, lowY, "0", ""), title: { text: "multiplications + additions", standoff: 6 } },
    shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: spec.exact || lowY, y1: spec.exact || lowY, line: { color: color("soft"), width: 1.2, dash: "dot" } }],
    annotations: [{ xref: "paper", x: 1, xanchor: "right", y: Math.log10(spec.exact || lowY), yanchor: "bottom", showarrow: false,
      text: `exact: ${spec.exact}`, font: { size: 11, color: color("soft") } }],
  };
  return [traces, layout, look.config];
}
