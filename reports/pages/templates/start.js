// Tables and choices first: they decide what has to be drawn, and where.
equipTables();
equipChoices();
equipSliders();
equipJudging();
state.show();
performance.mark("interactive");
// The plots' data and library follow this program in the file; a copy cut short lacks them.
document.addEventListener("DOMContentLoaded", async () => {
  if (!document.querySelector("[data-figure]")) return;
  const complete = holdLoad();
  try {
    equipReading();
    state.show();
    await unpackLibrary();
  } catch {
    const text = "The plots need a newer browser (Chrome 92, Firefox 113, Safari 16.4 or later) or a whole copy of this page; tables and verdicts work here.";
    document.getElementById("main").prepend(element("p", { class: "alert" }, text));
    return;
  } finally {
    complete();
  }
  offerFigures();
  equipViews();
  watchPlots();
});
