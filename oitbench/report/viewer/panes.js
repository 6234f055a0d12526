// Where pictures are on the canvas, in its pixels. All panes show the same part of their pictures.

const GAP = 4;

/** Return the panes of a state: rectangles with the layer and the map that each shows. */
function panesOf(stack, state, width, height) {
  if (state.layout !== "panels") {
    return [{ layer: state.layer, map: state.map, x: 0, y: 0, width, height }];
  }
  const layers = stack.visible;
  const [wide, tall] = stack.size;
  let columns = 1;
  let best = 0;
  // The number of columns that shows pictures largest.
  for (let count = 1; count <= layers.length; count++) {
    const rows = Math.ceil(layers.length / count);
    const scale = Math.min(width / count / wide, height / rows / tall);
    if (scale > best) [best, columns] = [scale, count];
  }
  const rows = Math.ceil(layers.length / columns);
  const edge = (whole, count, number) => Math.round((number * (whole + GAP)) / count);
  return layers.map((layer, number) => {
    const [row, column] = [Math.floor(number / columns), number % columns];
    const [x, y] = [edge(width, columns, column), edge(height, rows, row)];
    const right = edge(width, columns, column + 1) - GAP;
    const bottom = edge(height, rows, row + 1) - GAP;
    // References have no FLIP map, so they stay pictures.
    const map = layer.truth && state.map === "flip" ? "picture" : state.map;
    return { layer, map, x, y, width: right - x, height: bottom - y };
  });
}

/** Return the center and the zoom of a state; those of a crop follow from the size of a pane. */
function viewOf(stack, state, pane) {
  if (!state.crop) return { x: state.x, y: state.y, zoom: state.zoom };
  const [left, top, width, height] = stack.crops[state.crop];
  const [wide, tall] = stack.size;
  const scale = Math.min(pane.width / (width * wide), pane.height / (height * tall));
  return { x: left + width / 2, y: top + height / 2, zoom: scale / fit(stack, pane) };
}

/** Return the canvas pixels of a picture's pixel at zoom 1: a whole number unless that wastes space. */
function fit(stack, pane) {
  const scale = Math.min(pane.width / stack.size[0], pane.height / stack.size[1]);
  return scale >= 3 ? Math.floor(scale) : scale;
}

/** Return the rectangle that the whole picture takes, which may be larger than its pane. */
function placement(stack, state, pane) {
  const view = viewOf(stack, state, pane);
  const scale = fit(stack, pane) * view.zoom;
  const [width, height] = stack.size.map((side) => side * scale);
  const x = Math.round(pane.x + pane.width / 2 - view.x * width);
  const y = Math.round(pane.y + pane.height / 2 - view.y * height);
  return { x, y, width, height, scale };
}

/** Return the pane at a place of the canvas, or undefined. */
function paneAt(panes, x, y) {
  return panes.find((pane) =>
    x >= pane.x && x < pane.x + pane.width && y >= pane.y && y < pane.y + pane.height);
}

/** Return the place in a picture, in [0, 1)², at a place of the canvas; null if it is beside it. */
function placeIn(rectangle, x, y) {
  const place = { x: (x - rectangle.x) / rectangle.width, y: (y - rectangle.y) / rectangle.height };
  return place.x >= 0 && place.x < 1 && place.y >= 0 && place.y < 1 ? place : null;
}

/** Return the changes of a state that zoom by a factor and keep what is at a place of a pane. */
function zoomed(stack, state, pane, factor, x, y) {
  const view = viewOf(stack, state, pane);
  const zoom = clamp(view.zoom * factor, 0.25, LARGEST_ZOOM);
  const scale = fit(stack, pane);
  const moved = (center, offset, side) =>
    clamp(center + (offset / (side * scale)) * (1 / view.zoom - 1 / zoom), 0, 1);
  return {
    crop: "",
    zoom,
    x: moved(view.x, x - pane.x - pane.width / 2, stack.size[0]),
    y: moved(view.y, y - pane.y - pane.height / 2, stack.size[1]),
  };
}

/** Return the changes of a state that move the picture in a pane by canvas pixels. */
function panned(stack, state, pane, dx, dy) {
  const view = viewOf(stack, state, pane);
  const scale = fit(stack, pane) * view.zoom;
  return {
    crop: "",
    zoom: view.zoom,
    x: clamp(view.x - dx / (stack.size[0] * scale), 0, 1),
    y: clamp(view.y - dy / (stack.size[1] * scale), 0, 1),
  };
}
