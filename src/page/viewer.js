// Pictures in canvases: two sides under one divider, with the same view, exposure and zoom. All values are linear radiance, in
// units of the radiance that is white at the exposure of the page.

/** The bytes of a base64 text. */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

/** Decodes RGB9E5 pixels to three floats each. */
function decoded(text) {
  const bytes = bytesOf(text);
  const words = new DataView(bytes.buffer);
  const values = new Float32Array((bytes.length / 4) * 3);
  for (let i = 0; i < bytes.length / 4; i++) {
    const word = words.getUint32(4 * i, true);
    const step = 2 ** ((word >>> 27) - 24);
    values[3 * i] = (word & 511) * step;
    values[3 * i + 1] = ((word >>> 9) & 511) * step;
    values[3 * i + 2] = ((word >>> 18) & 511) * step;
  }
  return values;
}

const luminance = (v, i) => 0.2126 * v[3 * i] + 0.7152 * v[3 * i + 1] + 0.0722 * v[3 * i + 2];
const srgb = (v) => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

/** Colours between the given ones, as a table of 256 entries. */
function colourMap(stops) {
  const table = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (stops.length - 1);
    const k = Math.min(stops.length - 2, Math.floor(at));
    for (let c = 0; c < 3; c++) table[3 * i + c] = Math.round(stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]));
  }
  return table;
}

// Viridis and magma grow in lightness; blue to orange differs for every kind of colour-blindness.
const VIRIDIS = colourMap([[68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128], [94, 201, 98], [173, 220, 48], [253, 231, 37]]);
const MAGMA = colourMap([[0, 0, 4], [29, 17, 71], [81, 18, 124], [130, 37, 129], [183, 55, 121], [230, 81, 100], [252, 137, 97], [254, 196, 136], [252, 253, 191]]);
const SIGNED = colourMap([[5, 48, 97], [33, 102, 172], [103, 169, 207], [209, 229, 240], [250, 250, 250], [253, 219, 169], [241, 163, 64], [179, 88, 6], [100, 45, 2]]);

/** The ways to show a picture. `value` returns a number in [0, 1] for the colour map, or null where there is none. */
const MODES = {
  picture: { name: "Picture", about: "Radiance × 2^exposure, clamped to [0, 1], as sRGB." },
  luminance: {
    name: "Luminance, false colour", map: VIRIDIS, about: "Luminance in W/(m²·sr), on a logarithmic scale; the exposure moves its ends.",
    value: (side, i, view) => (Math.log2(luminance(side.pixels, i) * view.gain) + 8) / 10,
    ticks: (view) => [-8, -5.5, -3, -0.5, 2].map((stop) => short(2 ** (stop - view.exposure))),
  },
  signed: {
    name: "Signed difference", map: SIGNED, about: "Luminance minus that of the reference, in W/(m²·sr): blue is too dark, orange too bright. The exposure sets the range.",
    value: (side, i, view) => 0.5 + 0.5 * view.gain * (luminance(side.pixels, i) - luminance(view.reference, i)),
    ticks: (view) => [-1, -0.5, 0, 0.5, 1].map((part) => (part > 0 ? "+" : "") + short(part * 2 ** -view.exposure).replace("-", "−")),
  },
  relative: {
    name: "Relative difference", map: MAGMA, about: "|a − b| / √(b² + 0.01) of the luminances of the picture, a, and of the reference, b.",
    value: (side, i, view) => {
      const b = luminance(view.reference, i);
      return Math.abs(luminance(side.pixels, i) - b) / Math.sqrt(b * b + 0.01 * view.scale * view.scale);
    },
    ticks: () => ["0 %", "25 %", "50 %", "75 %", "≥ 100 %"],
  },
  flip: mapMode("FLIP", "The difference from the reference that a viewer sees: 0 is none, 1 the largest.", ["0", "0.25", "0.5", "0.75", "1"]),
  flicker: mapMode("Flicker", "Difference of successive frames, relative to the reference.", ["0 %", "25 %", "50 %", "75 %", "≥ 100 %"]),
  direct: mapMode("Shared samples, direct light", "Part of the 24 pixels around a pixel that have its sample.", ["0 %", "25 %", "50 %", "75 %", "100 %"]),
  indirect: mapMode("Shared samples, indirect light", "Part of the 24 pixels around a pixel that have its sample.", ["0 %", "25 %", "50 %", "75 %", "100 %"]),
};

/** A mode whose values are bytes of the page. */
function mapMode(name, about, ticks) {
  return { name, about, map: MAGMA, isStored: true, ticks: () => ticks };
}

/** Shows `side` in the mode `key` at the size of the pictures, as a canvas. */
function rendered(side, key, view) {
  const [width, height] = view.size;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  const mode = MODES[key];
  const stored = mode.isStored ? side.maps[key] : null;
  for (let i = 0; i < width * height; i++) {
    if (key === "picture") {
      for (let c = 0; c < 3; c++) image.data[4 * i + c] = srgb(Math.min(1, side.pixels[3 * i + c] * view.gain));
    } else if (mode.isStored && !stored) {
      const stripe = ((i % width) + Math.floor(i / width)) % 8 < 4 ? 110 : 140;
      image.data.set([stripe, stripe, stripe], 4 * i);
    } else {
      const value = stored ? stored[i] / 255 : mode.value(side, i, view);
      const entry = 3 * Math.round(255 * Math.min(1, Math.max(0, value)));
      image.data.set(mode.map.subarray(entry, entry + 3), 4 * i);
    }
    image.data[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

/** Draws the colours of a mode with their values into `container`. */
function drawScale(container, key, view) {
  container.replaceChildren();
  const mode = MODES[key];
  if (mode.map) {
    const canvas = add(container, "canvas", { width: 256, height: 1, role: "img", "aria-label": `Colours of: ${mode.name}` });
    const context = canvas.getContext("2d");
    const image = context.createImageData(256, 1);
    for (let i = 0; i < 256; i++) image.data.set([...mode.map.subarray(3 * i, 3 * i + 3), 255], 4 * i);
    context.putImageData(image, 0, 0);
    const ticks = add(container, "div", { class: "ticks" });
    for (const tick of mode.ticks(view)) add(ticks, "span", {}, tick);
  }
  add(container, "p", {}, mode.about);
}

/** The comparison of two sides. `sides` has all pictures; the first one is the reference. */
class Viewer {
  constructor(data, sides) {
    this.sides = sides;
    const exposure = data.exposure;
    this.view = { size: data.size, gain: 1, exposure, scale: 2 ** exposure, reference: sides[0].pixels };
    this.base = exposure;
    this.shown = { left: 0, right: 0, mode: "picture", split: 0.5, zoom: 1, x: 0.5, y: 0.5 };
    this.cache = new Map();
    this.canvas = document.getElementById("canvas");
    this.canvas.style.aspectRatio = `${data.size[0]} / ${data.size[1]}`;
    document.getElementById("chosen").style.setProperty("--aspect", data.size[0] / data.size[1]);
    for (const id of ["left", "right", "mode", "split", "exposure"]) {
      const input = document.getElementById(id);
      this[id] = input;
      input.addEventListener("input", () => this.read());
    }
    for (const select of [this.left, this.right]) sides.forEach((side, i) => add(select, "option", { value: i }, side.name));
    const has = (key) => !MODES[key].isStored || sides.some((side) => side.maps[key]);
    for (const key of Object.keys(MODES).filter(has)) add(this.mode, "option", { value: key }, MODES[key].name);
    document.getElementById("zoom-in").addEventListener("click", () => this.zoom(1.5));
    document.getElementById("zoom-out").addEventListener("click", () => this.zoom(1 / 1.5));
    document.getElementById("zoom-reset").addEventListener("click", () => this.zoom(0));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, this.place(event));
    }, { passive: false });
    this.canvas.addEventListener("pointerdown", (event) => this.drag(event));
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    new ResizeObserver(() => this.paint()).observe(this.canvas);
  }

  /** Shows the pictures with the given indices; a value that is left out stays. */
  show({ left, right, mode }) {
    if (left !== undefined) this.left.value = left;
    if (right !== undefined) this.right.value = right;
    if (mode !== undefined) this.mode.value = mode;
    this.read();
  }

  /** Takes over what the controls say, and draws. */
  read() {
    const { shown, view } = this;
    [shown.left, shown.right] = [+this.left.value, +this.right.value];
    shown.mode = this.mode.value;
    shown.split = +this.split.value / 1000;
    const offset = +this.exposure.value;
    if (view.exposure !== this.base + offset) this.cache.clear();
    view.exposure = this.base + offset;
    view.gain = 2 ** offset;
    const sign = view.exposure > 0 ? "+" : "";
    document.getElementById("exposure-value").textContent = `${sign}${view.exposure.toFixed(1).replace("-", "−")} EV`;
    const sides = document.getElementById("sides");
    sides.replaceChildren();
    add(sides, "span", {}, `← ${this.sides[shown.left].name}`);
    add(sides, "span", {}, `${this.sides[shown.right].name} →`);
    drawScale(document.getElementById("scale"), shown.mode, view);
    this.paint();
  }

  picture(index) {
    const key = `${index} ${this.shown.mode}`;
    if (!this.cache.has(key)) this.cache.set(key, rendered(this.sides[index], this.shown.mode, this.view));
    return this.cache.get(key);
  }

  paint() {
    const { canvas, shown } = this;
    const ratio = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext("2d");
    context.imageSmoothingEnabled = false;
    const half = 0.5 / shown.zoom;
    shown.x = Math.min(1 - half, Math.max(half, shown.x));
    shown.y = Math.min(1 - half, Math.max(half, shown.y));
    const [columns, rows] = this.view.size;
    const source = [(shown.x - half) * columns, (shown.y - half) * rows, columns / shown.zoom, rows / shown.zoom];
    const divider = Math.round(shown.split * width);
    for (const [side, from, to] of [["left", 0, divider], ["right", divider, width]]) {
      context.save();
      context.beginPath();
      context.rect(from, 0, to - from, height);
      context.clip();
      context.drawImage(this.picture(shown[side]), ...source, 0, 0, width, height);
      context.restore();
    }
    context.fillStyle = "#000";
    context.fillRect(divider - 2 * ratio, 0, 4 * ratio, height);
    context.fillStyle = "#fff";
    context.fillRect(divider - ratio, 0, 2 * ratio, height);
    document.getElementById("zoom-value").textContent = `${short(shown.zoom)} ×`;
  }

  /** The place of an event on the canvas, as fractions of its size. */
  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  /** Zooms both sides by `factor` around a place of the canvas, or shows the whole picture if it is 0. */
  zoom(factor, [x, y] = [0.5, 0.5]) {
    const { shown } = this;
    const before = shown.zoom;
    const most = Math.max(8, this.view.size[0] / 16);
    shown.zoom = factor === 0 ? 1 : Math.min(most, Math.max(1, before * factor));
    shown.x += (x - 0.5) * (1 / before - 1 / shown.zoom);
    shown.y += (y - 0.5) * (1 / before - 1 / shown.zoom);
    this.paint();
  }

  /** Adds a number to the value of a slider. */
  move(input, step) {
    input.value = +input.value + step;
    this.read();
  }

  key(event) {
    const step = 0.1 / this.shown.zoom;
    const modes = [...this.mode.options].map((option) => option.value);
    const actions = {
      "+": () => this.zoom(1.5), "=": () => this.zoom(1.5), "-": () => this.zoom(1 / 1.5), 0: () => this.zoom(0),
      ArrowLeft: () => (this.shown.x -= step), ArrowRight: () => (this.shown.x += step),
      ArrowUp: () => (this.shown.y -= step), ArrowDown: () => (this.shown.y += step),
      "[": () => this.move(this.exposure, -0.5), "]": () => this.move(this.exposure, 0.5),
      ",": () => this.move(this.split, -50), ".": () => this.move(this.split, 50),
      m: () => this.show({ mode: modes[(modes.indexOf(this.shown.mode) + 1) % modes.length] }),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    actions[event.key]();
    this.paint();
    event.preventDefault();
  }

  /** Drags the divider if the pointer is near it, and otherwise the pictures. */
  drag(event) {
    const start = this.place(event);
    const { x, y, zoom, split } = this.shown;
    const isDivider = Math.abs(start[0] - split) * this.canvas.clientWidth < 14;
    const move = (next) => {
      const [px, py] = this.place(next);
      if (isDivider) {
        this.split.value = 1000 * px;
        this.read();
      } else {
        [this.shown.x, this.shown.y] = [x - (px - start[0]) / zoom, y - (py - start[1]) / zoom];
        this.paint();
      }
    };
    const end = () => {
      this.canvas.removeEventListener("pointermove", move);
      this.canvas.removeEventListener("pointerup", end);
      this.canvas.removeEventListener("pointercancel", end);
    };
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.addEventListener("pointermove", move);
    this.canvas.addEventListener("pointerup", end);
    this.canvas.addEventListener("pointercancel", end);
  }

  /** Writes the values of the pixel under the pointer. */
  point(event) {
    const { shown, view } = this;
    const [px, py] = this.place(event);
    const at = (place, centre, length) => Math.min(length - 1, Math.max(0, Math.floor((centre + (place - 0.5) / shown.zoom) * length)));
    const [column, row] = [at(px, shown.x, view.size[0]), at(py, shown.y, view.size[1])];
    const i = row * view.size[0] + column;
    const rgb = (side) => [0, 1, 2].map((c) => short(this.sides[side].pixels[3 * i + c] / view.scale)).join(", ");
    document.getElementById("pixel").textContent =
      `Pixel (${column}, ${row}), radiance in red, green, blue: left ${rgb(shown.left)}; right ${rgb(shown.right)}`;
  }
}
