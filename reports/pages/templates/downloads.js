// Downloads, made in the page itself: plots as SVG and PNG in the colours of paper, tables as CSV.
const FIGURE_SIZE = { width: 720, height: 480 };

const save = (name, kind, content) => {
  const address = URL.createObjectURL(new Blob([content], { type: kind }));
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
};

const bytesOf = (address) => {
  const [head, body] = [address.slice(0, address.indexOf(",")), address.slice(address.indexOf(",") + 1)];
  if (!head.endsWith(";base64")) return decodeURIComponent(body);
  return Uint8Array.from(atob(body), (character) => character.charCodeAt(0));
};

const saveFigure = async (canvas, format) => {
  const spec = withTheme(THEMES.light, () => specOf(canvas));
  spec.layout.title = { text: canvas.dataset.title, font: { size: 15 }, x: 0.02, xanchor: "left" };
  spec.layout.margin = { ...spec.layout.template.layout.margin, ...spec.layout.margin, t: 56 };
  const scale = format === "png" ? 2 : 1;
  const address = await Plotly.toImage(spec, { format, scale, ...FIGURE_SIZE });
  const scene = document.getElementById(sceneOf(canvas))?.dataset.name ?? "roughline";
  save(`${slug(scene)}-${slug(canvas.dataset.title)}.${format}`, format === "svg" ? "image/svg+xml" : "image/png", bytesOf(address));
};

const offerFigures = () => {
  for (const canvas of document.querySelectorAll("figure .canvas[data-figure]:not([data-turn])")) {
    const tools = element("div", { class: "figure-tools" });
    for (const format of ["svg", "png"])
      tools.append(button(format.toUpperCase(), `${format.toUpperCase()} of: ${canvas.dataset.title}`, () => saveFigure(canvas, format)));
    canvas.after(tools);
  }
};

// A spreadsheet must not take the text of a stranger for a formula.
const field = (text) => {
  const safe = /^[=+\-@\t\r]/.test(text) && Number.isNaN(Number(text)) ? "'" + text : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
};
const plainText = (cell) => cell.innerText.replace(/\s+/g, " ").trim();
const valueOf = (cell) => {
  const key = cell.dataset.key;
  if (key === undefined) return plainText(cell);
  return key === "nan" ? "" : key;
};

// Columns with bars become two: the value as stored, in the unit of its header, and its bar.
const csvOf = (table) => {
  const heads = [...table.tHead.rows[0].cells];
  const rows = [...table.tBodies].flatMap((body) => [...body.rows]).filter((row) => !row.hidden && !row.classList.contains("family"));
  const barred = heads.map((_, index) => rows.some((row) => row.cells[index]?.dataset.bar !== undefined));
  const lines = [heads.flatMap((head, index) => {
    const name = head.dataset.csv || plainText(head).replace(/ [↕↑↓]$/, "");
    return barred[index] ? [name, `uncertainty of ${name}`] : [name];
  })];
  for (const row of rows) {
    lines.push(heads.flatMap((_, index) => {
      const cell = row.cells[index];
      const value = cell ? valueOf(cell) : "";
      return barred[index] ? [value, (cell?.dataset.bar ?? "").replace("nan", "")] : [value];
    }));
  }
  return "\ufeff" + lines.map((line) => line.map(field).join(",")).join("\r\n") + "\r\n";
};

const saveTable = (table) => {
  const scene = document.getElementById(sceneOf(table))?.dataset.name ?? "roughline";
  save(`${slug(scene)}-${slug(table.dataset.label)}.csv`, "text/csv", csvOf(table));
};
