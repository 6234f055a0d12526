// From the pixels of a layer to a canvas of the same size, under the exposure and the map of a state.

const MAGNIFIED = 8;
const CACHED_PIXELS = 40e6;
const NOT_FINITE = [255, 0, 255];

class Painter {
  constructor(stack) {
    this.stack = stack;
    this.canvases = new Map();
    this.used = new Set();
  }

  /** Return a canvas, or a text that says why there is none. */
  paint(layer, state, map = state.map) {
    const { stack } = this;
    const key = map === "flip" ? layer.maps[state.against?.truth] : layer.key;
    const reason = this.absence(layer, state, map);
    if (reason) return reason;
    const picture = stack.picture(key);
    const other = map === "picture" || map === "flip" ? picture : stack.picture(state.against.key);
    if (!picture || !other) return "loading …";
    if (picture.width !== other.width || picture.height !== other.height) {
      return "no difference: the reference has another size";
    }
    const look = map === "picture" ? state.tone : state.against.key;
    const name = [key, map, look, state.stops, state.gain].join(" ");
    this.used.add(name);
    if (!this.canvases.has(name)) {
      const { width, height } = picture;
      const canvas = Object.assign(document.createElement("canvas"), { width, height });
      const pixels = new ImageData(width, height);
      this.fill(pixels.data, picture, other, state, map);
      canvas.getContext("2d").putImageData(pixels, 0, 0);
      this.canvases.set(name, canvas);
    }
    return this.canvases.get(name);
  }

  /** Return why a layer cannot be shown, or an empty text. */
  absence(layer, state, map) {
    if (map === "picture") return "";
    if (!state.against) return "no error map: there is no reference";
    if (this.stack.lossy) return "no error map: previews are not exact";
    if (map === "flip" && !layer.maps[state.against.truth]) {
      return layer.truth ? "no FLIP map of a reference" : `no FLIP map against ${state.against.label}`;
    }
    return "";
  }

  fill(target, picture, other, state, map) {
    const { codes, bits } = picture;
    const stops = this.stack.base * (bits === 16) + state.stops;
    if (map === "flip") fillErrors(target, codes, 2 ** state.gain);
    else if (map !== "picture") {
      const factor = MAGNIFIED * 2 ** state.gain;
      const levels = levelTable(bits, stops, "srgb");
      fillDifferences(target, codes, other.codes, levels, factor, map === "signed");
    } else if (state.tone === "false") fillFalseColors(target, codes, linearTable(bits, stops));
    else fillPicture(target, codes, levelTable(bits, stops, state.tone));
  }

  /** Forget canvases that were not asked for since the last call, oldest first, beyond a limit. */
  tidy() {
    let pixels = 0;
    for (const canvas of this.canvases.values()) pixels += canvas.width * canvas.height;
    for (const [name, canvas] of this.canvases) {
      if (pixels <= CACHED_PIXELS) break;
      if (this.used.has(name)) continue;
      this.canvases.delete(name);
      pixels -= canvas.width * canvas.height;
    }
    this.used.clear();
  }
}

function set(target, pixel, red, green, blue) {
  target[4 * pixel] = red;
  target[4 * pixel + 1] = green;
  target[4 * pixel + 2] = blue;
  target[4 * pixel + 3] = 255;
}

function fillPicture(target, codes, levels) {
  for (let pixel = 0, at = 0; at < codes.length; pixel++, at += 3) {
    const [red, green, blue] = [levels[codes[at]], levels[codes[at + 1]], levels[codes[at + 2]]];
    // A sum with NaN is NaN, and NaN differs from itself.
    if (Number.isNaN(red + green + blue)) set(target, pixel, ...NOT_FINITE);
    else set(target, pixel, red, green, blue);
  }
}

function fillFalseColors(target, codes, linear) {
  const colors = colorMap("viridis");
  for (let pixel = 0, at = 0; at < codes.length; pixel++, at += 3) {
    const [red, green, blue] = [linear[codes[at]], linear[codes[at + 1]], linear[codes[at + 2]]];
    const luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    const color = 3 * falseColor(luminance);
    if (Number.isNaN(luminance)) set(target, pixel, ...NOT_FINITE);
    else set(target, pixel, colors[color], colors[color + 1], colors[color + 2]);
  }
}

function fillErrors(target, codes, factor) {
  const colors = colorMap("magma");
  const places = errorTable().map((error) => 3 * place(factor * error));
  for (let pixel = 0; pixel < codes.length; pixel++) {
    const color = places[codes[pixel]];
    set(target, pixel, colors[color], colors[color + 1], colors[color + 2]);
  }
}

/** Signed differences of levels lie around gray; absolute ones begin at black. */
function fillDifferences(target, codes, others, levels, factor, signed) {
  const value = [0, 0, 0];
  for (let pixel = 0, at = 0; at < codes.length; pixel++, at += 3) {
    for (let channel = 0; channel < 3; channel++) {
      const difference = factor * (levels[codes[at + channel]] - levels[others[at + channel]]);
      value[channel] = signed ? 128 + difference : Math.abs(difference);
    }
    if (Number.isNaN(value[0] + value[1] + value[2])) set(target, pixel, ...NOT_FINITE);
    else set(target, pixel, value[0], value[1], value[2]);
  }
}
