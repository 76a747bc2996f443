"use strict";
// The arm in space, turned with mouse, finger or keyboard; every frame is one set point, never an interpolation.
report.viewer = (() => {
  const { viewer } = report.data;
  const element = (id) => document.getElementById(id);
  const scene = element("scene"), slider = element("frame"), play = element("play"), turn = element("turn");
  const rows = [...element("state").rows];
  const last = viewer.at.length - 1;
  // A flat arm is seen head-on, any other from the side and above, as on paper.
  const flat = viewer.flat;
  const view = { frame: 0, playing: false, started: 0, from: 0, azimuth: flat === null ? -52 : flat === 0 ? 0 : -90, elevation: flat === 2 ? 90 : flat === null ? 24 : 0 };
  slider.max = last;
  turn.value = view.azimuth;
  const { line, text, px, path, number } = chart;
  const every = [...viewer.points.flat(), ...viewer.path];
  const low = [0, 1, 2].map((k) => Math.min(...every.map((point) => point[k]))), high = [0, 1, 2].map((k) => Math.max(...every.map((point) => point[k])));

  // A grid on the floor, or in the plane of a flat arm, in steps that are easy to count.
  const normal = flat === null ? 2 : flat;
  const [one, two] = [0, 1, 2].filter((k) => k !== normal);
  const reach = Math.max(high[one] - low[one], high[two] - low[two], 1e-3);
  const [from, to] = chart.ticks(0, reach, 5), step = to - from;
  const first = low.map((value) => Math.floor(value / step + 1e-6) * step), end = high.map((value) => Math.max(Math.ceil(value / step - 1e-6), 1) * step);
  const on = (a, b) => { const point = [0, 0, 0]; point[one] = a; point[two] = b; point[normal] = low[normal]; return point; };
  const grid = [];
  for (let a = first[one]; a <= end[one] + step / 2; a += step) grid.push([on(a, first[two]), on(a, end[two])]);
  for (let b = first[two]; b <= end[two] + step / 2; b += step) grid.push([on(first[one], b), on(end[one], b)]);

  let place = null, size = "";
  function aim(width, height) {
    const a = (view.azimuth * Math.PI) / 180, e = (view.elevation * Math.PI) / 180;
    const right = [-Math.sin(a), Math.cos(a), 0], up = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
    const dot = (p, v) => p[0] * v[0] + p[1] * v[1] + p[2] * v[2];
    const flatly = (p) => [dot(p, right), -dot(p, up)];
    const seen = [...every, ...grid.flat()].map(flatly);
    const [x, y] = [0, 1].map((k) => [Math.min(...seen.map((p) => p[k])), Math.max(...seen.map((p) => p[k]))]);
    const room = [width - 56, height - 58];
    const scale = Math.min(room[0] / Math.max(x[1] - x[0], 1e-6), room[1] / Math.max(y[1] - y[0], 1e-6));
    place = (p) => { const [u, v] = flatly(p); return [width / 2 + scale * (u - (x[0] + x[1]) / 2), height / 2 + scale * (v - (y[0] + y[1]) / 2)]; };
  }

  // Thick at the base, thin at the hand.
  function posture(points, kind) {
    const placed = points.map(place);
    const links = placed.slice(1).map((to, k) => [placed[k], to, k]).filter(([from, to]) => Math.hypot(to[0] - from[0], to[1] - from[1]) > 0.2);
    const limbs = links.map(([from, to, k]) => `<path class="${kind}" style="stroke-width:${px((kind === "limb" ? 7.5 : 2.6) * (1 - (0.6 * k) / placed.length))}" d="${path([from, to])}"/>`).join("");
    if (kind !== "limb") return limbs;
    return limbs + placed.filter((_, k) => k % 2).map(([x, y]) => `<circle class="joint" cx="${px(x)}" cy="${px(y)}" r="3.2"/>`).join("");
  }

  function still() {
    const base = viewer.points[0][0];
    const ends = [viewer.path[0], viewer.path[viewer.path.length - 1]].map(place);
    let out = grid.map(([from, to]) => line(...place(from), ...place(to), "floor")).join("");
    const shadow = viewer.path.map((point) => place(point.map((value, k) => (k === normal ? low[normal] : value))));
    if (flat === null) out += `<path class="shadow" d="${path(shadow, viewer.breaks)}"/>` + line(...place(base), ...place(base.map((value, k) => (k === 2 ? low[2] : value))), "column");
    viewer.axes.forEach((axis, k) => {
      const tip = place(base.map((value, i) => value + 0.9 * step * axis[i])), foot = place(base);
      if (Math.hypot(tip[0] - foot[0], tip[1] - foot[1]) < 8) return;
      const beyond = [0, 1].map((i) => tip[i] + (9 * (tip[i] - foot[i])) / Math.hypot(tip[0] - foot[0], tip[1] - foot[1]));
      out += line(...foot, ...tip, "axis") + text(beyond[0], beyond[1] + 4, "xyz"[k], 'class="axis-name" text-anchor="middle"');
    });
    const ghosts = [0, 0.2, 0.4, 0.6, 0.8, 1].map((share) => Math.round(share * last)).filter((frame, k, all) => all.indexOf(frame) === k);
    out += ghosts.map((frame) => posture(viewer.points[frame], "ghost")).join("");
    out += `<path class="hand" d="${path(viewer.path.map(place), viewer.breaks)}"/>`;
    const closed = Math.hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]) < 9;
    const mark = ([x, y], words, kind, below) => `<circle class="${kind}" cx="${px(x)}" cy="${px(y)}" r="4.5"/>` + text(x, y + (below ? 18 : -9), words, 'class="end-name" text-anchor="middle"');
    if (closed) return [out, mark(ends[0], last ? "start and end" : "hand", "start", false)];
    return [out, mark(ends[0], "start", "start", ends[0][1] > ends[1][1]) + mark(ends[1], "end", "end", ends[0][1] <= ends[1][1])];
  }

  function draw() {
    const width = scene.clientWidth, height = scene.clientHeight;
    if (!width) return;
    aim(width, height);
    const [under, over] = still();
    const note = text(6, height - 6, `grid ${number(step)} m`) + text(6, 14, flat === null ? "path of the hand" : "path of the hand, arm in its plane", 'class="hand-name"');
    scene.innerHTML = chart.svg(width, height, `${under}<g class="now"></g>${over}${note}`);
    size = `${width}×${height}`;
    pose();
  }
  function pose() {
    scene.querySelector(".now").innerHTML = posture(viewer.points[view.frame], "limb");
  }

  const position = (joint, value) => (joint.kind === "revolute" ? `${number((value * 180) / Math.PI)}°` : chart.quantity(value, "m"));
  function describe() {
    const f = view.frame;
    element("clock").textContent = `${number(viewer.time[f])} s, set point ${viewer.at[f]} of ${viewer.at[last]}`;
    viewer.joints.forEach((joint, k) => {
      rows[k].cells[1].textContent = position(joint, viewer.q[f][k]);
      rows[k].cells[2].textContent = chart.quantity(viewer.torque[f][k], joint.effort);
    });
    slider.value = f;
    slider.setAttribute("aria-valuetext", `${number(viewer.time[f])} s, set point ${viewer.at[f]}`);
  }

  function goTo(frame) {
    view.frame = Math.max(0, Math.min(last, frame));
    describe();
    if (place) pose();
    report.mark(viewer.at[view.frame] - 1, view.frame > 0 || view.playing);
  }

  function stop() {
    view.playing = false;
    play.setAttribute("aria-pressed", "false");
    play.textContent = "▶ Play";
  }
  function step_(now) {
    if (!view.playing) return;
    const speed = Number(element("speed").value);
    const time = viewer.time[view.from] + ((now - view.started) / 1000) * speed;
    let frame = view.from;
    while (frame < last && viewer.time[frame + 1] <= time) frame += 1;
    if (frame !== view.frame) goTo(frame);
    // The last posture stays for a moment before the motion starts over.
    if (frame === last && time > viewer.time[last] + 0.7 * speed) { view.from = 0; view.started = now; }
    requestAnimationFrame(step_);
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
    requestAnimationFrame(step_);
  });
  element("speed").addEventListener("change", restart);
  slider.addEventListener("input", () => { stop(); goTo(Number(slider.value)); });

  const wrapped = (angle) => ((((angle + 180) % 360) + 360) % 360) - 180;
  turn.addEventListener("input", () => { view.azimuth = Number(turn.value); draw(); });
  let held = null;
  scene.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY, view.azimuth, view.elevation];
    scene.setPointerCapture(event.pointerId);
  });
  scene.addEventListener("pointermove", (event) => {
    if (!held) return;
    view.azimuth = wrapped(held[2] - 0.5 * (event.clientX - held[0]));
    if (event.pointerType === "mouse") view.elevation = Math.max(-10, Math.min(90, held[3] + 0.4 * (event.clientY - held[1])));
    turn.value = Math.round(view.azimuth);
    draw();
  });
  for (const done of ["pointerup", "pointercancel"]) scene.addEventListener(done, () => { held = null; });

  if (last === 0) { play.disabled = true; slider.disabled = true; }
  new ResizeObserver(() => { if (size !== `${scene.clientWidth}×${scene.clientHeight}`) draw(); }).observe(scene);
  describe();
  return Object.assign(view, { goTo, draw });
})();
