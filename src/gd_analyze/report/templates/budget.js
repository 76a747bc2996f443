"use strict";
// The budget one can drag: every step is a model found before, on one path through the model of this report.
report.budget = (() => {
  const slider = document.getElementById("budget-slider");
  if (!slider) return null;
  const { budgets } = report.data;
  const element = (id) => document.getElementById(id);
  const terms = [...document.querySelectorAll("[data-kept]")];
  const rows = [...element("joint-errors").tBodies[0].rows];
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const asked = budgets.factor.indexOf(1);
  let timer = 0;

  const percent = (share) => (share === 0 ? "0 %" : share < 1e-4 ? "< 0.01 %" : share < 0.0995 ? `${Number((100 * share).toPrecision(2))} %` : `${Math.round(100 * share)} %`);
  // Signs of what comes first are said only where negative, and brackets stand around more than one.
  const inside = (group) => [...group.children].filter((child) => child.matches(".term, .bracket"));
  function order(members, begins) {
    const left = members.filter((member) => !member.hidden);
    for (const member of members) member.classList.toggle("first", begins && member === left[0]);
    return left;
  }
  function tidy() {
    for (const bracket of document.querySelectorAll(".torque .bracket")) {
      const left = order(inside(bracket), true);
      bracket.hidden = left.length === 0;
      bracket.classList.toggle("single", left.length === 1 && !left[0].classList.contains("negative"));
    }
    for (const torque of document.querySelectorAll(".torque")) {
      const lines = [...torque.querySelectorAll(".line")], carried = lines.some((line) => line.matches(".carried"));
      for (const line of lines) if (!line.matches(".carried, .nothing")) line.hidden = inside(line).every((member) => member.hidden);
      const left = order(lines.flatMap(inside), !carried);
      torque.querySelector(".nothing").hidden = carried || left.length > 0;
    }
  }
  function leave(at) {
    for (const term of terms) {
      const stays = term.dataset.kept[at] === "1";
      term.classList.toggle("leaving", !stays);
      if (stays) term.hidden = false;
    }
    tidy();
    clearTimeout(timer);
    const settle = () => {
      for (const term of terms) term.hidden = term.dataset.kept[at] !== "1";
      tidy();
    };
    if (calm.matches) settle(); else timer = setTimeout(settle, 700);
  }

  function show(at) {
    const errors = budgets.largest_error[at];
    // What is allowed moves with the slider, peak torque does not.
    const moved = budgets.shares_of === "peak torque" ? 1 : budgets.factor[at];
    const shares = errors.map((error, k) => (budgets.whole[k] > 0 ? error / (budgets.whole[k] * moved) : 0));
    const worst = shares.indexOf(Math.max(...shares));
    element("budget-said").textContent = budgets.label[at];
    element("budget-count").textContent = budgets.operations[at];
    if (budgets.keeps) element("budget-kept").textContent = budgets.kept[at];
    element("budget-worst").textContent = percent(shares[worst]);
    element("budget-fill").style.setProperty("--fill", budgets.operations[at] / Math.max(budgets.exact, 1));
    rows.forEach((row, k) => {
      row.style.setProperty("--error", budgets.place[at][k]);
      row.style.setProperty("--budget", budgets.limit[at]);
      row.querySelector(".said").textContent = `${chart.quantity(errors[k], budgets.unit[k])} of ${chart.quantity(budgets.factor[at] * budgets.allowed[k], budgets.unit[k])}`;
      row.querySelector(".value").textContent = percent(shares[k]);
    });
    document.body.classList.toggle("other-budget", at !== asked);
    element("budget-reset").disabled = at === asked;
    slider.setAttribute("aria-valuetext", budgets.label[at]);
    mark();
    leave(at);
    return `${budgets.operations[at]} operations, ${budgets.keeps ? `${budgets.kept[at]} ${budgets.keeps}, ` : ""}largest error ${percent(shares[worst])} of the ${budgets.shares_of} at joint ${worst + 1}.`;
  }

  // In the trade-off, too, where one is drawn.
  const tradeOff = document.querySelector('.plot[data-figure="trade-off"]');
  function mark() {
    const plot = report.plots.get(tradeOff), at = Number(slider.value);
    if (!plot || !plot.box) return;
    const error = 100 * Math.max(...budgets.largest_error[at].map((one, k) => (budgets.whole[k] > 0 ? one / budgets.whole[k] : 0)));
    tradeOff.querySelector(".at-budget").innerHTML = at === asked ? "" : `<circle cx="${chart.px(plot.box.atX(error))}" cy="${chart.px(plot.box.atY(budgets.operations[at]))}" r="6"/>`;
  }
  if (tradeOff) tradeOff.addEventListener("drawn", mark);

  let saying = 0;
  function change() {
    const words = show(Number(slider.value));
    clearTimeout(saying);
    // Said once the hand rests, not at every step.
    saying = setTimeout(() => { element("budget-status").textContent = words; }, 900);
  }
  slider.addEventListener("input", change);
  element("budget-reset").addEventListener("click", () => { slider.value = asked; change(); slider.focus(); });
  element("budget").classList.add("alive");
  slider.value = asked;
  show(asked);
  clearTimeout(timer);
  for (const term of terms) { term.classList.remove("leaving"); term.hidden = term.dataset.kept[asked] !== "1"; }
  tidy();
  return { show };
})();
