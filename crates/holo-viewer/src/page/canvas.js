// The renderer without WebGL: the same images, computed by the processor. It is slower, and reduced images show the nearest
// pixel instead of the mean.

const DECODED = Float32Array.from({ length: 256 }, (_, code) => {
  const value = code / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
});

const encode = (value) => 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);

class CanvasRenderer {
  constructor() {
    this.name = 'canvas';
    // Below the canvas of the gestures, which cannot get this context after an attempt to use WebGL.
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'fallback';
    stage.before(this.canvas);
    stage.style.opacity = 0;
    this.context = this.canvas.getContext('2d', { alpha: false, willReadFrequently: true });
    this.maps = {};
  }

  async setImage(bitmap) {
    const [width, height] = rawSize;
    this.raw = new Uint8ClampedArray(4 * width * height);
    const band = new OffscreenCanvas(width, Math.min(height, 512));
    const context = band.getContext('2d', { willReadFrequently: true });
    for (let top = 0; top < height; top += band.height) {
      const rows = Math.min(band.height, height - top);
      context.drawImage(bitmap, 0, top, width, rows, 0, 0, width, rows);
      this.raw.set(context.getImageData(0, 0, width, rows).data, 4 * width * top);
    }
  }

  async setMap(name, { values, colors, low, high }) {
    const bytes = new Uint8ClampedArray(4 * values.length);
    for (let index = 0; index < values.length; index += 1) {
      const value = values[index];
      if (Number.isFinite(value)) {
        const color = 4 * Math.round(255 * clamp((value - low) / (high - low), 0, 1));
        bytes.set(colors.subarray(color, color + 4), 4 * index);
      } else {
        const odd = ((index % lenses[0]) + Math.floor(index / lenses[0])) & 1;
        bytes.set(odd ? [41, 41, 41, 255] : [33, 33, 33, 255], 4 * index);
      }
    }
    this.maps[name] = bytes;
  }

  addViews({ center, first, taken, stride, disparity }, start, count) {
    const [width, height] = lenses;
    if (start === 0) this.adding = new Float32Array(4 * width * height);
    const at = (column, row, view) => {
      const u = clamp(column, 0, width - 1);
      const v = clamp(row, 0, height - 1);
      return 4 * ((v * views[1] + view[1]) * rawSize[0] + u * views[0] + view[0]);
    };
    for (let index = start; index < start + count; index += 1) {
      const view = [first[0] + stride * (index % taken[0]), first[1] + stride * Math.floor(index / taken[0])];
      for (let row = 0; row < height; row += 1) {
        const y = row - disparity[1] * (view[1] - center[1]);
        if (y < -0.5 || y > height - 0.5) continue;
        const [top, down] = [Math.floor(y), y - Math.floor(y)];
        for (let column = 0; column < width; column += 1) {
          const x = column - disparity[0] * (view[0] - center[0]);
          if (x < -0.5 || x > width - 0.5) continue;
          const [left, along] = [Math.floor(x), x - Math.floor(x)];
          const corners = [at(left, top, view), at(left + 1, top, view), at(left, top + 1, view), at(left + 1, top + 1, view)];
          const into = 4 * (row * width + column);
          for (let channel = 0; channel < 3; channel += 1) {
            const [a, b, c, d] = corners.map((corner) => DECODED[this.raw[corner + channel]]);
            this.adding[into + channel] += (a + (b - a) * along) * (1 - down) + (c + (d - c) * along) * down;
          }
          this.adding[into + 3] += 1;
        }
      }
    }
  }

  showSum() {
    this.focused = new Uint8ClampedArray(this.adding.length);
    for (let index = 0; index < this.adding.length; index += 4) {
      const count = Math.max(this.adding[index + 3], 1);
      for (let channel = 0; channel < 3; channel += 1) {
        this.focused[index + channel] = encode(Math.min(this.adding[index + channel] / count, 1));
      }
    }
  }

  finished() {
    return new Promise((done) => setTimeout(done, 0));
  }

  // The bytes of a shown image, and the offset of a pixel in them.
  source(kind, mode, view) {
    const width = rawSize[0];
    if (kind === 'focused') return [this.focused, (x, y) => 4 * (y * lenses[0] + x)];
    if (kind === 'depth' || kind === 'error') return [this.maps[mode], (x, y) => 4 * (y * lenses[0] + x)];
    if (kind === 'raw') return [this.raw, (x, y) => 4 * (y * width + x)];
    if (kind === 'view') return [this.raw, (x, y) => 4 * ((y * views[1] + view[1]) * width + x * views[0] + view[0])];
    return [this.raw, (x, y) => {
      const row = (y % lenses[1]) * views[1] + Math.floor(y / lenses[1]);
      return 4 * (row * width + (x % lenses[0]) * views[0] + Math.floor(x / lenses[0]));
    }];
  }

  draw({ kind, mode, view, scale, offset }) {
    const { width, height } = stage;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const image = this.context.createImageData(width, height);
    const size = sheetSize(mode);
    const period = sheetPeriod(mode);
    const [bytes, at] = this.source(kind, mode, view);
    const lined = Math.min(...period) * scale > 16;
    const columns = Int32Array.from({ length: width }, (_, x) => Math.floor((x + 0.5 - offset[0]) / scale));
    for (let y = 0; y < height; y += 1) {
      const row = Math.floor((y + 0.5 - offset[1]) / scale);
      const above = Math.floor((y - 0.5 - offset[1]) / scale);
      const rowLine = lined && Math.floor(row / period[1]) !== Math.floor(above / period[1]);
      for (let x = 0; x < width; x += 1) {
        const column = columns[x];
        const into = 4 * (y * width + x);
        const inside = column >= 0 && row >= 0 && column < size[0] && row < size[1];
        const from = inside ? at(column, row) : 0;
        const before = x > 0 ? columns[x - 1] : column;
        const onLine = inside && lined && (rowLine || Math.floor(column / period[0]) !== Math.floor(before / period[0]));
        for (let channel = 0; channel < 3; channel += 1) {
          const color = inside ? bytes[from + channel] : 255 * GROUND[channel];
          image.data[into + channel] = onLine ? 0.6 * color + 0.4 * 128 : color;
        }
        image.data[into + 3] = 255;
      }
    }
    this.context.putImageData(image, 0, 0);
  }

  pixel([x, y]) {
    return [...this.context.getImageData(Math.floor(x), Math.floor(y), 1, 1).data.slice(0, 3)];
  }
}
