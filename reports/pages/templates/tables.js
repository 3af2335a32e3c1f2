// Tables: sorted by their headers, filtered by words, saved as CSV; all of it in the address.
const FEWEST_FILTERED = 8;

const compare = (a, b) => {
  const x = Number(a), y = Number(b);
  if (!Number.isNaN(x) && !Number.isNaN(y)) return x - y;
  return a.localeCompare(b, undefined, { numeric: true });
};
const missing = (key) => key === "nan" || key === "" || key === "–";

const sortable = (table) => {
  const key = `sort.${table.id}`;
  const body = table.tBodies[0], heads = [...table.querySelectorAll("thead th")];
  const original = [...body.rows];
  heads.forEach((head, index) => {
    // A link inside a button could not be followed: the explanation stays as the hover text.
    const abbr = head.querySelector("abbr");
    const made = element("button", { type: "button" }, head.textContent);
    if (abbr) made.title = abbr.title;
    head.replaceChildren(made);
    made.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      state.set(key, index + (up ? "a" : "d"), table);
      apply();
    });
  });
  const apply = () => {
    const [, place, way] = /^(\d+)([ad])$/.exec(state.get(key) ?? "") ?? [];
    const index = Number(place), up = way === "a";
    const wanted = place !== undefined && index < heads.length;
    heads.forEach((head, column) => {
      if (wanted && column === index) head.setAttribute("aria-sort", up ? "ascending" : "descending");
      else head.removeAttribute("aria-sort");
    });
    if (!wanted) return body.append(...original);
    // Errors, which have a bar, are sorted by size.
    const keyOf = (cell) => cell.dataset.bar === undefined ? valueOf(cell) : valueOf(cell).replace(/^-/, "");
    const keys = new Map(original.map((row) => [row, keyOf(row.cells[index] ?? row.cells[0])]));
    body.append(...[...original].sort((a, b) => {
      const [x, y] = [keys.get(a), keys.get(b)];
      if (missing(x) !== missing(y)) return missing(x) ? 1 : -1; // unknown values stay last
      return up ? compare(x, y) : compare(y, x);
    }));
  };
  state.follow(apply);
};

const filterable = (table, tools) => {
  const rows = [...table.tBodies[0].rows];
  if (rows.length < FEWEST_FILTERED) return;
  const key = `filter.${table.id}`;
  const input = element("input", { type: "search", placeholder: "search words", "aria-label": `Filter rows: ${table.dataset.label}` });
  const count = element("span", { class: "count", role: "status" });
  tools.prepend(element("label", {}, "Filter rows ", input), count);
  const text = new Map(rows.map((row) => [row, row.textContent.toLowerCase()]));
  const apply = () => {
    input.value = state.get(key) ?? "";
    const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const row of rows) {
      row.hidden = !wanted.every((word) => text.get(row).includes(word));
      shown += row.hidden ? 0 : 1;
    }
    const fold = table.closest("details");
    if (fold && wanted.length) fold.open = true; // a link to a filtered table shows it
    count.textContent = wanted.length ? `${shown} of ${rows.length} rows` : "";
  };
  input.addEventListener("input", () => {
    state.set(key, input.value, table);
    apply();
  });
  state.follow(apply);
};

const equipTables = () => {
  for (const table of document.querySelectorAll("table[id][data-label]")) {
    const tools = element("div", { class: "table-tools" });
    tools.append(button("CSV", `CSV of: ${table.dataset.label}`, () => saveTable(table)));
    (table.closest(".scroll") ?? table).before(tools);
    if (table.matches(".data, .sortable")) {
      filterable(table, tools);
      sortable(table);
    }
  }
};

// What is shown: one scene or all, one quantity or all.
const equipChoices = () => {
  const form = document.querySelector("form.choices");
  if (!form) return;
  form.hidden = false;
  form.addEventListener("submit", (event) => event.preventDefault());
  const [scene, quantity] = ["scene", "quantity"].map((name) => form.querySelector(`select[name=${name}]`));
  const known = (select, value) => [...select.options].some((option) => option.value === value) ? value : "";
  const apply = () => {
    scene.value = known(scene, state.get("scene") ?? "");
    quantity.value = known(quantity, state.get("quantity") ?? "");
    for (const section of document.querySelectorAll("section.scene")) section.hidden = Boolean(scene.value) && section.id !== scene.value;
    if (scene.value) document.querySelector(`#${scene.value} > details`).open = true;
    for (const figure of document.querySelectorAll("figure[data-quantity]"))
      figure.hidden = Boolean(quantity.value) && !figure.dataset.quantity.split(" ").includes(quantity.value);
    for (const group of document.querySelectorAll(".figure-group"))
      group.hidden = ![...group.querySelectorAll("figure")].some((figure) => !figure.hidden);
  };
  for (const select of [scene, quantity]) select.addEventListener("change", () => {
    state.set(select.name, select.value);
    apply();
  });
  state.follow(apply);
};
