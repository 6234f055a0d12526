// The list of all pictures, with their mean errors and the values under the cursor.

class List {
  /** `choose` is called with the layer of a row that is clicked. */
  constructor(table, choose) {
    this.table = table;
    this.choose = choose;
  }

  /** Make the rows of a stack. */
  fill(stack) {
    this.stack = stack;
    this.rows = stack.layers.map((layer) => this.row(layer));
    this.table.tBodies[0].replaceChildren(...this.rows.map((row) => row.element));
    const kind = stack.radiance && !stack.lossy ? "linear R G B" : "R G B, 0 to 255";
    this.table.querySelector(".kind").textContent = kind;
  }

  row(layer) {
    const element = document.createElement("tr");
    const cells = ["key", "name", "mean", "color", "error"].map((kind) => {
      const cell = document.createElement("td");
      cell.className = kind;
      element.append(cell);
      return cell;
    });
    const [key, name, mean, color, error] = cells;
    key.textContent = keyOf(this.stack, layer);
    if (layer.color) {
      const dot = document.createElement("span");
      dot.className = "dot";
      dot.style.background = layer.color;
      name.append(dot);
    }
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = layer.label;
    button.disabled = !layer.key;
    button.title = layer.note || layer.label;
    button.addEventListener("click", () => this.choose(layer));
    name.append(button);
    if (!layer.key) color.textContent = color.title = layer.note;
    return { element, layer, mean, color, error };
  }

  /** Show a state, and the values under the cursor. */
  show(state, cursor) {
    const { stack } = this;
    const [width, height] = stack.size;
    const pixel = cursor && `x ${Math.floor(cursor.x * width)}, y ${Math.floor(cursor.y * height)}`;
    this.table.querySelector(".pixel").textContent = pixel ?? "point at a pixel";
    this.table.querySelector(".metric").textContent =
      state.against ? `mean, here: ${stack.metric} against ${state.against.label}` : "no reference";
    for (const { element, layer, mean, color, error } of this.rows) {
      element.classList.toggle("shown", layer === state.layer);
      element.classList.toggle("reference", layer === state.against);
      mean.textContent = meanError(state, layer);
      if (!layer.key) continue;
      const texts = valueTexts(stack, state, layer, cursor);
      color.textContent = texts.color;
      error.textContent = texts.error;
    }
  }
}

/** Return the key that shows a layer, or an empty text. */
function keyOf(stack, layer) {
  if (layer.truth) return `⇧${stack.truths.indexOf(layer) + 1}`;
  const place = stack.methods.indexOf(layer);
  return place >= 0 && place < 9 ? `${place + 1}` : "";
}
