// The page: reads the data, fills the sections, and connects the point that is chosen with all of them.

document.documentElement.classList.add("has-script");
const data = JSON.parse(document.getElementById("data").textContent);
const { points } = data;
points.forEach((point, index) => (point.index = index));
const shownPoints = points.filter((point) => point.exhibit);
const byId = (id) => document.getElementById(id);
let chosen = 0;

/** The pictures of the viewer: the reference, then those of the points. */
const sides = [
  { name: "Reference", pixels: decoded(data.reference), maps: {} },
  ...shownPoints.map(({ letter, name, exhibit }) => {
    const maps = { flip: bytesOf(exhibit.flip.bytes) };
    if (exhibit.flicker) maps.flicker = bytesOf(exhibit.flicker.bytes);
    for (const { lighting, fraction } of exhibit.shared ?? []) maps[lighting] = bytesOf(fraction.bytes);
    return { name: `${letter} ${name}`, pixels: decoded(exhibit.picture), maps };
  }),
];
const sideOf = (index) => shownPoints.indexOf(points[index]) + 1;
const viewer = shownPoints.length ? new Viewer(data, sides) : null;

/** A small picture with a title that opens its mode in the viewer. */
function thumb(container, side, mode, text) {
  const button = add(container, "button", { type: "button", "data-mode": mode });
  const canvas = rendered(sides[side], mode, { ...viewer.view, gain: 1, exposure: data.exposure });
  canvas.setAttribute("aria-hidden", "true");
  button.append(canvas);
  add(button, "b", {}, MODES[mode].name);
  add(button, "span", {}, text);
  button.addEventListener("click", () => {
    viewer.show({ mode });
    markMode();
    byId("viewer").scrollIntoView({ block: "nearest" });
  });
}

/** Shows a command, which may break between its words only. */
function showCommand(element, command) {
  element.replaceChildren();
  command.split(" ").forEach((word, i) => {
    if (i) element.append(" ");
    add(element, "span", { class: "word" }, word);
  });
}

/** Marks the small pictures that show the mode of the viewer. */
function markMode() {
  for (const button of document.querySelectorAll("[data-mode]")) {
    button.setAttribute("aria-pressed", button.dataset.mode === viewer.shown.mode);
  }
}

/** Text about the bias of a point. */
function biasText([value, halfWidth]) {
  if (halfWidth === null) return "bias not known";
  const text = `${(100 * value).toFixed(1)} % ± ${(100 * halfWidth).toFixed(1)} %`.replace("-", "−");
  return Math.abs(value) > halfWidth ? `bias ${text}` : `no bias found (${text})`;
}

/** Chooses a point: shows its numbers, settings, command and pictures. */
function choose(index) {
  chosen = index;
  const point = points[index];
  byId("chosen-title").textContent = `Chosen point: ${point.letter} ${point.name}`;
  const interval = point.interval ? `, 95 % interval ${point.interval.map(percent).join(" to ")}` : "";
  byId("chosen-numbers").textContent = `${point.time} per frame; error ${percent(point.error)}${interval} ` +
    `(${point.seeds} seeds); ${biasText(point.bias)}.`;
  showCommand(byId("chosen-command").firstChild, point.command);
  byId("chosen-settings").firstChild.textContent = point.settings || "# none: this is the default preset";
  for (const row of document.querySelectorAll("#points tr[data-point], #noise tr[data-point]")) {
    row.classList.toggle("is-chosen", +row.dataset.point === index);
  }
  for (const mark of document.querySelectorAll("#scatter .point")) {
    const isChosen = +mark.dataset.point === index;
    mark.setAttribute("aria-checked", isChosen);
    mark.setAttribute("tabindex", isChosen ? 0 : -1);
  }
  const [thumbs, maps] = [byId("thumbs"), byId("maps")];
  thumbs.replaceChildren();
  maps.replaceChildren();
  const side = sideOf(index);
  if (side === 0) {
    add(thumbs, "p", { class: "note" }, "No pictures of this point were recorded.");
  } else {
    const { exhibit } = point;
    thumb(thumbs, side, "picture", "one frame of it");
    thumb(thumbs, side, "signed", "blue: too dark, orange: too bright");
    thumb(thumbs, side, "relative", "black: none, pale: at least 100 %");
    thumb(thumbs, side, "flip", `mean ${short(exhibit.flip.value)}; black: none`);
    if (exhibit.flicker) thumb(maps, side, "flicker", `${percent(exhibit.flicker.value)}; black: none, pale: at least 100 %`);
    for (const { lighting, fraction } of exhibit.shared ?? []) {
      thumb(maps, side, lighting, `mean ${percent(fraction.value)}; black: none, pale: all`);
    }
    if (!maps.firstChild) add(maps, "p", { class: "note" }, "No such pictures of this point were recorded.");
    const isYardstick = index === data.yardstick || !points[data.yardstick]?.exhibit;
    viewer.show({ left: side, right: isYardstick ? 0 : sideOf(data.yardstick) });
    markMode();
  }
  drawTrends();
}

/** Draws the plots that mark the chosen point. */
function drawTrends() {
  const withErrors = shownPoints.filter((point) => point.exhibit.errors.length > 1);
  const frames = Math.max(0, ...withErrors.map((point) => point.exhibit.errors.length));
  if (frames > 1) {
    drawLines(byId("frames"), withErrors.map((point) => ({ point, values: point.exhibit.errors.map((e, i) => [i, e]) })), chosen, {
      title: "Error of each frame", x: [0, frames - 1], xTicks: Array.from({ length: frames }, (_, i) => i),
      xTick: short, yTick: percent, y: (low, high) => [low / 1.15, high * 1.15], yLabel: "error (log scale)", xLabel: "frame",
    });
  } else {
    byId("frames").textContent = "Not measured here: only one frame of each run has a reference.";
  }
  if (!shownPoints.length) return;
  const spectra = shownPoints.map((point) => {
    const { spectrum } = point.exhibit;
    return { point, values: spectrum.map((power, i) => [(0.5 * (i + 0.5)) / spectrum.length, power]) };
  });
  drawLines(byId("spectrum"), spectra, chosen, {
    title: "Power of the error by spatial frequency", x: [0, 0.5], xTicks: [0, 0.125, 0.25, 0.375, 0.5],
    xTick: String, yTick: short, yLabel: "power, 1 = white noise (log scale)", xLabel: "spatial frequency, cycles per pixel",
    y: (low, high) => [Math.max(0.02, Math.min(0.5, low / 1.15)), Math.max(2, high * 1.15)],
    below: (svg, x, y, frame) => {
      draw(svg, "rect", { class: "band", x: frame.left, y: frame.top, width: x.at(0.125) - frame.left, height: frame.bottom - frame.top });
      draw(svg, "line", { class: "yardstick", x1: frame.left, x2: frame.right, y1: y.at(1), y2: y.at(1) });
      draw(svg, "text", { class: "quiet", x: frame.left + 6, y: frame.bottom - 8 }, "blotches");
      draw(svg, "text", { class: "quiet", x: frame.right - 6, y: frame.bottom - 8, "text-anchor": "end" }, "fine grain");
    },
  });
}

/** Fills the table of flicker and correlation. */
function fillNoise() {
  const ofShared = (lighting) => ({ exhibit }) => {
    if (exhibit.shared === null) return [null, "not measured"];
    const own = exhibit.shared.find((shared) => shared.lighting === lighting);
    return own ? [own.fraction.value, percent(own.fraction.value)] : [0, "none: no reservoirs"];
  };
  const columns = [
    ["flicker", ({ exhibit }) => (exhibit.flicker ? [exhibit.flicker.value, percent(exhibit.flicker.value)] : [null, "not measured"])],
    ["flicker ÷ error", ({ exhibit }) => {
      const error = exhibit.errors.at(-1);
      const ratio = exhibit.flicker && error > 0 ? exhibit.flicker.value / error : null;
      return [ratio, ratio === null ? "not measured" : short(ratio)];
    }],
    ["power below 1/8 cycles per pixel, 1 = white noise", ({ exhibit }) => [exhibit.low, short(exhibit.low)]],
    ["shared samples, direct light", ofShared("direct")],
    ["shared samples, indirect light", ofShared("indirect")],
  ];
  const table = byId("noise");
  const head = add(add(table, "thead"), "tr");
  for (const name of ["point", "settings", ...columns.map(([name]) => name)]) add(head, "th", { scope: "col" }, name);
  const most = columns.map(([, value]) => Math.max(...shownPoints.map((point) => value(point)[0] ?? 0), 1e-9));
  // Both kinds of light have the same scale.
  most.fill(Math.max(...most.slice(-2)), -2);
  const body = add(table, "tbody");
  for (const point of shownPoints) {
    const row = add(body, "tr", { "data-point": point.index });
    add(add(row, "td"), "span", { class: "letter" }, point.letter);
    add(add(row, "th", { scope: "row" }), "button", { type: "button" }, point.name);
    columns.forEach(([, value], i) => {
      const [number, text] = value(point);
      const cell = add(row, "td", {}, text);
      const width = (72 * Math.max(0, number ?? 0)) / most[i];
      if (width > 0) add(cell, "span", { class: "bar", style: `width: ${width}px`, "aria-hidden": "true" });
    });
  }
}

/** Fills the table of all passes. */
function fillPasses() {
  const table = byId("passes-table");
  const head = add(add(table, "thead"), "tr");
  for (const name of ["pass", ...shownPoints.map((p) => p.letter)]) add(head, "th", { scope: "col" }, name);
  const names = [...new Set(shownPoints.flatMap(({ exhibit }) => exhibit.passes.map(([name]) => name)))];
  const body = add(table, "tbody");
  for (const name of names) {
    const row = add(body, "tr");
    add(row, "th", { scope: "row" }, name.replaceAll("_", " "));
    for (const { exhibit } of shownPoints) {
      const ms = exhibit.passes.filter(([own]) => own === name).reduce((sum, [, value]) => sum + value, 0);
      add(row, "td", {}, ms ? short(ms) : "–");
    }
  }
}

/** Draws all plots for the present width of the page. */
function drawAll() {
  if (points.length) drawScatter(byId("scatter"), data, chosen, choose);
  if (shownPoints.length) drawPasses(byId("passes"), byId("passes-legend"), shownPoints);
  drawTrends();
}

fillNoise();
fillPasses();
for (const row of document.querySelectorAll("tr[data-point]")) {
  row.querySelector(".letter").style = series(+row.dataset.point);
  row.addEventListener("click", () => choose(+row.dataset.point));
}
for (const button of document.querySelectorAll(".copy")) {
  button.addEventListener("click", () => {
    const source = byId(button.dataset.copies);
    const say = (text) => {
      button.textContent = text;
      setTimeout(() => (button.textContent = "Copy"), 1500);
    };
    const select = () => {
      getSelection().selectAllChildren(source);
      say("Selected");
    };
    // A page from a file may not be allowed to write to the clipboard.
    navigator.clipboard?.writeText(source.textContent).then(() => say("Copied"), select) ?? select();
  });
}
const prefersDark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (document.documentElement.dataset.theme ?? (prefersDark.matches ? "dark" : "light")) === "dark";
const nameTheme = () => (byId("theme").textContent = isDark() ? "Light colours" : "Dark colours");
byId("theme").addEventListener("click", () => {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  nameTheme();
});
prefersDark.addEventListener("change", nameTheme);
nameTheme();
if (viewer) viewer.mode.addEventListener("input", markMode);
if (data.decided) showCommand(byId("command").firstChild, points[0].command);
drawAll();
if (points.length) choose(0);
let width = innerWidth;
addEventListener("resize", () => {
  if (innerWidth !== width) {
    width = innerWidth;
    drawAll();
  }
});
