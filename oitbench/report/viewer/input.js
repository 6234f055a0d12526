// Pointers and the wheel: zoom about the cursor, pan, pinch, move the divider, point at a pixel.

const SLACK = 6;
const WHEEL_STEP = 0.0015;
const WHEEL_LINE = 16;

class Pointers {
  constructor(viewer, canvas) {
    this.viewer = viewer;
    this.down = new Map();
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("pointercancel", (event) => this.release(event));
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse" && !this.down.size) viewer.point(null);
    });
  }

  get screen() {
    return this.viewer.screen;
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? WHEEL_LINE : 1;
    // A pinch on a touch pad comes as small steps with the control key.
    const factor = Math.exp(-event.deltaY * lines * WHEEL_STEP * (event.ctrlKey ? 6 : 1));
    this.zoom(factor, this.screen.point(event));
  }

  zoom(factor, { x, y }) {
    const { stack, state } = this.viewer;
    const pane = paneAt(this.screen.panes, x, y);
    if (pane) this.viewer.change(zoomed(stack, state, pane, factor, x, y));
  }

  press(event) {
    event.currentTarget.setPointerCapture(event.pointerId);
    const point = this.screen.point(event);
    this.down.set(event.pointerId, point);
    this.start = point;
    this.moved = this.down.size > 1;
    const { state } = this.viewer;
    const divider = state.divider * this.screen.canvas.width;
    const reach = (event.pointerType === "touch" ? 4 : 2) * SLACK * this.screen.ratio;
    this.divides = state.layout === "split" && Math.abs(point.x - divider) < reach;
  }

  move(event) {
    const point = this.screen.point(event);
    const last = this.down.get(event.pointerId);
    if (!last) {
      this.pointAt(point);
      return;
    }
    const reach = SLACK * this.screen.ratio;
    if (!this.moved && Math.hypot(point.x - this.start.x, point.y - this.start.y) < reach) return;
    this.moved = true;
    if (this.down.size === 2) this.pinch(event.pointerId, last, point);
    else if (this.divides) this.viewer.change({ divider: clamp(point.x / this.screen.canvas.width, 0, 1) });
    else this.pan(last, point);
    this.down.set(event.pointerId, point);
  }

  pan(last, point) {
    const { stack, state } = this.viewer;
    const pane = paneAt(this.screen.panes, this.start.x, this.start.y) ?? this.screen.panes[0];
    this.viewer.change(panned(stack, state, pane, point.x - last.x, point.y - last.y));
  }

  /** Two fingers: their distance zooms about their middle, and the middle moves the picture. */
  pinch(moving, last, point) {
    const [, other] = [...this.down].find(([id]) => id !== moving);
    const middle = (one) => ({ x: (one.x + other.x) / 2, y: (one.y + other.y) / 2 });
    const distance = (one) => Math.max(1, Math.hypot(one.x - other.x, one.y - other.y));
    this.pan(middle(last), middle(point));
    this.zoom(distance(point) / distance(last), middle(point));
  }

  release(event) {
    const known = this.down.delete(event.pointerId);
    if (!known || this.moved || event.type === "pointercancel") return;
    const pane = paneAt(this.screen.panes, this.start.x, this.start.y);
    if (pane && this.viewer.state.layout === "panels") this.viewer.change({ layer: pane.layer });
    this.pointAt(this.start);
  }

  pointAt({ x, y }) {
    const { stack, state } = this.viewer;
    const pane = paneAt(this.screen.panes, x, y);
    this.viewer.point(pane ? placeIn(placement(stack, state, pane), x, y) : null);
  }
}
