"use strict";
// Switches, theme, and the enlarged element.
(() => {
  const root = document.documentElement;
  const all = (selector) => [...document.querySelectorAll(selector)];
  const press = (button, on) => button.setAttribute("aria-pressed", String(on));

  for (const button of all("button[data-role]")) {
    button.addEventListener("click", () => {
      const { role } = button.dataset;
      const hide = !report.state.hidden.has(role);
      if (hide) report.state.hidden.add(role); else report.state.hidden.delete(role);
      press(button, !hide);
      report.drawAll();
    });
  }
  for (const [key, set] of [["x", (value) => { report.state.x = value; }], ["shared", (value) => { report.state.shared = value !== ""; }]]) {
    const buttons = all(`button[data-${key}]`);
    for (const button of buttons) {
      button.addEventListener("click", () => {
        set(button.dataset[key]);
        for (const other of buttons) press(other, other === button);
        report.drawAll();
      });
    }
  }

  const dark = matchMedia("(prefers-color-scheme: dark)");
  document.getElementById("theme").addEventListener("click", () => {
    root.dataset.theme = (root.dataset.theme || (dark.matches ? "dark" : "light")) === "dark" ? "light" : "dark";
  });

  // A table wider than its room can be scrolled with the keyboard.
  const cue = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      const wide = target.scrollWidth > target.clientWidth + 1;
      target.classList.toggle("wide", wide);
      if (wide) target.tabIndex = 0; else target.removeAttribute("tabindex");
    }
  });
  for (const box of all(".scroll, .triangle-scroll")) cue.observe(box);

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
})();
