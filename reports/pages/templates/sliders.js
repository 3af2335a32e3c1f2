// Load sliders: one per scene and group of plots, all of a scene moving together.
const equipSliders = () => {
  const bars = [...document.querySelectorAll(".load-slider")];
  const moved = canvases.filter((canvas) => canvas.closest("figure")?.hasAttribute("data-loads"));
  // One plot in a frame, those in sight first, and of several steps the last: dragging stays smooth.
  let late = new Set();
  const drawLate = () => {
    const [canvas] = late;
    late.delete(canvas);
    draw(canvas, "step");
    if (late.size) requestAnimationFrame(drawLate);
  };
  const inSight = (canvas) => {
    const place = canvas.getBoundingClientRect();
    return place.bottom > 0 && place.top < window.innerHeight;
  };
  const apply = () => {
    const changed = new Set();
    for (const bar of bars) {
      const input = bar.querySelector("input"), labels = JSON.parse(input.dataset.loads);
      const asked = Number.parseInt(state.get(`load.${bar.dataset.scene}`) ?? "", 10);
      const place = asked >= 0 && asked < labels.length ? asked : labels.length - 1;
      input.value = place;
      input.setAttribute("aria-valuetext", labels[place]);
      bar.querySelector("output").textContent = labels[place];
      if ((shownLoad.get(bar.dataset.scene) ?? labels.length - 1) !== place) changed.add(bar.dataset.scene);
      shownLoad.set(bar.dataset.scene, place);
      for (const spots of document.querySelectorAll(`#${bar.dataset.scene} [data-spots]`)) spots.hidden = Number(spots.dataset.spots) !== place;
    }
    const stale = moved.filter((canvas) => drawn.has(canvas) && changed.has(sceneOf(canvas)));
    const idle = !late.size;
    late = new Set([...stale.filter(inSight), ...stale, ...late]);
    if (idle && late.size) requestAnimationFrame(drawLate);
  };
  for (const bar of bars) {
    bar.hidden = false;
    const input = bar.querySelector("input");
    input.addEventListener("input", () => {
      const last = Number(input.max) === Number(input.value);
      state.set(`load.${bar.dataset.scene}`, last ? null : input.value, bar, true);
      apply();
    });
  }
  state.follow(apply);
};
