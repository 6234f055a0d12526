// Texts and scales that say what is shown.

const MAP_TITLES = {
  picture: "picture",
  flip: "FLIP map",
  signed: "signed difference",
  absolute: "absolute difference",
};
const TONE_TITLES = {
  srgb: "sRGB",
  gamma: `gamma ${SHADOW_GAMMA}, lifts shadows`,
  false: "false color of luminance",
};

/** Return a number with few digits, and a real minus sign. */
function short(value) {
  return Number(value.toPrecision(3)).toString().replace("-", "−");
}

/** Return stops with a sign. */
function signedStops(value) {
  const sign = value ? (value < 0 ? "−" : "+") : "";
  return `${sign}${Math.abs(value)} stop${Math.abs(value) === 1 ? "" : "s"}`;
}

/** Return a gradient of a color map for CSS. */
function gradient(name) {
  const colors = colorMap(name);
  const stops = Array.from({ length: 17 }, (_, step) => 3 * Math.min(255, 16 * step));
  return `linear-gradient(to right, ${stops.map((at) => `rgb(${colors.subarray(at, at + 3).join(",")})`)})`;
}

/** Return what the colors mean: a text, and a scale with its two ends, or null. */
function legendOf(stack, state) {
  const factor = 2 ** state.gain;
  const reference = state.against?.label;
  if (state.map === "flip") {
    const text = `${stack.metric} against ${reference}, lower is better`;
    return { text, scale: gradient("magma"), low: "0", high: short(1 / factor) };
  }
  if (state.map !== "picture") {
    const signed = state.map === "signed";
    const reach = (signed ? 128 : 255) / (MAGNIFIED * factor);
    const name = signed ? "picture − reference" : "|picture − reference|";
    return {
      text: `${name}, × ${short(MAGNIFIED * factor)}, in display levels (0 to 255), against ${reference}`,
      scale: `linear-gradient(to right, #000, ${signed ? "#808080, " : ""}#fff)`,
      low: signed ? `−${short(reach)}` : "0",
      high: `${signed ? "+" : ""}${short(reach)}`,
    };
  }
  if (state.tone === "false") {
    const text = "luminance on the display, log scale";
    return { text, scale: gradient("viridis"), low: `1/${2 ** STOPS_OF_FALSE_COLOR}`, high: "white" };
  }
  return { text: TONE_TITLES[state.tone], scale: null };
}

/** Return the name of a layer with its mean error, if it has one. */
function titleOf(stack, state, layer) {
  const error = meanError(state, layer);
  return error ? `${layer.label} · ${stack.metric} ${error}` : layer.label;
}

/** Return the mean error of a layer against the reference as text; empty if there is none. */
function meanError(state, layer) {
  const error = state.against && layer.errors[state.against.truth];
  return error === undefined || error === null ? "" : error.toFixed(4);
}

/** Return what a reader should know about the pixels that are shown; empty if nothing. */
function warningOf(stack, state) {
  if (stack.lossy) {
    return `${stack.trouble}, so these are previews: smaller, and not exact. Keep the folder of the page together.`;
  }
  if (!stack.radiance && state.stops !== 0 && state.map !== "flip") {
    return "Exposure acts on 8-bit display levels: light above white is lost. A report with --hdr keeps it.";
  }
  return "";
}

/** Return the values at a place, as texts: the pixel, and for a layer its colors and its error. */
function valueTexts(stack, state, layer, cursor) {
  if (!cursor) return { color: "", error: "" };
  const values = stack.values(layer, cursor.x, cursor.y);
  const error = state.against && stack.error(layer, state.against.truth, cursor.x, cursor.y);
  const digits = stack.radiance && !stack.lossy;
  const text = (value) => (Number.isNaN(value) ? "not finite" : digits ? short(value) : `${value}`);
  return {
    color: values ? values.map(text).join("  ") : "",
    error: error === undefined || error === null ? "" : error.toFixed(4),
  };
}
