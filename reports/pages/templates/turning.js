// Three-dimensional views that turn. Browsers keep few of them at a time, so one is live; the
// others stay pictures until asked for.
const canTurn = (() => {
  let known;
  return () => {
    if (known === undefined) {
      const context = document.createElement("canvas").getContext("webgl");
      known = Boolean(context);
      context?.getExtension("WEBGL_lose_context")?.loseContext();
    }
    return known;
  };
})();
let turned = null;

const still = () => {
  if (!turned) return;
  const { canvas, picture, toggle } = turned;
  Plotly.purge(canvas);
  canvas.hidden = true;
  if (picture) picture.hidden = false;
  toggle.textContent = "Rotate";
  toggle.setAttribute("aria-pressed", "false");
  turned = null;
};

// The eye moves on a sphere: 10 degrees per key.
const turnByKey = (canvas, event) => {
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  const way = ways[event.key];
  const eye = canvas._fullLayout?.scene?._scene?.getCamera().eye;
  if (!way || !eye) return;
  event.preventDefault();
  const radius = Math.hypot(eye.x, eye.y, eye.z), step = Math.PI / 18;
  const around = Math.atan2(eye.y, eye.x) + way[0] * step;
  const up = Math.min(Math.max(Math.asin(eye.z / radius) + way[1] * step, -1.5), 1.5);
  Plotly.relayout(canvas, { "scene.camera.eye": {
    x: radius * Math.cos(up) * Math.cos(around), y: radius * Math.cos(up) * Math.sin(around), z: radius * Math.sin(up) } });
};

// Two triangles of every cell of a grid of points.
const trianglesOf = ([rows, columns]) => {
  const [i, j, k] = [[], [], []];
  for (let row = 0; row < rows - 1; row += 1) {
    for (let column = 0; column < columns - 1; column += 1) {
      const corner = row * columns + column;
      i.push(corner, corner + 1);
      j.push(corner + columns, corner + columns);
      k.push(corner + 1, corner + columns + 1);
    }
  }
  return { i, j, k };
};

const turn = (canvas, picture, toggle) => {
  const again = turned?.canvas === canvas;
  still();
  if (again) return;
  if (picture) picture.hidden = true;
  canvas.hidden = false;
  const spec = specOf(canvas);
  delete spec.layout.dragmode;
  spec.data = spec.data.map(({ grid, ...trace }) => grid ? { ...trace, ...trianglesOf(grid) } : trace);
  Plotly.newPlot(canvas, spec.data, spec.layout, CONFIG);
  toggle.textContent = "Still picture";
  toggle.setAttribute("aria-pressed", "true");
  turned = { canvas, picture, toggle };
  canvas.focus({ preventScroll: true });
};

const equipViews = () => {
  for (const canvas of document.querySelectorAll(".canvas[data-turn]")) {
    if (!canTurn()) continue;
    const picture = canvas.parentElement.querySelector("img");
    const toggle = button("Rotate", `Rotate: ${canvas.dataset.title}`, () => turn(canvas, picture, toggle));
    toggle.setAttribute("aria-pressed", "false");
    toggle.removeAttribute("aria-label");
    canvas.after(element("div", { class: "figure-tools" }, toggle));
    canvas.addEventListener("keydown", (event) => turnByKey(canvas, event));
  }
  dark.addEventListener("change", still);
  window.addEventListener("beforeprint", still);
};
