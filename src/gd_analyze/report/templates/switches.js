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

  // A table wider than its room says where there is more of it, and can be scrolled with the keyboard.
  function hint(box) {
    const hidden = box.scrollWidth - box.clientWidth;
    box.classList.toggle("more-left", box.scrollLeft > 1);
    box.classList.toggle("more-right", hidden - box.scrollLeft > 1);
    if (hidden > 1) box.tabIndex = 0; else box.removeAttribute("tabindex");
  }
  const rooms = new ResizeObserver((entries) => { for (const { target } of entries) hint(target); });
  for (const box of all(".scroll, .triangle-scroll")) {
    rooms.observe(box);
    box.addEventListener("scroll", () => hint(box), { passive: true });
  }

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
