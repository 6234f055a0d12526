// Pixels of a stack: the script that holds them, and the numbers in it (report/pixels.py packs them).

const awaited = new Map();

window.oitbenchPixels = (name, pictures) => awaited.get(name)?.(pictures);

/** Return a promise of the packed pictures of a stack, whose script is at an address or in the page. */
function loadPixels(name, address) {
  return new Promise((resolve, reject) => {
    awaited.set(name, resolve);
    const script = document.createElement("script");
    const inside = [...document.querySelectorAll("script[data-pixels]")];
    const own = inside.find((element) => element.dataset.pixels === name);
    script.onerror = () => reject(new Error(`${decodeURIComponent(address)} is missing`));
    if (own) script.textContent = own.textContent;
    else script.src = address;
    document.head.append(script);
    script.remove();
  });
}

/** Return a promise of a picture: its size, its channels, the bits of a code, and its codes. */
async function unpack({ width, height, bits, data }) {
  const packed = Uint8Array.from(atob(data), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const depth = bits / 8;
  const channels = planes.length / (width * height * depth);
  const codes = new (bits === 16 ? Uint16Array : Uint8Array)(width * height * channels);
  let at = 0;
  for (let channel = 0; channel < channels; channel++) {
    for (let shift = bits - 8; shift >= 0; shift -= 8) {
      for (let row = 0; row < height; row++) {
        let byte = 0;
        for (let column = 0; column < width; column++) {
          // Each byte is the difference from the one to its left.
          byte = (byte + planes[at++]) & 255;
          codes[(row * width + column) * channels + channel] |= byte << shift;
        }
      }
    }
  }
  return { width, height, channels, bits, codes };
}

/** Return a promise of a preview as a picture of 8-bit display levels. */
async function readPreview(address) {
  const image = new Image();
  image.src = address;
  await image.decode();
  const [width, height] = [image.naturalWidth, image.naturalHeight];
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const rgba = context.getImageData(0, 0, width, height).data;
  const codes = new Uint8Array(width * height * 3).map((_, i) => rgba[Math.floor(i / 3) * 4 + (i % 3)]);
  return { width, height, channels: 3, bits: 8, codes };
}
