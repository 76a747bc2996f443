"use strict";
// Sorts the ranking by any column and filters it by verdict.
(() => {
  const table = document.getElementById("dominance");
  const body = table.tBodies[0];
  const headers = [...table.tHead.rows[0].cells];
  const numeric = (text) => (text === "inf" ? Infinity : Number(text));

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

  const filters = [...document.querySelectorAll(".filter button")];
  for (const filter of filters) {
    filter.addEventListener("click", () => {
      for (const other of filters) other.setAttribute("aria-pressed", String(other === filter));
      const wanted = filter.dataset.verdict;
      let count = 0;
      for (const row of body.rows) {
        row.hidden = wanted !== "" && row.dataset.verdict !== wanted;
        count += row.hidden ? 0 : 1;
      }
      document.getElementById("shown").textContent = wanted ? `${count} of ${body.rows.length} shown.` : "";
    });
  }
})();
