// The viewer: one dialog for all stacks of the page, opened by the address.

const PREFIX = "#view=";
const ADDRESS_DELAY = 150;

class Viewer {
  constructor(dialog) {
    this.dialog = dialog;
    this.frame = dialog.querySelector(".frame");
    this.screen = new Screen(dialog.querySelector(".stage"));
    this.list = new List(dialog.querySelector(".side table"), (layer) => this.change({ layer }));
    this.stacks = [...document.querySelectorAll("[data-stack]")].map((element) => new Stack(element));
    this.pointers = new Pointers(this, this.screen.canvas);
    this.makeBar();
    dialog.addEventListener("keydown", (event) => this.key(event));
    dialog.addEventListener("close", () => this.leave());
    new ResizeObserver(() => this.refresh()).observe(this.screen.canvas);
    window.addEventListener("hashchange", () => this.follow());
    this.follow();
  }

  part(name) {
    return this.dialog.querySelector(`.${name}`);
  }

  makeBar() {
    const scenes = this.part("scenes");
    scenes.replaceChildren(...this.stacks.map((stack) => new Option(stack.title, stack.name)));
    scenes.addEventListener("change", () => {
      window.location.hash = PREFIX + encodeURIComponent(scenes.value);
      this.screen.canvas.focus();
    });
    this.buttons = ACTIONS.filter((action) => action.button).map((action) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = action.button;
      button.title = `${action.help} (${action.shown ?? action.keys[0]})`;
      button.setAttribute("aria-label", button.title);
      button.addEventListener("click", () => {
        action.run(this);
        this.screen.canvas.focus();
      });
      return { ...action, element: button };
    });
    this.part("buttons").replaceChildren(...this.buttons.map(({ element }) => element));
    const rows = ACTIONS.map(({ shown, keys, help }) => {
      const row = document.createElement("tr");
      for (const text of [shown ?? keys[0], help]) row.insertCell().textContent = text;
      return row;
    });
    this.part("keys").replaceChildren(...rows);
  }

  /** Show what the address says. */
  follow() {
    const { hash } = window.location;
    const stack = this.stacks.find(({ name }) => name === stackName(hash));
    if (!hash.startsWith(PREFIX) || !stack) {
      this.dialog.close();
    } else if (!this.dialog.open || this.stack !== stack || hash !== toAddress(stack, this.state)) {
      this.open(stack, fromAddress(stack, hash));
    }
  }

  async open(stack, state) {
    [this.stack, this.state, this.painter] = [stack, state, new Painter(stack)];
    this.lastMethod = state.layer.truth ? stack.methods[0] : state.layer;
    this.cursor = null;
    this.part("scenes").value = stack.name;
    this.say("");
    this.list.fill(stack);
    for (const { element, usable } of this.buttons) if (usable) element.disabled = !usable(stack);
    if (!this.dialog.open) this.dialog.showModal();
    this.screen.canvas.focus();
    this.refresh();
    await stack.load();
    if (this.stack !== stack) return;
    this.list.fill(stack);
    await this.unpack(stack);
  }

  /** Unpack what is shown, then the rest, so that flipping never waits. */
  async unpack(stack) {
    const { layer, against, map } = this.state;
    const maps = (one) => (against && one.maps[against.truth] ? [one.maps[against.truth]] : []);
    const pictures = [layer, ...(against ? [against] : []), ...stack.visible].map(({ key }) => key);
    const errors = stack.lossy ? [] : [layer, ...stack.visible].flatMap(maps);
    const keys = map === "flip" ? [...errors, ...pictures] : [...pictures, ...errors];
    try {
      for (const key of keys) {
        if (stack.picture(key)) continue;
        await stack.unpack(key);
        if (this.stack !== stack) return;
        this.refresh();
      }
    } catch (error) {
      this.say(`The pixels cannot be unpacked (${error.message}); use a newer browser.`);
    }
  }

  change(changes) {
    const { against } = this.state;
    Object.assign(this.state, changes);
    if (!this.state.layer.truth) this.lastMethod = this.state.layer;
    if (this.state.against !== against) this.unpack(this.stack);
    this.say("");
    this.refresh();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.writeAddress(), ADDRESS_DELAY);
  }

  writeAddress() {
    if (this.dialog.open) history.replaceState(null, "", toAddress(this.stack, this.state));
  }

  /** Set the place in the pictures, in [0, 1]², whose values are shown; null for none. */
  point(cursor) {
    this.cursor = cursor;
    this.refresh();
  }

  /** Show a message until the next change. */
  say(text) {
    this.part("message").textContent = text;
  }

  refresh() {
    if (this.frameRequest || !this.dialog.open) return;
    this.frameRequest = requestAnimationFrame(() => {
      this.frameRequest = 0;
      if (this.dialog.open) this.draw();
    });
  }

  draw() {
    const { stack, state, cursor } = this;
    this.screen.draw(stack, this.painter, state, cursor);
    this.list.show(state, cursor);
    for (const { element, on } of this.buttons) if (on) element.setAttribute("aria-pressed", on(state));
    const { text, scale, low, high } = legendOf(stack, state);
    const exposure = state.map === "picture" || state.stops ? `exposure ${signedStops(state.stops)}` : "";
    const pane = this.screen.panes[0];
    const zoom = placement(stack, state, pane).scale / this.screen.ratio;
    const crop = state.crop && `crop ${state.crop}`;
    const facts = [text, exposure, crop, `zoom × ${short(zoom)}`].filter(Boolean).join(" · ");
    this.part("facts").textContent = facts;
    this.part("scale").hidden = !scale;
    if (scale) {
      this.part("ramp").style.background = scale;
      this.part("low").textContent = low;
      this.part("high").textContent = high;
    }
    this.part("warning-text").textContent = warningOf(stack, state);
    this.part("now").textContent = `${state.layer.label}: ${MAP_TITLES[state.map]}`;
    this.screen.canvas.setAttribute("aria-label", `${stack.title}, ${state.layer.label}, ${facts}`);
  }

  key(event) {
    const busy = event.ctrlKey || event.metaKey || event.altKey;
    if (busy || (event.target.tagName === "SELECT" && event.key !== "Escape")) return;
    if (runKey(this, event)) event.preventDefault();
  }

  toggleHelp() {
    const help = this.part("help");
    help.hidden = !help.hidden;
  }

  /** Download the picture or map of the layer that is shown, in its own pixels. */
  save() {
    const painted = this.painter.paint(this.state.layer, this.state);
    if (typeof painted === "string") {
      this.say(painted);
      return;
    }
    painted.toBlob((content) => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(content);
      const { map, layer } = this.state;
      link.download = `${this.stack.name} ${layer.label}${map === "picture" ? "" : ` ${map}`}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  close() {
    if (!this.part("help").hidden) {
      this.toggleHelp();
      return;
    }
    this.dialog.close();
  }

  /** Tidy up after the dialog has closed, by a key, by the address or by the browser. */
  leave() {
    clearTimeout(this.timer);
    if (document.fullscreenElement) document.exitFullscreen();
    this.part("help").hidden = true;
    if (!window.location.hash.startsWith(PREFIX)) return;
    const { element } = this.stack;
    history.replaceState(null, "", `#${element.id}`);
    element.scrollIntoView({ block: "nearest" });
  }
}

new Viewer(document.getElementById("viewer"));
