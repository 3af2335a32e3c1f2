// Tables and choices first: they decide what has to be drawn, and where.
equipTables();
equipChoices();
equipSliders();
equipJudging();
offerFigures();
equipViews();
state.show();
performance.mark("interactive");
// The plots' data and library follow this program in the file.
document.addEventListener("DOMContentLoaded", () => {
  equipReading();
  state.show();
  watchPlots();
});
