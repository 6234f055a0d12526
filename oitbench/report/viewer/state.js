// The state of the viewer, and its form in the address of the page.

const LAYOUTS = ["one", "split", "panels"];
const MAPS = ["picture", "flip", "signed", "absolute"];
const TONES = ["srgb", "gamma", "false"];
const START = {
  layer: null, against: null, layout: "one", map: "picture", tone: "srgb", stops: 0, gain: 0,
  zoom: 1, x: 0.5, y: 0.5, divider: 0.5, crop: "",
};
const LARGEST_ZOOM = 256;
const MOST_STOPS = 20;

function clamp(value, low, high) {
  return Math.max(low, Math.min(high, value));
}

/** Return the state that opens a stack: its first method beside the truth that ranks it. */
function firstState(stack) {
  return { ...START, layer: stack.methods[0] ?? stack.visible[0], against: stack.firstTruth };
}

/** Return the part of an address that stands for a state. */
function toAddress(stack, state) {
  const fields = new URLSearchParams({ view: stack.name });
  const first = firstState(stack);
  const { layer, against } = state;
  fields.set(layer.truth ? "truth" : "method", layer.truth || layer.label);
  if (against && against !== first.against) fields.set("against", against.truth);
  for (const name of ["layout", "map", "tone", "stops", "gain", "crop"]) {
    if (state[name] !== START[name]) fields.set(name, state[name]);
  }
  if (!state.crop && (state.zoom !== 1 || state.x !== 0.5 || state.y !== 0.5)) {
    fields.set("at", [state.x.toFixed(4), state.y.toFixed(4), state.zoom.toFixed(3)].join(","));
  }
  if (state.layout === "split") fields.set("divider", state.divider.toFixed(3));
  return `#${fields}`;
}

/** Return the name of the stack in an address, or null. */
function stackName(address) {
  return new URLSearchParams(address.replace(/^#/, "")).get("view");
}

/** Return the state in an address; what it does not say, or says wrongly, is as at the start. */
function fromAddress(stack, address) {
  const fields = new URLSearchParams(address.replace(/^#/, ""));
  const state = firstState(stack);
  const method = stack.methods.find((layer) => layer.label === fields.get("method"));
  state.layer = stack.truth(fields.get("truth")) ?? method ?? state.layer;
  state.against = stack.truth(fields.get("against")) ?? state.against;
  for (const [name, known] of [["layout", LAYOUTS], ["map", MAPS], ["tone", TONES]]) {
    if (known.includes(fields.get(name))) state[name] = fields.get(name);
  }
  const number = (name, value, low, high) => {
    const read = value === null || value === undefined ? NaN : Number.parseFloat(value);
    if (Number.isFinite(read)) state[name] = clamp(read, low, high);
  };
  number("stops", fields.get("stops"), -MOST_STOPS, MOST_STOPS);
  number("gain", fields.get("gain"), -MOST_STOPS, MOST_STOPS);
  number("divider", fields.get("divider"), 0, 1);
  const [x, y, zoom] = (fields.get("at") ?? "").split(",");
  number("x", x, 0, 1);
  number("y", y, 0, 1);
  number("zoom", zoom, 0.25, LARGEST_ZOOM);
  if (Object.hasOwn(stack.crops, fields.get("crop") ?? "")) state.crop = fields.get("crop");
  return state;
}
