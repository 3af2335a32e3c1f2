"use strict";
(() => {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const coarse = window.matchMedia("(pointer: coarse)").matches;
  const hovering = window.matchMedia("(hover: hover)").matches;
  const PRINT_WIDTH = 330, PRINT_HEIGHT = 320;
  const THEMES = {
    light: { ink: "#1a1a1a", muted: "#6b7075", grid: "#e3e5e8", paper: "#ffffff", peer: "#767676",
      "ink-band": "rgba(0,0,0,0.16)", "peer-band": "rgba(118,118,118,0.2)", "truth-band": "rgba(90,100,110,0.22)" },
    dark: { ink: "#e8e8e8", muted: "#a3a8ae", grid: "#33373d", paper: "#16181b", peer: "#9a9a9a",
      "ink-band": "rgba(255,255,255,0.2)", "peer-band": "rgba(154,154,154,0.25)", "truth-band": "rgba(190,200,210,0.2)" },
  };
  let theme = dark.matches ? THEMES.dark : THEMES.light;
  const drawn = new Set();

  // Replace "@ink" and its like by the colours of the theme, everywhere in a figure.
  const coloured = (value) => {
    if (typeof value === "string") return value[0] === "@" && theme[value.slice(1)] || value;
    if (Array.isArray(value)) return value.map(coloured);
    if (value && typeof value === "object")
      return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, coloured(item)]));
    return value;
  };

  const shared = () => {
    const axis = {
      gridcolor: theme.grid, linecolor: theme.muted, tickcolor: theme.muted, zeroline: false,
      showline: true, mirror: true, ticks: "outside", ticklen: 5, automargin: true,
      exponentformat: "power", minexponent: 5, title: { standoff: 8 },
    };
    return { layout: {
      font: { family: "system-ui, 'Segoe UI', 'Liberation Sans', Arial, sans-serif", size: 13, color: theme.ink },
      paper_bgcolor: theme.paper, plot_bgcolor: theme.paper, separators: ".\u202f",
      margin: { l: 60, r: 14, t: 30, b: 50 }, xaxis: axis, yaxis: axis,
      legend: { orientation: "h", yref: "container", y: 0, yanchor: "bottom", traceorder: "normal", xref: "container", x: 0.01, xanchor: "left", bgcolor: "rgba(0,0,0,0)", font: { size: 11.5 } },
      hoverlabel: { bgcolor: theme.paper, bordercolor: theme.muted, font: { color: theme.ink, size: 12 }, align: "left" },
      hovermode: "closest",
    } };
  };

  const specOf = (canvas) => {
    const spec = coloured(JSON.parse(document.getElementById("data-" + canvas.dataset.figure).textContent));
    spec.layout.template = shared();
    spec.layout.autosize = true;
    if (coarse) spec.layout.dragmode = false;
    return spec;
  };
  const CONFIG = { displaylogo: false, responsive: true, displayModeBar: hovering ? "hover" : false, scrollZoom: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };

  const draw = (canvas, print) => {
    const spec = specOf(canvas);
    if (print) {
      Object.assign(spec.layout, { autosize: false, width: PRINT_WIDTH, height: PRINT_HEIGHT });
      spec.layout.template.layout.font.size = 10;
      spec.layout.template.layout.legend.font.size = 9;
    }
    drawn.add(canvas);
    return Plotly.react(canvas, spec.data, spec.layout, CONFIG);
  };

  // One plot at a time, so that scrolling stays smooth while many come into sight at once.
  const queue = [];
  const drawNext = () => {
    const canvas = queue.shift();
    if (canvas && !drawn.has(canvas)) draw(canvas);
    if (queue.length) setTimeout(drawNext, 0);
  };
  const enqueue = (canvas) => { if (queue.push(canvas) === 1) setTimeout(drawNext, 0); };

  const canvases = [...document.querySelectorAll("[data-figure]")];
  if ("IntersectionObserver" in window) {
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        watcher.unobserve(entry.target);
        enqueue(entry.target);
      }
    }, { rootMargin: "600px 0px" });
    // What is in sight from the start need not wait for the watcher.
    for (const canvas of canvases) {
      if (canvas.getBoundingClientRect().top < window.innerHeight + 600) enqueue(canvas);
      else watcher.observe(canvas);
    }
  } else canvases.forEach(enqueue);

  const redraw = () => { theme = dark.matches ? THEMES.dark : THEMES.light; drawn.forEach((canvas) => draw(canvas)); };
  dark.addEventListener("change", redraw);

  // Paper is always light and has a width of its own.
  window.addEventListener("beforeprint", () => {
    theme = THEMES.light;
    canvases.forEach((canvas) => draw(canvas, true));
  });
  window.addEventListener("afterprint", redraw);

  // A link into folded text opens it.
  const unfold = () => {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const details = target && target.closest("details");
    if (details) details.open = true;
  };
  window.addEventListener("hashchange", unfold);
  unfold();

  const compare = (a, b) => {
    const x = parseFloat(a), y = parseFloat(b);
    const known = [x, y].map((value) => !Number.isNaN(value));
    if (known[0] && known[1]) return x - y;
    if (known[0] !== known[1] && (a === "nan" || b === "nan" || a === "" || b === "")) return known[0] ? -1 : 1;
    return a.localeCompare(b);
  };

  const sortable = (table) => {
    const body = table.tBodies[0];
    table.querySelectorAll("thead th").forEach((head, index) => {
      const button = document.createElement("button");
      button.type = "button";
      // A link inside a button could not be followed: the explanation stays as the hover text.
      const abbr = head.querySelector("abbr");
      button.textContent = head.textContent;
      if (abbr) button.title = abbr.title;
      head.replaceChildren(button);
      button.addEventListener("click", () => {
        const up = head.getAttribute("aria-sort") !== "ascending";
        table.querySelectorAll("thead th").forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        const rows = [...body.rows];
        const keys = new Map(rows.map((row) => [row, row.cells[index].dataset.key]));
        const missing = (key) => key === "nan" || key === "";
        rows.sort((a, b) => {
          const [x, y] = [keys.get(a), keys.get(b)];
          if (missing(x) !== missing(y)) return missing(x) ? 1 : -1; // unknown values stay last
          return up ? compare(x, y) : compare(y, x);
        });
        body.append(...rows);
      });
    });
  };

  const filterable = (table) => {
    const tools = table.closest(".scroll")?.previousElementSibling;
    if (!tools?.matches(".table-tools")) return;
    const input = tools.querySelector("input"), count = tools.querySelector(".count");
    const rows = [...table.tBodies[0].rows];
    if (rows.length < 4) return;
    tools.hidden = false;
    const text = new Map(rows.map((row) => [row, row.textContent.toLowerCase()]));
    input.addEventListener("input", () => {
      const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      for (const row of rows) {
        row.hidden = !wanted.every((word) => text.get(row).includes(word));
        shown += row.hidden ? 0 : 1;
      }
      count.textContent = wanted.length ? `${shown} of ${rows.length} rows` : "";
    });
  };
  document.querySelectorAll("table.data").forEach((table) => { sortable(table); filterable(table); });
})();
