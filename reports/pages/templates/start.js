// Tables and choices first: they decide what has to be drawn, and where.
equipTables();
equipChoices();
equipSliders();
offerFigures();
equipViews();
state.show();
watchPlots();
