// Plots as SVG. Each is drawn for the width of its element, so that letters have the same size everywhere.

const SVG = "http://www.w3.org/2000/svg";

/** Adds an SVG element to `parent`, and returns it. */
function draw(parent, name, attributes = {}, text = null) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== null) element.textContent = text;
  parent.append(element);
  return element;
}

/** Adds an HTML element to `parent`, and returns it. */
function add(parent, name, attributes = {}, text = null) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== null) element.textContent = text;
  parent.append(element);
  return element;
}

/** A number with three significant digits, without an exponent. */
function short(value) {
  if (value === 0) return "0";
  const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.abs(value))));
  return value.toFixed(Math.min(digits, 8)).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
}

const percent = (value) => `${short(100 * value)} %`;
const series = (index) => `--series: var(--s${index % 8})`;
const DASHES = ["", "9 4", "3 3", "12 3 3 3", "6 2", "2 5", "14 5", "8 3 2 3 2 3"];

/** A logarithmic scale with ticks at 1, 2 and 5 times powers of ten, or fewer if those are too many. */
function logScale(low, high, start, end) {
  // Without a positive value, any range shows nothing.
  if (!(low > 0 && high > low && high < Infinity)) [low, high] = [0.1, 1];
  const [a, b] = [Math.log(low), Math.log(high)];
  // A value of 0, such as the lower end of a wide interval, is drawn at the edge.
  const at = (value) => start + ((Math.log(value > 0 ? value : low) - a) / (b - a)) * (end - start);
  const ticks = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) {
    for (const digit of [1, 2, 3, 5, 7]) {
      const tick = digit * 10 ** power;
      if (tick >= low * 0.999 && tick <= high * 1.001) ticks.push([tick, digit]);
    }
  }
  const most = Math.abs(end - start) / 46;
  for (const digits of [[1, 2, 3, 5, 7], [1, 2, 5], [1, 3], [1]]) {
    const kept = ticks.filter(([, digit]) => digits.includes(digit));
    if (kept.length <= most || digits.length === 1) return { at, ticks: kept.map(([tick]) => tick) };
  }
}

/** A linear scale with the given ticks. */
function linearScale(low, high, start, end, ticks) {
  return { at: (value) => start + ((value - low) / (high - low)) * (end - start), ticks };
}

/** The size of a plot in `container`, in pixels, and its inner rectangle. */
function frameOf(container, height) {
  const width = Math.max(260, container.clientWidth || 0);
  return { width, height, left: 60, right: width - 16, top: 26, bottom: height - 44 };
}

/** Begins a plot with axes in `container`, and returns its SVG element. */
function axes(container, frame, x, y, labels) {
  container.replaceChildren();
  const { width, height, left, right, top, bottom } = frame;
  const svg = draw(container, "svg", { viewBox: `0 0 ${width} ${height}`, role: labels.role ?? "img", "aria-label": labels.title });
  for (const tick of y.ticks) {
    draw(svg, "line", { class: "grid", x1: left, x2: right, y1: y.at(tick), y2: y.at(tick) });
    draw(svg, "text", { x: left - 6, y: y.at(tick) + 4, "text-anchor": "end" }, labels.yTick(tick));
  }
  for (const tick of x.ticks) {
    draw(svg, "line", { class: "grid", x1: x.at(tick), x2: x.at(tick), y1: top, y2: bottom });
    draw(svg, "text", { x: x.at(tick), y: bottom + 17, "text-anchor": "middle" }, labels.xTick(tick));
  }
  draw(svg, "path", { class: "axis", fill: "none", d: `M${left},${top}V${bottom}H${right}` });
  draw(svg, "text", { class: "quiet", x: left - 52, y: 14 }, labels.yLabel);
  draw(svg, "text", { class: "quiet", x: right, y: height - 6, "text-anchor": "end" }, labels.xLabel);
  return svg;
}

/** Moves `bubbles`, each with a wanted place and its anchor, apart from each other and from all anchors, inside of `frame`. */
function spread(bubbles, frame) {
  const push = (a, x, y, least) => {
    const [dx, dy] = [a.x - x || 0.1, a.y - y || 0.1];
    const gap = Math.hypot(dx, dy);
    if (gap >= least) return;
    a.x += (dx / gap) * (least - gap) * 0.5;
    a.y += (dy / gap) * (least - gap) * 0.5;
  };
  for (let round = 0; round < 200; round++) {
    for (const a of bubbles) {
      for (const b of bubbles) {
        if (a !== b) push(a, b.x, b.y, 26);
        push(a, b.anchor[0], b.anchor[1], 19);
      }
      a.x = Math.min(frame.right - 10, Math.max(frame.left + 12, a.x));
      a.y = Math.min(frame.bottom - 12, Math.max(frame.top + 4, a.y));
    }
  }
}

/** Draws error against time. `choose` is called with the index of a point that is clicked or reached by an arrow key. */
function drawScatter(container, data, chosen, choose) {
  const { points } = data;
  const frame = frameOf(container, container.clientWidth < 500 ? 340 : 420);
  const yardstick = points[data.yardstick];
  const times = points.map((p) => p.milliseconds);
  const ends = points.flatMap((p) => p.interval ?? [p.error]).filter((e) => e > 0);
  const x = logScale(Math.min(...times) / 1.25, Math.max(...times) * 1.25, frame.left, frame.right);
  const y = logScale(Math.min(...ends) / 1.15, Math.max(...ends) * 1.15, frame.bottom, frame.top);
  const svg = axes(container, frame, x, y, {
    title: "Error of a frame against its time", role: "group",
    xLabel: "time of a frame, ms (log scale)", yLabel: "error of a frame (log scale), lower is better", xTick: short, yTick: percent,
  });
  const clip = draw(draw(svg, "clipPath", { id: "inside" }), "rect", {
    x: frame.left, y: frame.top, width: frame.right - frame.left, height: frame.bottom - frame.top,
  });
  clip.parentNode.id = "inside";
  const inside = draw(svg, "g", { "clip-path": "url(#inside)" });
  if (yardstick) {
    const reach = [0.01, 100].map((f) => f * yardstick.milliseconds);
    const line = (error) => reach.map((ms) => `${x.at(ms)},${y.at(error * Math.sqrt(yardstick.milliseconds / ms))}`);
    const [low, high] = yardstick.interval ?? [yardstick.error, yardstick.error];
    draw(inside, "path", { class: "band", d: `M${[...line(high), ...line(low).reverse()].join("L")}Z` });
    draw(inside, "path", { class: "yardstick", d: `M${line(yardstick.error).join("L")}` });
  }
  const front = points.filter((p) => p.front).sort((a, b) => a.milliseconds - b.milliseconds);
  const steps = front.map((p, i) => `${i ? `H${x.at(p.milliseconds)}V` : `M${x.at(p.milliseconds)},`}${y.at(p.error)}`);
  draw(inside, "path", { class: "front", d: `${steps.join("")}H${frame.right}` });

  const bubbles = points.map((p) => {
    const anchor = [x.at(p.milliseconds), y.at(p.error)];
    return { anchor, x: anchor[0] + 14, y: anchor[1] - 14 };
  });
  spread(bubbles, frame);
  const group = draw(svg, "g", { role: "radiogroup", "aria-label": "Points, from fast to slow" });
  const order = points.map((_, index) => index).sort((a, b) => times[a] - times[b]);
  for (const index of order) {
    const [point, bubble] = [points[index], bubbles[index]];
    const [cx, cy] = bubble.anchor;
    const mark = draw(group, "g", {
      class: "point", role: "radio", style: series(index), "data-point": index, "aria-checked": index === chosen,
      tabindex: index === chosen ? 0 : -1,
      "aria-label": `${point.letter}: ${point.name}, ${short(point.milliseconds)} ms, error ${percent(point.error)}`,
    });
    draw(mark, "title", {}, `${point.name}: ${short(point.milliseconds)} ms, error ${percent(point.error)}`);
    draw(mark, "line", { class: "leader", x1: cx, y1: cy, x2: bubble.x, y2: bubble.y });
    if (point.interval) {
      const [low, high] = point.interval.map((end) => y.at(end));
      draw(mark, "path", { class: "interval", d: `M${cx},${low}V${high}M${cx - 5},${low}h10M${cx - 5},${high}h10` });
    }
    const isOpen = point.standing === "left-out" || point.standing === "empty" || point.standing === "biased";
    if (point.standing === "advised") draw(mark, "circle", { class: "ring", cx, cy, r: 9 });
    draw(mark, "circle", { class: isOpen ? "dot open" : "dot", cx, cy, r: 4 });
    draw(mark, "circle", { class: "bubble", cx: bubble.x, cy: bubble.y, r: 11 });
    draw(mark, "text", { class: "bubble-text", x: bubble.x, y: bubble.y + 4.5 }, point.letter);
    mark.addEventListener("click", () => choose(index));
    mark.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (step) {
        const next = order[(order.indexOf(index) + step + order.length) % order.length];
        choose(next);
        container.querySelector(`[data-point="${next}"]`).focus();
      } else if (event.key === "Enter" || event.key === " ") choose(index);
      else return;
      event.preventDefault();
    });
  }
}

/** Draws lines, each with the letter of its point at its right end. A line of one value goes over the whole width. */
function drawLines(container, lines, chosen, options) {
  const frame = frameOf(container, container.clientWidth < 500 ? 300 : 340);
  frame.right -= 34;
  const values = lines.flatMap((line) => line.values.map(([, value]) => value)).filter((v) => v > 0);
  // Lines of zeros alone have no scale of their own.
  if (!values.length) values.push(1);
  const [low, high] = options.y(Math.min(...values), Math.max(...values));
  const y = logScale(low, high, frame.bottom, frame.top);
  const ticks = options.xTicks.filter((_, i, all) => frame.right - frame.left > 400 || all.length < 9 || i % 2 === 0);
  const x = linearScale(options.x[0], options.x[1], frame.left, frame.right, ticks);
  const svg = axes(container, frame, x, y, options);
  options.below?.(svg, x, y, frame);
  const labels = lines.map((line) => {
    const last = line.values.at(-1);
    const place = [x.at(last[0]), y.at(Math.max(last[1], low))];
    return { line, place, y: place[1] };
  });
  labels.sort((a, b) => a.y - b.y);
  for (let round = 0; round < 200; round++) {
    labels.forEach((label, i) => {
      const next = labels[i + 1];
      const overlap = next ? label.y + 22 - next.y : 0;
      if (overlap > 0) [label.y, next.y] = [label.y - overlap / 2, next.y + overlap / 2];
      label.y = Math.min(frame.bottom - 8, Math.max(frame.top, label.y));
    });
  }
  for (const { line, place, y: labelY } of labels) {
    const { index, letter, name } = line.point;
    const group = draw(svg, "g", { style: series(index), class: index === chosen ? "is-chosen" : "" });
    draw(group, "title", {}, name);
    const path = line.values.map(([vx, vy]) => `${x.at(vx)},${y.at(Math.max(vy, low))}`).join("L");
    draw(group, "path", { class: "series", d: `M${path}`, "stroke-dasharray": DASHES[index % DASHES.length] });
    const labelX = frame.right + 24;
    draw(group, "line", { class: "leader", x1: place[0], y1: place[1], x2: labelX, y2: labelY });
    draw(group, "circle", { class: "bubble", cx: labelX, cy: labelY, r: 11 });
    draw(group, "text", { class: "bubble-text", x: labelX, y: labelY + 4.5 }, letter);
  }
}

/** Draws one stacked bar per point, with a legend. Passes beyond the longest seven count as one. */
function drawPasses(container, legend, points) {
  const totals = new Map();
  for (const { exhibit } of points) {
    for (const [name, ms] of exhibit.passes) totals.set(name, (totals.get(name) ?? 0) + ms);
  }
  const names = [...totals.keys()].sort((a, b) => totals.get(b) - totals.get(a));
  const shown = names.length > 8 ? names.slice(0, 7) : names;
  const parts = shown.length < names.length ? [...shown, "all others"] : shown;
  legend.replaceChildren();
  parts.forEach((name, i) => {
    const item = add(legend, "li");
    add(item, "span", { class: "swatch", style: `background: var(--p${i})` });
    add(item, "span", {}, name.replaceAll("_", " "));
  });
  const rowHeight = 46;
  const frame = frameOf(container, 26 + points.length * rowHeight + 44);
  frame.left = 12;
  const sums = points.map(({ exhibit }) => exhibit.passes.reduce((sum, [, ms]) => sum + ms, 0));
  const most = Math.max(...sums);
  const step = niceStep(most / Math.max(3, Math.floor((frame.right - frame.left) / 60)));
  const ticks = Array.from({ length: Math.floor(most / step) + 1 }, (_, i) => i * step);
  const x = linearScale(0, most, frame.left, frame.right, ticks);
  const svg = axes(container, frame, x, { ticks: [] }, {
    title: "Time per pass", xLabel: "time of a frame, ms", yLabel: "", xTick: short,
  });
  points.forEach((point, row) => {
    const top = frame.top + row * rowHeight;
    draw(svg, "text", { x: frame.left + 4, y: top + 13 }, `${point.letter}  ${point.name}: ${short(sums[row])} ms`);
    let begin = 0;
    parts.forEach((name, i) => {
      const own = point.exhibit.passes.filter(([pass]) => pass === name || (!shown.includes(pass) && name === "all others"));
      const ms = own.reduce((sum, [, value]) => sum + value, 0);
      if (ms === 0) return;
      const segment = draw(svg, "rect", {
        class: "segment", x: x.at(begin), y: top + 18, width: x.at(begin + ms) - x.at(begin), height: 20, fill: `var(--p${i})`,
      });
      draw(segment, "title", {}, `${name.replaceAll("_", " ")}: ${short(ms)} ms (${percent(ms / sums[row])})`);
      begin += ms;
    });
  });
}

/** The smallest of 1, 2 and 5 times a power of ten that is at least `value`. */
function niceStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].find((digit) => digit * power >= value) * power;
}
