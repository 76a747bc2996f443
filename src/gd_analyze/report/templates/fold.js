"use strict";
// Folds open for what leads into them: a link, a place in the address, and paper, which has all of them open.
(() => {
  function reveal() {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    let closed = false;
    for (let fold = target.closest("details"); fold; fold = fold.parentElement.closest("details")) {
      closed = closed || !fold.open;
      fold.open = true;
    }
    if (closed) target.scrollIntoView();
  }
  addEventListener("hashchange", reveal);
  // A link to where the address already points changes nothing in it.
  document.addEventListener("click", (event) => {
    const link = event.target.closest('a[href^="#"]');
    if (link && link.hash === location.hash) setTimeout(reveal);
  });
  reveal();

  const folds = [...document.querySelectorAll("details")], all = document.getElementById("open-all");
  const tellAll = () => { all.textContent = folds.every((fold) => fold.open) ? "Fold all" : "Unfold all"; };
  all.addEventListener("click", () => {
    const open = !folds.every((fold) => fold.open);
    for (const fold of folds) fold.open = open;
  });
  for (const fold of folds) fold.addEventListener("toggle", tellAll);

  const root = document.documentElement;
  let opened = [], theme;
  addEventListener("beforeprint", () => {
    theme = root.dataset.theme;
    root.dataset.theme = "light";
    root.classList.add("printing");
    opened = folds.filter((fold) => !fold.open);
    for (const fold of opened) fold.open = true;
    report.drawAll();
    report.viewer.draw();
  });
  addEventListener("afterprint", () => {
    root.classList.remove("printing");
    if (theme) root.dataset.theme = theme; else delete root.dataset.theme;
    for (const fold of opened) fold.open = false;
    report.drawAll();
    report.viewer.draw();
  });
})();
