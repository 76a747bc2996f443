"use strict";
// Sorts tables by any column and filters their rows by group.
(() => {
  const numeric = (text) => (text === "inf" ? Infinity : Number(text));

  function sortable(table) {
    const body = table.tBodies[0];
    const headers = [...table.tHead.rows[0].cells];
    headers.forEach((header, column) => {
      const button = header.querySelector("button");
      button.addEventListener("click", () => {
        const isNumber = button.dataset.kind === "number";
        const before = header.getAttribute("aria-sort");
        // Large numbers are what one looks for first, except in ranks and joint numbers.
        const natural = isNumber && column > 1 && button.textContent !== "Joint" ? "descending" : "ascending";
        const next = before === null ? natural : before === "ascending" ? "descending" : "ascending";
        for (const other of headers) other.removeAttribute("aria-sort");
        header.setAttribute("aria-sort", next);
        const key = (row) => row.cells[column].dataset.value;
        const sign = next === "ascending" ? 1 : -1;
        const compare = isNumber ? (a, b) => numeric(key(a)) - numeric(key(b)) || 0 : (a, b) => key(a).localeCompare(key(b));
        body.append(...[...body.rows].sort((a, b) => sign * compare(a, b)));
      });
    });
  }

  function filtered(group) {
    const table = document.getElementById(group.dataset.table);
    const rows = [...table.tBodies[0].rows];
    const buttons = [...group.querySelectorAll("button")];
    for (const button of buttons) {
      button.addEventListener("click", () => {
        for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
        const wanted = button.dataset.group;
        let count = 0;
        for (const row of rows) {
          row.hidden = wanted !== "" && row.dataset.group !== wanted;
          count += row.hidden ? 0 : 1;
        }
        table.querySelector(".shown").textContent = wanted ? `${count} of ${rows.length} shown.` : "";
      });
    }
  }

  for (const table of document.querySelectorAll(".sortable")) sortable(table);
  for (const group of document.querySelectorAll(".filter")) filtered(group);
})();
