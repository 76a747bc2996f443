// The main report: the arm that plays and turns, and the budget that moves.
const data = JSON.parse(document.getElementById("report-data").textContent);
const element = (id) => document.getElementById(id);
const calm = matchMedia("(prefers-reduced-motion: reduce)");

// A unit with the prefix that keeps a value short, as the program's words have it.
function quantity(value, unit) {
  const power = 3 * Math.floor(Math.log10(Math.abs(value) || 1) / 3 + 1e-9);
  const prefix = { "-9": "n", "-6": "µ", "-3": "m", 3: "k", 6: "M" }[power];
  const fits = !unit.startsWith("N") || !prefix || (Math.abs(value) >= 0.1 && Math.abs(value) < 1e4);
  return fits ? `${number(value)} ${unit}` : `${number(value / 10 ** power)} ${prefix}${unit}`;
}

const viewer = (() => {
  const { arm } = data, svg = element("scene").firstElementChild, slider = element("frame"), play = element("play"), turn = element("turn");
  const last = arm.poses.length - 1, rows = [...element("state").rows];
  const view = { frame: 0, playing: false, azimuth: arm.azimuth, elevation: arm.elevation };
  slider.max = last;
  turn.value = arm.azimuth;
  // Lines of the drawing as points in space; the pose that plays is one more line, on top.
  const spatial = all("[data-space]", svg).map((path) => {
    const numbers = path.dataset.space.split(" ").map(Number);
    return [path, Array.from({ length: numbers.length / 3 }, (_, k) => numbers.slice(3 * k, 3 * k + 3))];
  });
  const words = all("text", svg).map((text) => [text, text.dataset.space3 && text.dataset.space3.split(" ").map(Number)]);
  const limb = svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "path"));
  limb.setAttribute("class", "pose");
  let place;
  function aim() {
    const a = (view.azimuth * Math.PI) / 180, e = (view.elevation * Math.PI) / 180;
    const right = [-Math.sin(a), Math.cos(a), 0], up = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
    const dot = (p, v) => p[0] * v[0] + p[1] * v[1] + p[2] * v[2];
    place = (p) => [
      Math.round(20 * (arm.corner[0] + arm.scale * (dot(p, right) - arm.origin[0]))),
      Math.round(20 * (arm.corner[1] + arm.scale * (arm.origin[1] - dot(p, up)))),
    ];
  }
  const line = (points) => points.map((p, k) => (isNaN(p[0]) ? "" : `${k && !isNaN(points[k - 1][0]) ? "L" : "M"}${place(p).join(" ")}`)).join("");
  function pose() {
    limb.setAttribute("d", line(arm.poses[view.frame]));
    limb.style.display = view.frame || view.playing ? "inline" : "none";
  }
  function draw() {
    aim();
    for (const [path, points] of spatial) path.setAttribute("d", line(points));
    for (const [text, at] of words) {
      if (!at) continue;
      const [x, y] = place(at), shift = text.dataset.shift.split(" ");
      text.setAttribute("x", x + Number(shift[0]));
      text.setAttribute("y", y + Number(shift[1]));
    }
    pose();
    // What turned out of the picture is let in.
    const box = svg.getBBox();
    svg.setAttribute("viewBox", `${box.x} ${box.y} ${box.width} ${box.height}`);
  }
  const piles = all("#figure-contributions svg.panel");
  function goTo(frame) {
    const f = (view.frame = Math.max(0, Math.min(last, frame)));
    pose();
    element("clock").textContent = `${number(arm.time[f], 4)} s, set point ${arm.point[f]} of ${arm.point[last]}`;
    arm.joints.forEach(([revolute, unit], k) => {
      rows[k].cells[1].textContent = revolute ? `${number((arm.q[f][k] * 180) / Math.PI, 4)}°` : quantity(arm.q[f][k], "m");
      rows[k].cells[2].textContent = quantity(arm.torque[f][k], unit);
    });
    slider.value = f;
    slider.setAttribute("aria-valuetext", element("clock").textContent);
    for (const panel of piles) lineAt(panel, "now", f || view.playing ? panel.scale.at(arm.time[f]) : null);
  }
  function stop() {
    view.playing = false;
    play.setAttribute("aria-pressed", "false");
    play.textContent = "▶ Play";
  }
  let from = 0, started = 0;
  function restart() {
    from = view.frame === last ? 0 : view.frame;
    started = performance.now();
  }
  function step(now) {
    if (!view.playing) return;
    const speed = Number(element("speed").value), time = arm.time[from] + ((now - started) / 1000) * speed;
    let frame = from;
    while (frame < last && arm.time[frame + 1] <= time) frame += 1;
    if (frame !== view.frame) goTo(frame);
    // The last pose stays for a moment before the motion starts over.
    if (frame === last && time > arm.time[last] + 0.7 * speed) { from = 0; started = now; }
    requestAnimationFrame(step);
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
  turn.addEventListener("input", () => { view.azimuth = Number(turn.value); draw(); });
  let held = null;
  svg.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY, view.azimuth, view.elevation];
    svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointermove", (event) => {
    if (!held) return;
    view.azimuth = ((((held[2] - 0.5 * (event.clientX - held[0]) + 180) % 360) + 360) % 360) - 180;
    if (event.pointerType === "mouse") view.elevation = Math.max(-10, Math.min(90, held[3] + 0.4 * (event.clientY - held[1])));
    turn.value = Math.round(view.azimuth);
    draw();
  });
  for (const done of ["pointerup", "pointercancel"]) svg.addEventListener(done, () => { held = null; });
  if (last === 0) { play.disabled = true; slider.disabled = true; }
  aim();
  goTo(0);
  return Object.assign(view, { goTo });
})();

// A cell of the matrix opens its element; arrow keys go from cell to cell.
document.body.classList.add("scripted");
(() => {
  const panel = element("element"), cells = all(".cell"), details = data.elements;
  const escaped = (words) => words.replace(/&/g, "&amp;").replace(/</g, "&lt;");
  const dotted = { q: "q", qd: "q\u0307", qdd: "q\u0308" };
  const maths = (words) => escaped(words).replace(/ - /g, " − ").replace(/(qdd|qd|q|[CSDJhcd])(\d[\d,]*)/g, (_, letter, joints) => `<i>${dotted[letter] || letter}</i><sub>${joints}</sub>`);
  const kinds = ["zero", "negligible", "translation", "rotation", "both", "drive"], letters = ["0", "–", "T", "R", "T+R", "J"];
  function strip(marks) {
    const runs = marks.match(/(.)\1*/g).map((run) => `<i class="${kinds[run[0]]}" style="flex:${run.length}" title="${kinds[run[0]]}">${letters[run[0]]}</i>`);
    return `<div class="strip" aria-hidden="true">${runs.join("")}</div>`;
  }
  function show(label) {
    const detail = details[label], drawn = document.querySelector(`.drawing svg.panel[data-key="${label}"]`).cloneNode(true);
    const line = (words) => `<dd>${maths(`${label} = ${words}`)}</dd>`;
    const over = detail.over_time && `<dt>Verdict over time${detail.changes && `: ${detail.changes}`}</dt><dd>${strip(detail.over_time)}</dd>`;
    const exact = detail.exact === undefined ? "" : `<dt>Exact</dt>${line(detail.exact)}`;
    const simplified = detail.simplified === undefined ? "" : `<dt>In this report's model</dt>${line(detail.simplified)}`;
    panel.innerHTML = `<h3>${detail.name} <span>${escaped(detail.words)}</span></h3><button type="button" class="close" aria-label="Close">✕</button><div class="curve"></div><dl>${over}${exact}${simplified}</dl>`;
    panel.querySelector(".curve").append(drawn);
    for (const curve of all(".combined", drawn)) curve.style.display = "inline";
    follow(drawn);
    panel.hidden = false;
    for (const cell of cells) cell.setAttribute("aria-pressed", String(cell.dataset.element === label));
    panel.querySelector(".close").addEventListener("click", () => {
      panel.hidden = true;
      for (const cell of cells) cell.setAttribute("aria-pressed", "false");
      cells.find((cell) => cell.dataset.element === label).focus();
    });
    panel.scrollIntoView({ block: "nearest", behavior: calm.matches ? "auto" : "smooth" });
  }
  const place = (cell) => { const box = cell.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; };
  for (const cell of cells) {
    cell.addEventListener("click", () => show(cell.dataset.element));
    cell.addEventListener("focus", () => { for (const other of cells) other.tabIndex = other === cell ? 0 : -1; });
    cell.addEventListener("keydown", (event) => {
      const step = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] }[event.key];
      if (!step) return;
      event.preventDefault();
      const [x, y] = place(cell);
      const ahead = cells.map((other) => [other, ...place(other)]).map(([other, u, v]) => [other, (u - x) * step[0] + (v - y) * step[1], Math.abs((u - x) * step[1]) + Math.abs((v - y) * step[0])]);
      const near = ahead.filter(([, along, across]) => along > 4 && across < 4).sort((a, b) => a[1] - b[1])[0];
      if (near) near[0].focus();
    });
  }
  cells[0].tabIndex = 0;
})();

// Every place of the slider is a model found before, on one path through the model of this report.
if (data.budgets) {
  const { budgets } = data, slider = element("budget-slider"), rows = [...element("joint-errors").tBodies[0].rows];
  const terms = all("[data-kept]"), stops = all("[data-stop]"), asked = budgets.asked;
  let timer = 0, saying = 0;
  const percent = (share) => (share === 0 ? "0 %" : share > 100 ? "more than 100 times" : share < 1e-4 ? "< 0.01 %" : share < 0.0995 ? `${Number((100 * share).toPrecision(2))} %` : `${Math.round(100 * share)} %`);

  function settle(at) {
    for (const term of terms) { term.classList.remove("leaving"); term.hidden = term.dataset.kept[at] !== "1"; }
  }
  function show(at) {
    const errors = budgets.largest_error[at];
    // The allowed error moves with the slider, peak torque does not.
    const whole = budgets.whole[at];
    const shares = errors.map((error, k) => (whole[k] > 0 ? error / whole[k] : 0));
    const worst = shares.indexOf(Math.max(...shares));
    element("budget-said").textContent = budgets.label[at];
    const figures = { kept: budgets.kept[at], apart: budgets.apart[at], "apart-angles": budgets.angles_apart[at], count: budgets.operations[at], "count-angles": budgets.angles[at], worst: `up to ${percent(shares[worst])}` };
    for (const [name, figure] of Object.entries(figures)) if (element(`budget-${name}`)) element(`budget-${name}`).textContent = figure;
    element("budget-proof").textContent = budgets.proof[at];
    for (const stop of stops) stop.setAttribute("aria-pressed", String(Number(stop.dataset.stop) === at));
    rows.forEach((row, k) => {
      const used = budgets.used[at][k];
      row.style.setProperty("--used", Math.min(used, 1));
      row.querySelector(".fill").classList.toggle("over", used > 1);
      row.querySelector(".said").textContent = `${quantity(errors[k], budgets.unit[k])} of ${quantity(budgets.allowed[at][k], budgets.unit[k])}`;
      row.querySelector(".value").textContent = percent(used);
    });
    document.body.classList.toggle("other-budget", at !== asked);
    element("budget-reset").disabled = at === asked;
    slider.setAttribute("aria-valuetext", budgets.label[at]);
    for (const term of terms) {
      const stays = term.dataset.kept[at] === "1";
      term.classList.toggle("leaving", !stays);
      if (stays) term.hidden = false;
    }
    clearTimeout(timer);
    if (calm.matches || at === asked) settle(at); else timer = setTimeout(settle, 700, at);
    const counted = budgets.keeps ? `${budgets.kept[at]} ${budgets.keeps}, ` : "";
    return `${counted}${budgets.operations[at]} operations and ${budgets.angles[at]} sines and cosines, errors up to ${percent(shares[worst])} of ${budgets.shares_of} at the set points, at joint ${worst + 1}.`;
  }
  function change() {
    const words = show(Number(slider.value));
    clearTimeout(saying);
    // Announced once the slider rests.
    saying = setTimeout(() => { element("budget-status").textContent = words; }, 900);
  }
  slider.addEventListener("input", change);
  for (const stop of stops) stop.addEventListener("click", () => { slider.value = stop.dataset.stop; change(); });
  element("budget-reset").addEventListener("click", () => { slider.value = asked; change(); slider.focus(); });
  element("budget").classList.add("alive");
  slider.value = asked;
  show(asked);
}
