// Plots: drawn when they come into sight, in the colours of light or dark.
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const coarse = window.matchMedia("(pointer: coarse)").matches;
const PRINT_WIDTH = 330, PRINT_HEIGHT = 320, NARROW = 480;
const THEMES = {
  light: { ink: "#1a1a1a", muted: "#5f6368", grid: "#e3e5e8", paper: "#ffffff", peer: "#767676",
    "ink-band": "rgba(0,0,0,0.16)", "peer-band": "rgba(118,118,118,0.2)", "truth-band": "rgba(90,100,110,0.22)" },
  dark: { ink: "#e8e8e8", muted: "#a3a8ae", grid: "#33373d", paper: "#16181b", peer: "#9a9a9a",
    "ink-band": "rgba(255,255,255,0.2)", "peer-band": "rgba(154,154,154,0.25)", "truth-band": "rgba(190,200,210,0.2)" },
};
let theme = dark.matches ? THEMES.dark : THEMES.light;
const drawn = new Set();
const figures = new Map(); // parsed once
const shownLoad = new Map(); // scene -> place of its slider

const withTheme = (chosen, act) => {
  const before = theme;
  theme = chosen;
  try { return act(); } finally { theme = before; }
};

// Replace "@ink" and its like by the colours of the theme, and unpack maps, everywhere in a figure.
const unpacked = (value) => {
  if (typeof value === "string") return value[0] === "@" && theme[value.slice(1)] || value;
  if (Array.isArray(value)) return value.map(unpacked);
  if (!value || typeof value !== "object") return value;
  if (typeof value.codes === "string") return mapOf(value);
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, unpacked(item)]));
};

// A map travels as 16-bit codes, rows one after another; 0 is a gap. It is unpacked once.
const mapOf = (packed) => {
  if (packed.rows) return packed.rows;
  const { codes, shape, step, below = 0 } = packed;
  const bytes = Uint8Array.from(atob(codes), (character) => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  packed.rows = Array.from({ length: shape[0] }, (_, row) => Array.from({ length: shape[1] }, (__, column) => {
    const code = view.getUint16(2 * (row * shape[1] + column), true);
    return code ? code * step - below : null;
  }));
  return packed.rows;
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

const sceneOf = (node) => node.closest("section.scene")?.id ?? "";

// The figure of a canvas as plotly takes it, at the load that its scene's slider stands at.
const specOf = (canvas) => {
  const id = "data-" + canvas.dataset.figure;
  if (!figures.has(id)) figures.set(id, JSON.parse(document.getElementById(id).textContent));
  const figure = figures.get(id), frame = figure.frames?.[shownLoad.get(sceneOf(canvas)) ?? figure.frames.length - 1];
  const data = figure.data.map((trace, index) => ({ ...trace, ...frame?.data[index] }));
  judgeAnew(canvas, data);
  const spec = unpacked({ data, layout: { ...figure.layout, ...frame?.layout } });
  spec.layout.template = shared();
  spec.layout.autosize = true;
  if (coarse) spec.layout.dragmode = false;
  if (canvas.clientWidth && canvas.clientWidth < NARROW) spec.layout.template.layout.font.size = 11;
  return spec;
};
// No tool bar: buttons inside an image are none for a screen reader. Dragging zooms, a double click
// resets, and what is to be saved has buttons of its own.
const CONFIG = { displaylogo: false, responsive: true, displayModeBar: false, scrollZoom: false };

const draw = (canvas, purpose) => {
  const spec = specOf(canvas), size = canvas._fullLayout?._size;
  if (purpose === "step" && size && spec.layout.yaxis?.range) {
    // Another load on the same axes needs the same room: its search takes time.
    spec.layout.margin = { l: size.l, r: size.r, t: size.t, b: size.b, autoexpand: false };
    for (const axis of ["xaxis", "yaxis"]) spec.layout.template.layout[axis].automargin = false;
  }
  if (purpose === "print") {
    Object.assign(spec.layout, { autosize: false, width: PRINT_WIDTH, height: PRINT_HEIGHT });
    spec.layout.template.layout.font.size = 10;
    Object.assign(spec.layout.template.layout.legend, { font: { size: 8 }, entrywidth: 72 });
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

const canvases = [...document.querySelectorAll("[data-figure]:not([data-turn])")];

const watchPlots = () => {
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      watcher.unobserve(entry.target);
      enqueue(entry.target);
    }
  }, { rootMargin: "600px 0px" });
  // What is in sight from the start need not wait for the watcher.
  for (const canvas of canvases) {
    const place = canvas.getBoundingClientRect();
    // Inside of what is folded a canvas has a place, too, and nobody sees it.
    if ((canvas.checkVisibility?.() ?? true) && place.height && place.top < window.innerHeight + 600 && place.bottom > -600) enqueue(canvas);
    else watcher.observe(canvas);
  }
};

const redraw = () => {
  theme = dark.matches ? THEMES.dark : THEMES.light;
  drawn.forEach((canvas) => draw(canvas));
};
dark.addEventListener("change", redraw);

// A step of the slider keeps the room for names and numbers, which changes with a plot's width.
let resized = null;
window.addEventListener("resize", () => {
  clearTimeout(resized);
  resized = setTimeout(() => drawn.forEach((canvas) => {
    if (canvas.layout.margin?.autoexpand === false) draw(canvas);
  }), 200);
});

// Paper is always light and has a width of its own.
window.addEventListener("beforeprint", () => {
  if (!window.Plotly) return;
  theme = THEMES.light;
  canvases.filter((canvas) => canvas.offsetParent).forEach((canvas) => draw(canvas, "print"));
});
window.addEventListener("afterprint", redraw);
