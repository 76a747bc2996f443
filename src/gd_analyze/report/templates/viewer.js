"use strict";
// The playable three-dimensional view: every frame is one set point, never an interpolation.
report.viewer = (() => {
  const { viewer } = report.data;
  const element = (id) => document.getElementById(id);
  const scene = element("scene"), slider = element("frame"), play = element("play");
  const rows = [...element("state").rows];
  const last = viewer.at.length - 1;
  const view = { frame: 0, playing: false, available: false, started: 0, from: 0 };
  slider.max = last;

  const number = report.short;
  const position = (joint, value) => (joint.kind === "revolute" ? `${number((value * 180) / Math.PI)}°` : `${number(value)} m`);
  const columns = (points) => [0, 1, 2].map((axis) => points.map((point) => point[axis]));

  function labels(frame) {
    const joints = viewer.joints;
    const text = (k) => `joint ${k + 1}, ${joints[k].name}<br>q = ${position(joints[k], viewer.q[frame][k])}`;
    return viewer.points[frame].map((_, p) => (p === 0 ? "base" : p === 2 * joints.length ? `hand<br>${text(joints.length - 1)}` : text(Math.floor((p - 1) / 2))));
  }

  function floor() {
    const out = [[], [], []];
    const lines = 8;
    for (const [fixed, free] of [[0, 1], [1, 0]]) {
      const [low, high] = viewer.range[fixed];
      for (let k = 0; k <= lines; k += 1) {
        // Nothing is drawn from or to a point without a coordinate.
        for (const end of [...viewer.range[free], null]) {
          out[fixed].push(low + ((high - low) * k) / lines);
          out[free].push(end);
          out[2].push(viewer.floor);
        }
      }
    }
    return out;
  }

  function build() {
    const [fx, fy, fz] = floor();
    const base = viewer.points[0][0];
    const foot = [...base];
    foot[2] = viewer.floor;
    const [bx, by, bz] = columns([base, foot]);
    const [x, y, z] = columns(viewer.points[view.frame]);
    const ink = report.color("ink"), soft = report.color("soft");
    const line = (extra) => ({ type: "scatter3d", mode: "lines", hoverinfo: "skip", showlegend: false, ...extra });
    const traces = [
      line({ x: fx, y: fy, z: fz, line: { color: report.color("line"), width: 1.5 } }),
      line({ x: bx, y: by, z: bz, line: { color: report.color("combined"), width: 12 } }),
      line({ x: viewer.path[0], y: viewer.path[1], z: viewer.path[2], name: "path of the hand", line: { color: report.color("rotation"), width: 4, dash: "dash" } }),
      { type: "scatter3d", mode: "lines+markers", x, y, z, name: "arm", showlegend: false, line: { color: report.color("translation"), width: 11 },
        marker: { size: 5, color: report.color("paper"), line: { color: ink, width: 2 } }, text: labels(view.frame), hovertemplate: "%{text}<extra></extra>" },
      { type: "scatter3d", mode: "markers", x: [x.at(-1)], y: [y.at(-1)], z: [z.at(-1)], hoverinfo: "skip", showlegend: false, marker: { size: 7, color: report.color("rotation") } },
    ];
    const spans = viewer.range.map(([low, high]) => Math.abs(high - low));
    const largest = Math.max(...spans);
    const axis = (k) => ({ range: viewer.range[k], visible: true, showgrid: false, zeroline: false, showline: false, showspikes: false, showbackground: false,
      nticks: 4, tickfont: { size: 10, color: soft }, title: { text: `${viewer.axes[k]}, m`, font: { size: 11, color: soft } }, color: soft });
    // A flat arm is looked at from the front, any other from an angle.
    const front = spans[0] < spans[1] ? { x: 2, y: -0.35, z: 0.3 } : { x: 0.35, y: -2, z: 0.3 };
    const eye = viewer.flat ? front : { x: 1.4, y: -1.25, z: 0.65 };
    const scaled = (k) => (1.4 * spans[k]) / largest;
    return [traces, {
      autosize: true, margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false, uirevision: "stay",
      hoverlabel: { bgcolor: report.color("paper"), bordercolor: report.color("line"), font: { color: ink, size: 12 } },
      font: { family: getComputedStyle(document.body).fontFamily, color: soft },
      scene: { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "manual", aspectratio: { x: scaled(0), y: scaled(1), z: scaled(2) },
        camera: { eye, center: { x: 0, y: 0, z: viewer.flat ? 0 : -0.15 } }, dragmode: "turntable" },
    }, { displaylogo: false, responsive: true, displayModeBar: false, scrollZoom: false }];
  }

  function describe() {
    const f = view.frame;
    element("clock").textContent = `Set point ${viewer.at[f]} of ${viewer.at[last]}, ${number(viewer.time[f])} s`;
    viewer.joints.forEach((joint, k) => {
      rows[k].cells[1].textContent = position(joint, viewer.q[f][k]);
      rows[k].cells[2].textContent = `${number(viewer.torque[f][k])} ${joint.effort}`;
    });
    slider.value = f;
    slider.setAttribute("aria-valuetext", `set point ${viewer.at[f]}`);
  }

  function goTo(frame) {
    view.frame = Math.max(0, Math.min(last, frame));
    describe();
    if (!view.available) return;
    const [x, y, z] = columns(viewer.points[view.frame]);
    Plotly.restyle(scene, { x: [x, [x.at(-1)]], y: [y, [y.at(-1)]], z: [z, [z.at(-1)]], text: [labels(view.frame), null] }, [3, 4]);
  }

  function stop() {
    view.playing = false;
    play.setAttribute("aria-pressed", "false");
    play.textContent = "▶ Play";
  }

  function step(now) {
    if (!view.playing) return;
    const speed = Number(element("speed").value);
    const passed = ((now - view.started) / 1000) * speed;
    const time = viewer.time[view.from] + passed;
    let frame = view.from;
    while (frame < last && viewer.time[frame + 1] <= time) frame += 1;
    if (frame !== view.frame) goTo(frame);
    // The last posture stays for a moment before the motion starts over.
    if (frame === last && time > viewer.time[last] + 0.7 * speed) { view.from = 0; view.started = now; }
    requestAnimationFrame(step);
  }

  function restart() {
    view.from = view.frame === last ? 0 : view.frame;
    view.started = performance.now();
  }

  play.addEventListener("click", () => {
    if (view.playing) return stop();
    view.playing = true;
    play.setAttribute("aria-pressed", "true");
    play.textContent = "❚❚ Pause";
    restart();
    requestAnimationFrame(step);
  });
  element("speed").addEventListener("change", restart);
  slider.addEventListener("input", () => { stop(); goTo(Number(slider.value)); });

  if (last === 0) { play.disabled = true; slider.disabled = true; }
  view.draw = () => {
    if (!view.available) return Promise.resolve();
    return Plotly.react(scene, ...build());
  };
  const canvas = document.createElement("canvas");
  if (canvas.getContext("webgl2") || canvas.getContext("webgl")) {
    view.available = true;
    new IntersectionObserver((entries, observer) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      observer.disconnect();
      view.draw();
    }, { rootMargin: "300px" }).observe(scene);
    report.themed.push(() => { if (scene.data) view.draw(); });
  } else {
    element("viewer").classList.add("no-webgl");
    element("nogl").hidden = false;
  }
  describe();
  view.goTo = goTo;
  return view;
})();
