// Judging anew: another tolerance, fewer quantities. The rule is that of the verdicts (largest
// |e| + u against t), on the ends of what every error may be; null is an unknown end.
const judging = JSON.parse(document.getElementById("page-judging")?.textContent ?? "null");
for (const scene of judging?.scenes ?? []) [scene.verdicts] = Object.values(scene.judged);
const question = { tolerance: null, counted: null }; // null: as asked
const LEAST = 1e-3; // of error over tolerance: the foot of the plot of all scenes
const WORST_FIRST = ["outside", "no result", "not resolved", "within"];

const wordFor = (verdict, tolerance) => {
  if (verdict.missing) return "no result";
  if (verdict.wrong) return "outside";
  if (verdict.high !== null && verdict.high <= tolerance) return "within";
  return verdict.low !== null && verdict.low > tolerance ? "outside" : "not resolved";
};
const isAsked = (verdict) => verdict.counts && (!question.counted || question.counted.has(verdict.quantity));
const holds = (setting, tolerance) => {
  const counted = setting.verdicts.filter(isAsked);
  return counted.length > 0 && counted.every((verdict) => wordFor(verdict, tolerance) === "within");
};
const severityOf = (verdict, tolerance) => {
  const word = wordFor(verdict, tolerance);
  const size = (word === "outside" ? verdict.low : verdict.high) ?? Infinity;
  return [WORST_FIRST.indexOf(word), -size, -(verdict.error ?? 0)];
};
const before = (a, b) => {
  const place = a.findIndex((value, index) => value !== b[index]);
  return place >= 0 && a[place] < b[place];
};
const worstOf = (verdicts, tolerance) => verdicts.filter(isAsked).reduce(
  (worst, verdict) => !worst || before(severityOf(verdict, tolerance), severityOf(worst, tolerance)) ? verdict : worst, null);

// The fastest setting of a method that holds, as do all finer ones of it; else its truth.
const sureOf = (settings, tolerance) => {
  const sure = [];
  for (const setting of settings.filter((one) => one.judged).sort((a, b) => b.n - a.n)) {
    if (holds(setting, tolerance)) sure.push(setting);
    else if (setting.finest || worstWord(setting, tolerance) !== "no result") break;
  }
  return sure.length ? sure : settings.filter((one) => one.truth && holds(one, tolerance));
};
const worstWord = (setting, tolerance) => {
  const worst = worstOf(setting.verdicts, tolerance);
  return worst ? wordFor(worst, tolerance) : "no result";
};
const time = (setting) => setting.seconds ?? Infinity;
const reaching = (scene, tolerance) => [...new Set(scene.settings.map((one) => one.method))]
  .map((method) => sureOf(scene.settings.filter((one) => one.method === method), tolerance))
  .filter((sure) => sure.length && sure[0].ranked)
  .map((sure) => sure.reduce((best, one) => time(one) < time(best) ? one : best))
  .sort((a, b) => time(a) - time(b));

const TONES = { yes: "within", no: "outside", "not known": "not-resolved", "in part": "partly" };
const toneOf = (word) => word.endsWith(" only") ? "partly" : TONES[word] ?? word.replace(" ", "-");
const asBadge = (node, word) => {
  node.className = `verdict ${toneOf(word)}`;
  node.textContent = word;
};
// Where a method may be used: the rows of comparisons.results.finding, from what the cells show.
const MOST_ROWS = 8, NAMED = 3, KINDS = ["yes", "no", "not known"];
const oneDigit = (ratio) => { // as formatting.number writes it
  const [digit, power] = ratio.toExponential(0).split("e").map(Number);
  if (power <= -4 || power >= 6) return `${digit}×10${String(power).replace(/./g, (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)])}`;
  return (digit * 10 ** power).toFixed(Math.max(-power, 0)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
};
const ends = (items) => [...new Set([items[0], items[items.length - 1]])].join(" to ");
const timesOf = (settings) => {
  if (!settings.length) return "–";
  const levels = new Set(settings.filter((one) => one.ranked).map((one) => one.n));
  return ends([...settings].sort((a, b) => time(a) - time(b)).map((one) => one.time)) + (levels.size === 1 ? ` (N = ${[...levels][0]})` : "");
};
const standingOf = (scene, method) => {
  const tolerance = sceneTolerance(scene), known = scene.judged[method].filter(isAsked);
  const held = known.filter((one) => wordFor(one, tolerance) === "within").sort((a, b) => scene.order.indexOf(a.quantity) - scene.order.indexOf(b.quantity));
  const within = held.map((one) => one.symbol), quantities = new Set(held.map((one) => one.quantity));
  const whole = within.length === known.length && !scene.unjudged.some((name) => !question.counted || question.counted.has(name));
  const wrong = known.some((one) => wordFor(one, tolerance) === "outside");
  const use = !within.length || scene.lucky.includes(method) ? (wrong ? "no" : "not known") : whole ? "yes" : `for ${within.join(", ")} only`;
  const reached = reaching(scene, tolerance);
  // The fastest that is within in all that it may be used for.
  const inPart = use.endsWith(" only") ? scene.settings.filter((one) => one.method === method
    && one.verdicts.every((item) => !quantities.has(item.quantity) || wordFor(item, tolerance) === "within")) : [];
  const partly = inPart.reduce((best, one) => !best || time(one) < time(best) ? one : best, undefined);
  return {
    scene, use, kind: KINDS.includes(use) ? use : "in part", worst: worstOf(known, tolerance), tolerance,
    own: use.endsWith(" only") ? partly : reached.find((one) => one.method === method) ?? (use === "yes" ? scene.settings.find((one) => one.method === method && one.finest && !one.truth) : undefined), other: reached.find((one) => one.method !== method),
    solver: reached.find((one) => one.method !== method && one.solver),
    exact: scene.settings.find((one) => one.truth && !one.ranked),
  };
};
const groupsOf = (standings) => {
  const joined = [
    (one) => [one.scene.family, one.use],
    (one) => [one.use === "yes" ? "" : one.scene.family, one.use],
    (one) => [one.kind === "in part" ? one.scene.family : "", one.use],
    (one) => ["", one.kind],
  ];
  let groups;
  for (const key of joined) {
    groups = new Map();
    for (const one of standings) groups.set(String(key(one)), [...(groups.get(String(key(one))) ?? []), one]);
    if (groups.size <= MOST_ROWS) break;
  }
  return [...groups.values()];
};
const findingOf = (method) => {
  const standings = judging.scenes.filter((scene) => scene.judged[method]).map((scene) => standingOf(scene, method));
  return groupsOf(standings).map((group) => {
    const families = [...new Set(group.map((one) => one.scene.family))], uses = new Set(group.map((one) => one.use));
    const all = standings.filter((one) => one.scene.family === families[0]).length;
    const scenes = group.length === 1 ? `${families[0]}: ${group[0].scene.name}`
      : families.length === 1 ? `${families[0]} (${group.length}${group.length === all ? "" : ` of ${all}`} scenes)`
      : `${families.slice(0, NAMED).join(", ")}${families.length > NAMED ? ` and ${families.length - NAMED} more` : ""} (${group.length} scenes)`;
    const worst = group.filter((one) => one.worst).reduce((most, one) =>
      !most || before(severityOf(one.worst, one.tolerance), severityOf(most.worst, most.tolerance)) ? one : most, null);
    const error = worst ? worst.worst.largest + (group.length > 1 ? `, ${worst.scene.name}` : "") : "–";
    const pairs = group.filter((one) => one.own?.seconds > 0 && one.solver?.seconds != null);
    const ratios = pairs.map((one) => one.solver.seconds / one.own.seconds).sort((a, b) => a - b);
    const own = timesOf(group.map((one) => one.own).filter(Boolean));
    const cost = ratios.length && ratios[ratios.length - 1] < 1
      ? `no need: the 3-D solver is cheaper (${timesOf(pairs.map((one) => one.solver))} against ${own})` : own + (ratios.length ? `, 3-D takes ≈ ${ends(ratios.map(oneDigit))}\u00a0×` : "");
    const chosen = group.map((one) => one.exact ?? one.other).filter(Boolean);
    const titles = new Set(chosen.map((one) => one.truth && !one.ranked ? judging.exact : one.title));
    const left = group.length - chosen.length;
    const instead = !chosen.length ? "none that was run is within" : `${[...titles].join(" or ")} ${timesOf(chosen)}`
      + (left ? `; none is within in ${left} scene${left > 1 ? "s" : ""}` : "");
    const said = uses.size > 1 ? "in part" : [...uses][0];
    const use = !["no", "not known"].includes(said) && group.every((one) => one.scene.steep) ? "for small slopes only" : said;
    return [scenes, use, error, cost, instead];
  });
};
const judgeFinding = (table) => {
  const heads = [...table.tHead.rows[0].cells].map((head) => head.textContent);
  table.tBodies[0].replaceChildren(...findingOf(table.dataset.method).map(([scenes, use, ...rest]) => {
    const badge = element("span");
    asBadge(badge, use);
    return element("tr", {}, element("th", { scope: "row" }, scenes), element("td", { "data-label": "use it?" }, badge),
      ...rest.map((text, place) => element("td", { "data-label": heads[place + 2], class: text === "–" ? "none" : "" }, text)));
  }));
};

const sceneTolerance = (scene) => question.tolerance ?? scene.tolerance;
const labelOf = (tolerance) => judging.labels[judging.tolerances.indexOf(tolerance)];

const judgeCells = (scene) => {
  const rows = document.querySelectorAll(`#verdict-table tr[data-scene="${scene.anchor}"]`);
  const tolerance = sceneTolerance(scene);
  const shift = 100 * Math.log10(scene.tolerance / tolerance) / 6;
  [...Object.values(scene.judged), ...scene.others].forEach((verdicts, place) => verdicts.forEach((verdict) => {
    const cell = rows[place]?.querySelector(`td[data-quantity="${verdict.quantity}"]`);
    if (!cell) return;
    const word = wordFor(verdict, tolerance);
    cell.className = `cell ${toneOf(word)}`;
    cell.querySelector(".word").textContent = word;
    if (cell.dataset.beyond === undefined) return;
    cell.dataset.first ??= cell.getAttribute("style");
    for (const [, name, value] of cell.dataset.first.matchAll(/--(\w):(-?[\d.]+)/g)) {
      const moved = Number(value) <= 0 ? 0 : Math.min(Math.max(Number(value) + shift, 0), 100);
      cell.style.setProperty(`--${name}`, moved);
      if (name === "e") cell.dataset.beyond = moved <= 0 ? "under" : moved >= 100 ? "over" : "";
    }
  }));
};

const judgeBadges = (scene, badges) => { // one for each judged method, in a heading with what tells it
  const tolerance = sceneTolerance(scene);
  Object.values(scene.judged).filter((verdicts) => verdicts.length).forEach((verdicts, place) => {
    const worst = worstOf(verdicts, tolerance);
    if (!badges[place]) return;
    asBadge(badges[place], worst ? wordFor(worst, tolerance) : "no result");
    const told = badges[place].nextElementSibling?.querySelector(".told");
    if (told && worst) told.textContent = worst.text;
  });
};

const judgeRow = (scene, counts) => {
  const tolerance = sceneTolerance(scene), worst = worstOf(scene.verdicts, tolerance);
  const word = worst ? wordFor(worst, tolerance) : "no result";
  counts.set(word, (counts.get(word) ?? 0) + 1);
  const row = document.querySelector(`#summary-table tr[data-scene="${scene.anchor}"]`);
  if (!row) return; // of one scene the page has no summary
  judgeBadges(scene, row.querySelectorAll(".verdict"));
  if (question.tolerance !== null) row.querySelector(".asked-for").textContent = labelOf(tolerance);
  row.querySelector("td[data-label='largest error']").textContent = worst ? worst.text : "–";
  const reached = reaching(scene, tolerance), cell = row.querySelector("td[data-label=cheapest]");
  cell.dataset.key = reached[0]?.seconds ?? "nan";
  cell.querySelector(".settings").replaceChildren(...(reached.length ? reached.slice(0, 2).map((setting, place, { length }) => {
    const swatch = element("span", { class: "swatch" });
    swatch.style.setProperty("--c", setting.colour[0] === "@" ? `var(--${setting.colour.slice(1)})` : setting.colour);
    return element("span", { class: place ? "muted" : "first" }, swatch, setting.text, place + 1 < length ? ", " : "");
  }) : [element("span", { class: "muted" }, "no setting within tolerance")]));
};

// The plot of all scenes: heights follow the question.
const judgeAnew = (canvas, data) => {
  if (canvas.dataset.figure !== "overview" || (!question.tolerance && !question.counted)) return;
  data.forEach((trace, index) => {
    // Each method has two traces: points, and arrows at the foot.
    trace.y = judging.places[index >> 1].map(([scene, setting]) => {
      const record = judging.scenes[scene];
      const known = record.settings[setting].verdicts.filter((one) => isAsked(one) && !one.missing);
      if (!known.length || known.some((one) => one.high === null)) return null;
      const ratio = Math.max(...known.map((one) => one.high)) / sceneTolerance(record);
      if (index % 2) return ratio <= LEAST ? LEAST : null;
      return ratio > LEAST ? Math.min(ratio, 1 / LEAST) : null;
    });
  });
};

const judgeAll = () => {
  const counts = new Map();
  for (const scene of judging.scenes) {
    judgeCells(scene);
    judgeBadges(scene, document.querySelectorAll(`#${scene.anchor} summary > .verdict`));
    judgeRow(scene, counts);
  }
  for (const table of document.querySelectorAll("table.finding")) judgeFinding(table);
  document.querySelector(".tally")?.replaceChildren(...WORST_FIRST.filter((word) => counts.get(word)).flatMap((word) => {
    const badge = element("span");
    asBadge(badge, `${counts.get(word)} ${word}`);
    badge.className = `verdict ${toneOf(word)}`;
    return [badge, " "];
  }));
  for (const cell of document.querySelectorAll("#verdict-table [data-quantity]"))
    cell.classList.toggle("left-out", Boolean(question.counted) && !question.counted.has(cell.dataset.quantity));
  const canvas = document.querySelector("[data-figure=overview]");
  if (canvas && drawn.has(canvas)) draw(canvas);
};

// A click on a point opens its scene.
const followPoints = () => {
  const canvas = document.querySelector("[data-figure=overview]");
  canvas?.addEventListener("pointerdown", () => {
    if (canvas.dataset.followed || !canvas.on) return;
    canvas.dataset.followed = "yes";
    canvas.on("plotly_click", ({ points: [point] }) => {
      const place = judging.places[point.curveNumber >> 1]?.[point.pointNumber];
      if (place) location.hash = judging.scenes[place[0]].anchor;
    });
  }, { capture: true });
};

const equipJudging = () => {
  const form = document.querySelector("form.judge");
  if (!form || !judging) return;
  form.hidden = false;
  form.addEventListener("submit", (event) => event.preventDefault());
  const slider = form.querySelector("[name=tolerance]"), boxes = [...form.querySelectorAll("[name=counts]")];
  const back = form.querySelector(".as-asked"), solvers = document.querySelector("[name=solvers]");
  if (solvers) solvers.parentElement.hidden = false;
  slider.max = judging.tolerances.length - 1;
  const first = judging.tolerances.indexOf(judging.scenes[0]?.tolerance);
  const apply = () => {
    const asked = judging.tolerances.indexOf(Number(state.get("tolerance") ?? NaN));
    const names = boxes.map((box) => box.value), wanted = (state.get("counts") ?? "").split(",").filter((name) => names.includes(name));
    question.tolerance = asked < 0 ? null : judging.tolerances[asked];
    question.counted = wanted.length ? new Set(wanted) : null;
    if (solvers) solvers.checked = state.get("solvers") === "shown";
    for (const part of document.querySelectorAll("#verdict-table .solver")) part.hidden = !solvers.checked;
    slider.value = asked < 0 ? (first < 0 ? 6 : first) : asked;
    const output = form.querySelector("output");
    const label = asked < 0 ? output.dataset.asked : judging.labels[asked];
    output.textContent = label;
    for (const text of document.querySelectorAll("#verdict-table [data-asked]")) text.textContent = asked < 0 ? text.dataset.asked : label;
    slider.setAttribute("aria-valuetext", label);
    back.hidden = asked < 0 && !question.counted;
    for (const box of boxes) box.checked = !question.counted || question.counted.has(box.value);
    if (!back.hidden || form.dataset.judged) judgeAll();
    if (back.hidden && form.dataset.judged)
      for (const text of document.querySelectorAll("#summary-table .asked-for")) text.textContent = text.dataset.asked;
    if (!back.hidden) form.dataset.judged = "yes";
  };
  slider.addEventListener("input", () => { state.set("tolerance", judging.tolerances[slider.value], slider); apply(); });
  for (const box of boxes) box.addEventListener("change", () => {
    const chosen = boxes.filter((one) => one.checked).map((one) => one.value);
    state.set("counts", chosen.length && chosen.length < boxes.length ? chosen.join(",") : null, box);
    apply();
  });
  solvers?.addEventListener("change", () => { state.set("solvers", solvers.checked ? "shown" : null, solvers); apply(); });
  back.addEventListener("click", () => {
    state.set("tolerance", null, back);
    state.set("counts", null, back);
    apply();
  });
  state.follow(apply);
  followPoints();
};
