// A load typed in: every method's curve read there, as comparisons read it: straight in logarithms
// between two loads, or straight where a value is not positive.
const readAt = ({ x, y }, at) => {
  const next = x.findIndex((value) => value >= at);
  if (next < 0 || !(x[0] <= at)) return null;
  if (x[next] === at) return y[next];
  const ends = [x[next - 1], x[next], y[next - 1], y[next]];
  const log = ends.every((value) => value > 0);
  const [x0, x1, y0, y1] = log ? ends.map(Math.log) : ends;
  const share = ((log ? Math.log(at) : at) - x0) / (x1 - x0);
  const value = y0 + share * (y1 - y0);
  return log ? Math.exp(value) : value;
};

const equipReading = () => {
  const rising = ({ x, y }) => x.length > 1 && x.every((value, i) => i === 0 || value > x[i - 1]) && y.every(Number.isFinite);
  const text = (title) => title.replace(/<br>/g, " ").replace(/<[^>]*>/g, "");
  for (const group of document.querySelectorAll(".figure-group")) {
    const figures = [...group.querySelectorAll("[data-figure*='-curve-']")]
      .map((canvas) => JSON.parse(document.getElementById(`data-${canvas.dataset.figure}`).textContent))
      .map(({ data, layout }) => ({ traces: data.filter((one) => one.name && one.mode.startsWith("lines") && rising(one)), layout }))
      .filter(({ traces }) => traces.length);
    if (!figures.length) continue;
    const along = text(figures[0].layout.xaxis.title.text);
    const loads = figures[0].traces[0].x, ends = [loads[0], loads.at(-1)].map((value) => Number(value.toPrecision(4)));
    const methods = [...new Set(figures.flatMap(({ traces }) => traces.map((one) => one.name)))];
    const input = element("input", { type: "number", step: "any", min: "0", placeholder: ends.join(" to ") });
    const result = element("div", { class: "scroll", "aria-live": "polite" });
    const key = `at.${sceneOf(group)}`;
    const show = () => {
      input.value = state.get(key) ?? "";
      const at = Number(input.value);
      if (!input.value) return result.replaceChildren();
      const heads = ["method", ...figures.map(({ layout }) => text(layout.yaxis.title.text))];
      const rows = methods.map((name) => [name, ...figures.map(({ traces }) => {
        const trace = traces.find((one) => one.name === name), value = trace && readAt(trace, at);
        return Number.isFinite(value) ? String(Number(value.toPrecision(4))) : "–";
      })]);
      if (rows.every((row) => row.slice(1).every((cell) => cell === "–"))) {
        return result.replaceChildren(element("p", { class: "note" }, `Computed from ${ends.join(" to ")}.`));
      }
      return result.replaceChildren(element("table", { class: "data" },
        element("thead", {}, element("tr", {}, ...heads.map((head) => element("th", { scope: "col" }, head)))),
        element("tbody", {}, ...rows.map(([name, ...cells]) => element("tr", {}, element("th", { scope: "row" }, name), ...cells.map((cell) => element("td", { class: "number" }, cell)))))));
    };
    input.addEventListener("input", () => {
      state.set(key, input.value, group);
      show();
    });
    group.querySelector(".grid").before(element("div", { class: "choices" }, element("label", {}, `Read the curves at ${along} `, input)), result);
    state.follow(show);
  }
};
