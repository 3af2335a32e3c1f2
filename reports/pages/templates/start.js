// Tables and choices first: they decide what has to be drawn, and where.
equipTables();
equipChoices();
equipSliders();
equipJudging();
if (canUnpack) {
  offerFigures();
  equipViews();
} else if (canvases.length) {
  const text = "The plots need a newer browser (Chrome 80, Firefox 113, Safari 16.4 or later); tables and verdicts work in this one.";
  document.getElementById("main").prepend(element("p", { class: "alert" }, text));
}
state.show();
performance.mark("interactive");
// The plots' data and library follow this program in the file.
document.addEventListener("DOMContentLoaded", async () => {
  equipReading();
  state.show();
  if (!canUnpack) return;
  const unpacked = unpackLibrary();
  holdLoad(unpacked);
  await unpacked;
  watchPlots();
});
