// A stack: what the page knows of the pictures of a scene, and their pixels once they are loaded.

class Stack {
  constructor(element) {
    Object.assign(this, JSON.parse(element.querySelector("script").textContent));
    this.element = element;
    this.previews = [...element.querySelectorAll("[data-preview]")].map((image) => image.src);
    this.methods = this.layers.filter((layer) => !layer.truth && layer.key);
    this.truths = this.layers.filter((layer) => layer.truth);
    this.visible = this.layers.filter((layer) => layer.key);
    /** Whether the pixels are those of previews: reduced, and not exact. */
    this.lossy = false;
    this.trouble = "";
    this.pictures = new Map();
  }

  get base() {
    return this.radiance ? this.exposure : 0;
  }

  truth(key) {
    return this.visible.find((layer) => layer.truth === key);
  }

  /** Return the truth that is compared with at first. */
  get firstTruth() {
    return this.truth(this.against) ?? this.truths.find((layer) => layer.key);
  }

  /** Load the script of the pixels; if there is none, previews take their place. */
  async load() {
    this.loading ??= loadPixels(this.name, this.pixels).then(
      (packed) => (this.packed = packed),
      (error) => {
        this.lossy = true;
        this.trouble = error.message;
      },
    );
    await this.loading;
  }

  /** Return the picture of a name if it is unpacked. */
  picture(key) {
    const found = this.pictures.get(key);
    return found instanceof Promise ? undefined : found;
  }

  /** Return a promise of the pixels of a layer, or of one of its error maps. */
  unpack(key) {
    if (!this.pictures.has(key)) {
      const number = this.visible.findIndex((layer) => layer.key === key);
      const made = this.lossy ? readPreview(this.previews[number]) : unpack(this.packed[key]);
      this.pictures.set(key, made);
      made.then((picture) => this.pictures.set(key, picture));
    }
    return this.pictures.get(key);
  }

  /** Return the numbers of a picture at a place in [0, 1]², or undefined. */
  codes(key, x, y) {
    const picture = this.picture(key);
    if (!picture) return undefined;
    const { width, height, channels, codes } = picture;
    const at = (Math.floor(y * height) * width + Math.floor(x * width)) * channels;
    return codes.subarray(at, at + channels);
  }

  /** Return the stored values of a layer at a place: levels from 0 to 255, or linear radiance. */
  values(layer, x, y) {
    const codes = this.codes(layer.key, x, y);
    if (!codes) return undefined;
    const levels = !this.radiance || this.lossy;
    return Array.from(codes, (code) => (levels ? code : stored(16)[code]));
  }

  /** Return the error of a layer at a place, or undefined. */
  error(layer, truth, x, y) {
    const key = layer.maps[truth];
    const codes = key && this.codes(key, x, y);
    return codes && errorTable()[codes[0]];
  }
}
