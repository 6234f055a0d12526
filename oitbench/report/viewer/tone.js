// From codes to colors, by tables: a code is an 8-bit display level or the bits of a half float.

const STOPS_OF_FALSE_COLOR = 8;
const SHADOW_GAMMA = 4;
const tables = new Map();

/** Return the table of a name, which is made once. */
function table(name, make) {
  if (!tables.has(name)) {
    if (tables.size > 40) tables.clear();
    tables.set(name, make());
  }
  return tables.get(name);
}

/** Return the value of a half float; NaN for what is not finite. */
function half(code) {
  const exponent = (code >> 10) & 31;
  const fraction = code & 1023;
  if (exponent === 31) return NaN;
  const size = exponent ? (1 + fraction / 1024) * 2 ** (exponent - 15) : fraction * 2 ** -24;
  return code & 0x8000 ? -size : size;
}

function toLinear(display) {
  return display <= 0.04045 ? display / 12.92 : ((display + 0.055) / 1.055) ** 2.4;
}

function toDisplay(linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
}

/** Return the stored linear value of each code: radiance, or that of a display level. */
function stored(bits) {
  return table(`stored ${bits}`, () =>
    bits === 16
      ? Float32Array.from({ length: 65536 }, (_, code) => half(code))
      : Float32Array.from({ length: 256 }, (_, code) => toLinear(code / 255)));
}

/** Return the linear value of each code on the display, where 1 is white; `stops` is the exposure. */
function linearTable(bits, stops) {
  return table(`linear ${bits} ${stops}`, () => stored(bits).map((value) => value * 2 ** stops));
}

/** Return the level in [0, 255] of each code; NaN stays. `tone` is "srgb" or "gamma". */
function levelTable(bits, stops, tone) {
  return table(`level ${bits} ${stops} ${tone}`, () =>
    linearTable(bits, stops).map((value) => {
      const clipped = Math.max(0, Math.min(1, value));
      return 255 * (tone === "gamma" ? clipped ** (1 / SHADOW_GAMMA) : toDisplay(clipped));
    }));
}

/** Return the error of each code of an error map. */
function errorTable() {
  return table("error", () => Float32Array.from({ length: 256 }, (_, code) => (code / 255) ** 2));
}

/** Return the colors of a color map, 3 × 256 bytes, that Python wrote into the page. */
function colorMap(name) {
  return table(`colors ${name}`, () => {
    const text = JSON.parse(document.getElementById("color-maps").textContent)[name];
    return Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
  });
}

/** Return the place in a color map, 0 to 255, of a value in [0, 1]. */
function place(value) {
  return Math.round(255 * Math.max(0, Math.min(1, value)));
}

/** Return the place in a color map of a luminance: 8 stops from black to white. */
function falseColor(luminance) {
  return place(1 + Math.log2(Math.max(luminance, 1e-30)) / STOPS_OF_FALSE_COLOR);
}
