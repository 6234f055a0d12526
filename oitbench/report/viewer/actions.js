// What keys and buttons do. `keys` are values of KeyboardEvent.key; `button` is a text in the bar.

function next(values, value) {
  return values[(values.indexOf(value) + 1) % values.length];
}

/** Change the exposure, or with an error map its factor, by stops. */
function brighten(viewer, stops) {
  const name = viewer.state.map === "picture" ? "stops" : "gain";
  viewer.change({ [name]: clamp(viewer.state[name] + stops, -MOST_STOPS, MOST_STOPS) });
}

function toggleLayout(viewer, layout) {
  viewer.change({ layout: viewer.state.layout === layout ? "one" : layout });
}

/** Show the picture before or after the one that is shown; truths are among them. */
function flip(viewer, step) {
  const { visible } = viewer.stack;
  const place = visible.indexOf(viewer.state.layer) + step + visible.length;
  viewer.change({ layer: visible[place % visible.length] });
}

function showMethod(viewer, place) {
  const layer = viewer.stack.methods[place];
  if (layer) viewer.change({ layer });
}

/** Compare with a truth and, unless a map or the divider needs the method, show it; again: go back. */
function showTruth(viewer, place) {
  const truth = viewer.stack.truths[place];
  if (!truth) return;
  if (!truth.key) {
    viewer.say(`${truth.label}: ${truth.note}`);
    return;
  }
  const { layer, map, layout } = viewer.state;
  if (map !== "picture" || layout === "split") viewer.change({ against: truth });
  else if (layer === truth) viewer.change({ layer: viewer.lastMethod ?? layer });
  else viewer.change({ against: truth, layer: truth });
}

function nextCrop(viewer) {
  const names = Object.keys(viewer.stack.crops);
  viewer.change({ crop: next(["", ...names], viewer.state.crop), zoom: 1, x: 0.5, y: 0.5 });
}

function reset(viewer) {
  const { layer, against } = viewer.state;
  viewer.change({ ...START, layer, against });
}

function fullScreen(viewer) {
  if (document.fullscreenElement) document.exitFullscreen();
  else viewer.frame.requestFullscreen().catch((error) => viewer.say(error.message));
}

const ACTIONS = [
  { keys: ["ArrowLeft"], shown: "←", button: "‹", help: "previous picture", run: (viewer) => flip(viewer, -1) },
  { keys: ["ArrowRight"], shown: "→", button: "›", help: "next picture", run: (viewer) => flip(viewer, 1) },
  { shown: "1 … 9", help: "method" },
  { shown: "Shift 1 … 3", help: "reference; again: back to the method" },
  {
    keys: ["s"], button: "Split", help: "divider between picture and reference or error map",
    run: (viewer) => toggleLayout(viewer, "split"), on: (state) => state.layout === "split",
  },
  {
    keys: ["p"], button: "Panels", help: "all pictures side by side",
    run: (viewer) => toggleLayout(viewer, "panels"), on: (state) => state.layout === "panels",
  },
  {
    keys: ["m"], button: "Map", help: `error map: FLIP, signed × ${MAGNIFIED}, absolute × ${MAGNIFIED}`,
    run: (viewer) => viewer.change({ map: next(MAPS, viewer.state.map) }),
    on: (state) => state.map !== "picture",
  },
  {
    keys: ["g"], button: "Tone", help: `sRGB, gamma ${SHADOW_GAMMA}, false color`,
    run: (viewer) => viewer.change({ tone: next(TONES, viewer.state.tone), map: "picture" }),
    on: (state) => state.tone !== "srgb",
  },
  { keys: ["e"], button: "−", help: "exposure down a stop; of a map, its factor", run: (viewer) => brighten(viewer, -1) },
  { keys: ["E"], button: "+", help: "exposure up a stop; of a map, its factor", run: (viewer) => brighten(viewer, 1) },
  {
    keys: ["c"], button: "Crop", help: "next crop that the scene's file names", run: nextCrop,
    on: (state) => state.crop !== "", usable: (stack) => Object.keys(stack.crops).length > 0,
  },
  { shown: "wheel, pinch", help: "zoom about the cursor" },
  { shown: "drag", help: "pan, in all panels; move the divider" },
  { keys: ["r"], button: "Reset", help: "zoom, exposure and layout as at first", run: reset },
  { keys: ["f"], button: "Full", help: "full screen", run: fullScreen },
  { keys: ["d"], button: "Save", help: "download the picture or map as PNG", run: (viewer) => viewer.save() },
  { keys: ["?"], button: "Help", help: "these keys", run: (viewer) => viewer.toggleHelp() },
  { keys: ["Escape"], shown: "Esc", button: "Close", help: "back to the page", run: (viewer) => viewer.close() },
];

/** Do what a key stands for; return whether it stands for anything. */
function runKey(viewer, event) {
  const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
  if (digit) {
    (event.shiftKey ? showTruth : showMethod)(viewer, digit - 1);
    return true;
  }
  const action = ACTIONS.find(({ keys }) => keys?.includes(event.key));
  action?.run(viewer);
  return Boolean(action);
}
