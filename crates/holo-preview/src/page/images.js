// What is shown: the view, depth as disparity, what one microlens sees, the strip of the raw image.

const element = (id) => document.getElementById(id);
const image = element('image');

const shown = { view: null, strip: null, frame: { x: 0, y: 0, width: 1, height: 1 } };

const drawView = () => {
  const ratio = window.devicePixelRatio || 1;
  const box = image.getBoundingClientRect();
  const [width, height] = [Math.max(1, Math.round(box.width * ratio)), Math.max(1, Math.round(box.height * ratio))];
  if (image.width !== width || image.height !== height) {
    image.width = width;
    image.height = height;
  }
  const canvas = image.getContext('2d', { alpha: false });
  canvas.fillStyle = '#141415';
  canvas.fillRect(0, 0, width, height);
  const bitmap = shown.view;
  if (!bitmap) return;
  const scale = Math.min(width / bitmap.width, height / bitmap.height);
  const [w, h] = [bitmap.width * scale, bitmap.height * scale];
  const frame = { x: (width - w) / 2, y: (height - h) / 2, width: w, height: h };
  shown.frame = { x: frame.x / ratio, y: frame.y / ratio, width: w / ratio, height: h / ratio };
  canvas.imageSmoothingQuality = look.moving ? 'low' : 'high';
  canvas.drawImage(bitmap, frame.x, frame.y, w, h);
};

// The place of a pointer in the image, 0 to 1 along both axes; null beside it.
const placeInImage = (event) => {
  const box = image.getBoundingClientRect();
  const x = (event.clientX - box.left - shown.frame.x) / shown.frame.width;
  const y = (event.clientY - box.top - shown.frame.y) / shown.frame.height;
  return x >= 0 && x < 1 && y >= 0 && y < 1 ? [x, y] : null;
};

// Depth in meters at a place in the image; NaN where it is not known.
const depthAt = (x, y) => {
  const map = seen.details?.map;
  if (!map || !seen.depth) return NaN;
  const [column, row] = [Math.floor(x * map[0]), Math.floor(y * map[1])];
  return seen.depth[row * map[0] + column] ?? NaN;
};

// Eq. 3: px between adjacent views; an infinite depth has a finite disparity.
const disparityOf = (depth) => {
  const details = seen.details;
  return details?.scale_m_px ? details.scale_m_px[0] * (1 / depth - details.inverse_focus_per_m) : NaN;
};

// Dark blue to yellow, evenly brighter.
const ANCHORS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
const colorOf = (part) => {
  const at = Math.max(0, Math.min(0.9999, part)) * (ANCHORS.length - 1);
  const k = Math.floor(at);
  return ANCHORS[k].map((value, c) => value + (ANCHORS[k + 1][c] - value) * (at - k));
};

const BINS = 128;

// Pixels with three digits, however few they are.
const pixelText = (value) => (Math.abs(value) >= 0.1 ? value.toFixed(3) : String(Number(value.toPrecision(3))));

const drawMap = () => {
  const [canvas, histogram] = [element('map'), element('histogram')];
  const map = seen.details?.map;
  element('truth').hidden = !map;
  if (!map || !seen.depth) return;
  const values = Array.from(seen.depth, disparityOf);
  // The map may have fewer pixels than a view; the range is that of all.
  const range = seen.details.depth_m;
  const [low, high] = range ? [disparityOf(range[1]), disparityOf(range[0])] : [0, 0];
  [canvas.width, canvas.height] = map;
  const context = canvas.getContext('2d');
  const pixels = context.createImageData(map[0], map[1]);
  const counts = new Array(BINS).fill(0);
  const width = Math.max(high - low, 1e-12);
  seen.depth.forEach((depth, k) => {
    const isHit = Number.isFinite(depth);
    const part = (values[k] - low) / width;
    if (isHit) counts[Math.max(0, Math.min(BINS - 1, Math.floor(part * BINS)))] += 1;
    const [r, g, b] = isHit ? colorOf(part) : [38, 38, 42];
    pixels.data.set([r, g, b, 255], 4 * k);
  });
  context.putImageData(pixels, 0, 0);
  const bars = histogram.getContext('2d');
  bars.clearRect(0, 0, histogram.width, histogram.height);
  const largest = Math.max(...counts, 1);
  counts.forEach((count, k) => {
    const [r, g, b] = colorOf((k + 0.5) / BINS);
    bars.fillStyle = `rgb(${r},${g},${b})`;
    const height = Math.sqrt(count / largest) * histogram.height;
    bars.fillRect((k * histogram.width) / BINS, histogram.height - height, histogram.width / BINS + 0.5, height);
  });
  const zero = ((0 - low) / width) * histogram.width;
  bars.fillStyle = '#ffffff';
  if (zero >= 0 && zero <= histogram.width) bars.fillRect(zero - 0.5, 0, 1, histogram.height);
  const text = range ? `${pixelText(low)} to ${pixelText(high)} px between adjacent views; white line: in focus` : 'nothing is hit';
  const missed = 100 * (1 - seen.details.hit_share);
  element('range').textContent = missed > 0 && range ? `${text}; ${missed.toPrecision(2)} % sees nothing` : text;
};

const drawPart = (canvas, bitmap) => {
  [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
  canvas.getContext('2d').drawImage(bitmap, 0, 0);
};

// One elemental image, cut out of the strip.
const drawLens = () => {
  const { strip: header } = seen;
  const bitmap = shown.strip;
  if (!header || !bitmap) return;
  const pitch = header.pitch_px;
  let box = null;
  if (header.is_rig) {
    const lenses = seen.details?.lenses ?? [Math.round(header.raw[0] / pitch)];
    const column = Math.min(state.lens?.[0] ?? Math.floor(lenses[0] / 2), lenses[0] - 1);
    const height = header.views[1];
    const row = Math.min(state.lens?.[1] ?? header.row, header.first_row + bitmap.height / height - 1);
    box = [Math.max(0, column * pitch - header.first), (row - header.first_row) * height, pitch, height];
    element('lens-text').textContent = `microlens ${column},${row}: ${header.views[0]} x ${header.views[1]} px`;
  } else {
    const side = Math.min(3 * pitch, bitmap.width, bitmap.height);
    box = [(bitmap.width - side) / 2, (bitmap.height - side) / 2, side, side];
    element('lens-text').textContent = `micro-images, ${pitch.toFixed(1)} px apart`;
  }
  const canvas = element('lens');
  [canvas.width, canvas.height] = [Math.max(1, Math.round(box[2])), Math.max(1, Math.round(box[3]))];
  canvas.getContext('2d').drawImage(bitmap, ...box, 0, 0, canvas.width, canvas.height);
};

const bitmapOf = (bytes, type) => createImageBitmap(new Blob([bytes], { type }));

on('view', async (header, bytes) => {
  // The next look can be drawn while this one is decoded.
  answered(header.number);
  const bitmap = await bitmapOf(bytes, 'image/jpeg');
  if (header.number < look.shown) return;
  look.shown = header.number;
  seen.view = header;
  shown.view?.close();
  shown.view = bitmap;
  counters.views += 1;
  drawView();
  const rate = header.moving ? `${header.milliseconds.toFixed(0)} ms` : `${header.samples} samples`;
  element('status').textContent = rate;
});

on('strip', async (header, bytes) => {
  const bitmap = await bitmapOf(bytes, 'image/png');
  seen.strip = header;
  shown.strip?.close();
  shown.strip = bitmap;
  drawPart(element('strip'), bitmap);
  element('strip-text').textContent = header.raw
    ? `part of the raw image of ${header.raw[0]} x ${header.raw[1]} px, at its real size; 1 sample a pixel`
    : 'part of the raw image';
  element('white-figure').hidden = header.is_rig;
  drawLens();
});

on('white', async (header, bytes) => {
  const bitmap = await bitmapOf(bytes, 'image/png');
  drawPart(element('white'), bitmap);
  bitmap.close();
  element('white-text').textContent = `white image of the same part: light on ${(100 * header.lit_share).toFixed(1)} % of the pixels`;
  element('white-figure').hidden = false;
});
