// The canvas with its panes and labels.

class Screen {
  constructor(stage) {
    this.stage = stage;
    this.canvas = stage.querySelector("canvas");
    this.labels = stage.querySelector(".labels");
    this.ratio = 1;
    this.panes = [];
  }

  /** Return a place of the canvas, in its pixels, from that of a pointer. */
  point(event) {
    const box = this.canvas.getBoundingClientRect();
    return { x: (event.clientX - box.left) * this.ratio, y: (event.clientY - box.top) * this.ratio };
  }

  draw(stack, painter, state, cursor) {
    const { canvas } = this;
    this.ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) =>
      Math.max(1, Math.round(side * this.ratio)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, width, height);
    this.panes = panesOf(stack, state, width, height);
    this.texts = [];
    for (const pane of this.panes) this.drawPane(context, stack, painter, state, pane, cursor);
    this.labels.replaceChildren(...this.texts);
    painter.tidy();
  }

  drawPane(context, stack, painter, state, pane, cursor) {
    const rectangle = placement(stack, state, pane);
    const whole = { ...pane, map: state.layout === "split" ? "picture" : pane.map };
    this.drawPicture(context, painter.paint(pane.layer, state, whole.map), rectangle, whole, titleOf(stack, state, pane.layer));
    if (state.layout === "split") this.drawSplit(context, painter, state, pane, rectangle);
    if (cursor) drawCursor(context, stack, rectangle, pane, cursor);
    if (state.layout === "panels" && pane.layer === state.layer) {
      context.strokeStyle = "#ffd24a";
      context.lineWidth = 2 * this.ratio;
      context.strokeRect(pane.x + 1, pane.y + 1, pane.width - 2, pane.height - 2);
    }
  }

  /** Draw the reference, or the error map, to the right of the divider. */
  drawSplit(context, painter, state, pane, rectangle) {
    const x = Math.round(pane.x + state.divider * pane.width);
    const right = { ...pane, x, width: pane.x + pane.width - x };
    context.clearRect(right.x, right.y, right.width, right.height);
    if (state.map !== "picture") {
      this.drawPicture(context, painter.paint(pane.layer, state), rectangle, right, MAP_TITLES[state.map], true);
    } else if (state.against) {
      const picture = painter.paint(state.against, state, "picture");
      this.drawPicture(context, picture, rectangle, right, state.against.label, true);
    } else this.write(right, "no reference", "pane-label right");
    context.fillStyle = "#ffd24a";
    context.fillRect(x - this.ratio, pane.y, 2 * this.ratio, pane.height);
  }

  drawPicture(context, picture, rectangle, pane, label, atRight = false) {
    this.write(pane, label, atRight ? "pane-label right" : "pane-label");
    if (typeof picture === "string") {
      this.write(pane, picture, "pane-reason");
      return;
    }
    context.save();
    context.beginPath();
    context.rect(pane.x, pane.y, pane.width, pane.height);
    context.clip();
    // Pixels stay squares when they are enlarged.
    context.imageSmoothingEnabled = rectangle.width < picture.width;
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, rectangle.x, rectangle.y, rectangle.width, rectangle.height);
    context.restore();
  }

  /** Write a text over a pane. */
  write(pane, text, kind) {
    const element = document.createElement("div");
    element.className = kind;
    element.append(Object.assign(document.createElement("span"), { textContent: text }));
    const style = { left: pane.x, top: pane.y, width: pane.width, height: pane.height };
    for (const [name, value] of Object.entries(style)) element.style[name] = `${value / this.ratio}px`;
    this.texts.push(element);
  }
}

/** Outline the pixel under the cursor, in every pane. */
function drawCursor(context, stack, rectangle, pane, cursor) {
  if (rectangle.scale < 4) return;
  const [column, row] = [Math.floor(cursor.x * stack.size[0]), Math.floor(cursor.y * stack.size[1])];
  const [x, y] = [rectangle.x + column * rectangle.scale, rectangle.y + row * rectangle.scale];
  context.save();
  context.beginPath();
  context.rect(pane.x, pane.y, pane.width, pane.height);
  context.clip();
  for (const [color, out] of [["#000", 1.5], ["#fff", 0.5]]) {
    context.strokeStyle = color;
    context.lineWidth = 1;
    context.strokeRect(x - out, y - out, rectangle.scale + 2 * out, rectangle.scale + 2 * out);
  }
  context.restore();
}
