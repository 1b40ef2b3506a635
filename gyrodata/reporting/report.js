for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
  const key = (row, i) => (row.cells[i].querySelector("data:only-child")?.value ?? row.cells[i].textContent).trim();
  heads.forEach((head, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.title = "sort by this column";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach(other => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const rows = [...body.rows], number = row => key(row, i) === "–" ? 0 : key(row, i) === "" ? NaN : Number(key(row, i));
      const numbers = rows.every(row => !Number.isNaN(number(row)));
      rows.sort((p, q) => numbers ? number(p) - number(q) : key(p, i).localeCompare(key(q, i), "en", {numeric: true}));
      body.append(...(up ? rows : rows.reverse()));
    });
  });
}
