"use strict";
// Switches, theme, the enlarged element and printing.
(() => {
  const root = document.documentElement;
  const all = (selector) => [...document.querySelectorAll(selector)];
  const press = (button, on) => button.setAttribute("aria-pressed", String(on));

  for (const button of all("[data-role]")) {
    button.addEventListener("click", () => {
      const { role } = button.dataset;
      const hide = !report.state.hidden.has(role);
      if (hide) report.state.hidden.add(role); else report.state.hidden.delete(role);
      press(button, !hide);
      report.refresh();
    });
  }
  for (const [key, set] of [["x", (value) => { report.state.x = value; }], ["shared", (value) => { report.state.shared = value !== ""; }]]) {
    const buttons = all(`[data-${key}]`);
    for (const button of buttons) {
      button.addEventListener("click", () => {
        set(button.dataset[key]);
        for (const other of buttons) press(other, other === button);
        report.refresh();
      });
    }
  }

  const dark = matchMedia("(prefers-color-scheme: dark)");
  const theme = () => root.dataset.theme || (dark.matches ? "dark" : "light");
  document.getElementById("theme").addEventListener("click", () => {
    root.dataset.theme = theme() === "dark" ? "light" : "dark";
    report.refresh();
  });
  dark.addEventListener("change", () => report.refresh());

  const lens = document.getElementById("lens");
  function enlarge(panel) {
    for (const other of all(".panel.chosen")) other.classList.remove("chosen");
    panel.classList.add("chosen");
    lens.querySelector(".title").replaceChildren(panel.querySelector("math").cloneNode(true));
    lens.querySelector(".text").innerHTML = panel.querySelector(".note").innerHTML;
    lens.dataset.element = panel.dataset.element;
    report.show(lens.querySelector(".plot"), panel.dataset.element);
  }
  for (const button of all(".enlarge")) {
    button.addEventListener("click", () => {
      enlarge(button.closest(".panel"));
      const box = lens.getBoundingClientRect();
      if (box.bottom < 0 || box.top > innerHeight) lens.scrollIntoView({ block: "center" });
    });
  }
  enlarge(document.querySelector(`.panel[data-element="${lens.dataset.element}"]`));

  let before = "";
  addEventListener("beforeprint", () => {
    before = root.dataset.theme || "";
    root.dataset.theme = "light";
    root.classList.add("printing");
    for (const plot of report.plots.values()) plot.dirty = true;
    report.drawAll();
    for (const div of report.plots.keys()) Plotly.relayout(div, { width: div.clientWidth, height: div.clientHeight });
  });
  addEventListener("afterprint", () => {
    root.classList.remove("printing");
    if (before) root.dataset.theme = before; else delete root.dataset.theme;
    report.refresh();
  });
})();
