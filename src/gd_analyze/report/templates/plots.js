"use strict";
// Draws the figures of the data block with Plotly: late, when they come into view, and again when a switch
// or the theme changes what they show.
const report = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const state = { x: "point", shared: false, hidden: new Set(["centrifugal", "coriolis"]) };
  const plots = new Map();
  const themed = [];
  // A finger scrolls the page over a figure; a mouse may drag out a part of it.
  const pointer = matchMedia("(pointer: fine)");
  const probe = document.body.appendChild(document.createElement("i"));
  probe.hidden = true;

  function color(name) {
    probe.style.color = `var(--${name})`;
    return getComputedStyle(probe).color;
  }

  const dashes = ["solid", "dash", "dot", "dashdot"];
  const roles = {
    combined: { width: 4.5, dash: "solid" },
    translation: { width: 2, dash: "solid" },
    rotation: { width: 2, dash: "dash" },
    centrifugal: { width: 2, dash: "dot" },
    coriolis: { width: 2, dash: "dashdot" },
    exact: { width: 4.5, dash: "solid", color: "combined" },
    simplified: { width: 1.8, dash: "solid", color: "accent" },
    error: { width: 1.8, dash: "solid", color: "accent" },
  };
  function style(role) {
    const joint = /^joint-(\d+)$/.exec(role);
    if (!joint) return { ...roles[role], color: color(roles[role].color || role) };
    const k = Number(joint[1]) - 1;
    return { width: 1.8, dash: dashes[Math.floor(k / 6) % 4], color: color(`series-${(k % 6) + 1}`) };
  }

  const visible = (spec) => spec.traces.filter((trace) => !state.hidden.has(trace.role));

  function extent(specs) {
    const zero = specs.every((spec) => spec.zero);
    let low = zero ? 0 : Infinity, high = zero ? 0 : -Infinity;
    for (const spec of specs) {
      if (spec.band) { low = Math.min(low, -spec.band); high = Math.max(high, spec.band); }
      for (const trace of visible(spec)) for (const y of trace.y) { if (y < low) low = y; if (y > high) high = y; }
    }
    if (!(low < high)) {
      const size = low === high && Math.abs(low);
      return size ? [low - 0.05 * size, high + 0.05 * size] : [-1, 1];
    }
    const margin = 0.07 * (high - low);
    return [low - margin, high + margin];
  }

  function verticalRange(spec) {
    if (!state.shared || !spec.scale) return extent([spec]);
    return extent(Object.values(data.figures).filter((other) => other.scale === spec.scale));
  }

  // What figures of all kinds have in common.
  function look() {
    return {
      axis: { gridcolor: color("grid"), zerolinecolor: color("line"), linecolor: color("line"), tickcolor: color("line"), automargin: false, exponentformat: "power" },
      layout: { autosize: true, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
        font: { family: getComputedStyle(document.body).fontFamily, size: 11, color: color("soft") },
        hoverlabel: { bgcolor: color("paper"), bordercolor: color("line"), font: { color: color("ink"), size: 12 } } },
      config: { displayModeBar: false, displaylogo: false, responsive: true, scrollZoom: false, doubleClick: "reset" },
    };
  }

  function build(spec, size) {
    return spec.kind === "trade-off" ? tradeOff(spec, { color, look: look(), mouse: pointer.matches }) : curves(spec, size);
  }

  function curves(spec, size) {
    const axis = data.axes[spec.axis];
    const x = axis[state.x];
    const few = x.length === 1;
    const large = size !== "small";
    const range = verticalRange(spec);
    const traces = spec.traces.map((trace) => {
      const { width, dash, color: stroke } = style(trace.role);
      return {
        type: "scatter", mode: few ? "markers" : "lines", x, y: trace.y, name: trace.label, meta: trace.role,
        visible: !state.hidden.has(trace.role), line: { width: large ? width + 0.3 : width, dash, color: stroke },
        marker: { color: stroke, size: width + 4 }, hoverinfo: large ? "all" : "none",
        hovertemplate: large ? `%{y:.4~g} ${spec.unit}` : undefined,
      };
    });
    const ink = color("soft");
    const common = look();
    const line = { ...common.axis, fixedrange: !large, tickfont: { size: large ? 11 : 10 } };
    const pad = few ? 0.5 : 0;
    const flat = range[0] === -1 && range[1] === 1 && visible(spec).every((trace) => trace.y.every((y) => y === 0));
    const layout = {
      ...common.layout, showlegend: size === "medium" && spec.traces.length > 1, hovermode: large ? "x unified" : "x", dragmode: large && pointer.matches ? "zoom" : false,
      margin: { l: 46, r: 8, t: large ? 18 : 12, b: large ? 38 : 20 },
      legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", font: { size: 10 } },
      xaxis: { ...line, range: [x[0] - pad, x[x.length - 1] + pad], nticks: large ? 8 : x[x.length - 1] > 999 ? 3 : 4, exponentformat: "none", separatethousands: true, showgrid: false, showspikes: true, spikemode: "across",
        spikethickness: 1, spikedash: "solid", spikecolor: ink, spikesnap: "hovered data",
        title: large ? { text: state.x === "time" ? "time, s" : "set point", standoff: 6 } : undefined, hoverformat: ".4~g" },
      yaxis: { ...line, range, nticks: large ? 6 : document.documentElement.classList.contains("printing") ? 3 : 4, zeroline: true, tickvals: flat ? [0] : undefined,
        title: large ? { text: spec.unit, standoff: 4 } : undefined },
      shapes: spec.band ? [{ type: "rect", layer: "below", xref: "paper", x0: 0, x1: 1, y0: -spec.band, y1: spec.band,
        fillcolor: color("accent-wash"), line: { width: 0 } }] : [],
    };
    // Powers of ten at the ticks need room.
    const wide = Math.max(-range[0], range[1]) < 2e-3;
    layout.margin.l += (large ? 12 : 0) + (wide ? 12 : 0);
    if (layout.showlegend) layout.margin.t = 34;
    return [traces, layout, common.config];
  }

  const raised = (digits) => [...digits].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  function short(value) {
    const [digits, power] = String(Number(value.toPrecision(4))).split("e");
    const size = Math.abs(value);
    if (power === undefined && (size === 0 || size >= 1e-3)) return digits.replace("-", "−");
    const [lead, exponent] = value.toExponential(2).split("e");
    return `${lead}×10${raised(exponent.replace("+", ""))}`.replace(/^-/, "−");
  }
  function readout(div, index) {
    const figure = div.closest(".panel");
    const line = figure && figure.querySelector(".readout");
    if (!line) return;
    const spec = data.figures[div.dataset.figure];
    const axis = data.axes[spec.axis];
    const marks = { translation: ["T", "t"], rotation: ["R", "r"], combined: ["=", ""], centrifugal: ["cf", ""], coriolis: ["Co", ""] };
    const order = Object.keys(marks);
    const values = spec.traces.filter((t) => !["centrifugal", "coriolis"].includes(t.role) || !state.hidden.has(t.role))
      .sort((a, b) => order.indexOf(a.role) - order.indexOf(b.role));
    line.replaceChildren(`#${axis.point[index]}, ${short(axis.time[index])} s: `);
    for (const trace of values) {
      const [mark, kind] = marks[trace.role];
      const value = document.createElement("b");
      value.className = kind;
      value.textContent = `${values.length > 1 ? mark + " " : ""}${short(trace.y[index])}`;
      line.append(value, " ");
    }
    line.append(spec.unit);
  }

  function draw(div) {
    const plot = plots.get(div);
    const spec = data.figures[div.dataset.figure];
    const first = !plot.drawn;
    const done = Plotly.react(div, ...build(spec, div.dataset.size));
    plot.dirty = false;
    plot.drawn = true;
    if (first && div.dataset.size === "small") {
      div.on("plotly_hover", (event) => readout(div, event.points[0].pointIndex));
    }
    return done;
  }

  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      const plot = plots.get(entry.target);
      plot.near = entry.isIntersecting;
      if (plot.near && plot.dirty) draw(entry.target);
    }
  }, { rootMargin: "400px" });

  function refresh() {
    for (const [div, plot] of plots) {
      plot.dirty = true;
      if (plot.near) draw(div);
    }
    for (const action of themed) action();
  }

  const drawAll = () => Promise.all([...plots].filter(([, plot]) => plot.dirty).map(([div]) => draw(div)));

  for (const div of document.querySelectorAll(".plot")) {
    plots.set(div, { dirty: true, drawn: false, near: false });
    observer.observe(div);
  }
  function show(div, figure) {
    div.dataset.figure = figure;
    const plot = plots.get(div);
    plot.dirty = true;
    if (plot.near || plot.drawn) draw(div);
  }
  return { data, state, color, plots, refresh, drawAll, show, themed, short };
})();
