// Position of the image on the screen: device pixel = offset + scale * image pixel. Every mode has its own.

const stage = document.getElementById('image');

// Maximum number of device pixels of an image pixel, unless a small image needs more to fill the screen.
const MAX_SCALE = 256;
const MARGIN = 0.94;

// The color around the image, as in style.css.
const GROUND = [20 / 255, 20 / 255, 21 / 255];

const frames = {};
const ratio = () => window.devicePixelRatio || 1;

const fitScale = (mode) => {
  const size = sheetSize(mode);
  return Math.min(stage.width / size[0], stage.height / size[1]) * MARGIN;
};

const largestScale = (mode) => Math.max(MAX_SCALE, 4 * fitScale(mode));

const fitted = (mode) => {
  const scale = fitScale(mode);
  return { scale, offset: sheetSize(mode).map((side, axis) => ([stage.width, stage.height][axis] - side * scale) / 2) };
};

// A mode whose zoom was not changed follows the size of the window.
const frame = () => (frames[state.mode] ??= fitted(state.mode));

// Device pixels of an event.
const devicePosition = (event) => {
  const box = stage.getBoundingClientRect();
  return [(event.clientX - box.left) * (stage.width / box.width), (event.clientY - box.top) * (stage.height / box.height)];
};

const toSheet = (position) => {
  const { scale, offset } = frame();
  return position.map((value, axis) => (value - offset[axis]) / scale);
};

// Keeps a part of the image on the screen.
const keepInSight = (next) => {
  const size = sheetSize(state.mode);
  next.offset = next.offset.map((value, axis) => {
    const side = [stage.width, stage.height][axis];
    const shown = Math.min(80 * ratio(), size[axis] * next.scale);
    return clamp(value, shown - size[axis] * next.scale, side - shown);
  });
  return next;
};

// Lens and view under the pointer, or null.
const pointed = () => state.pointer && placeInLightField(state.mode, toSheet(state.pointer), state.view);

const pan = (x, y) => {
  const { scale, offset } = frame();
  frames[state.mode] = keepInSight({ scale, offset: [offset[0] + x, offset[1] + y], touched: true });
};

// Zooms around `position`.
const zoomAt = (position, factor) => {
  const { scale, offset } = frame();
  const next = clamp(scale * factor, Math.min(fitScale(state.mode), 1) / 2, largestScale(state.mode));
  const moved = offset.map((value, axis) => position[axis] - ((position[axis] - value) / scale) * next);
  frames[state.mode] = keepInSight({ scale: next, offset: moved, touched: true });
};

// Fills most of the screen with a part of the image.
const zoomTo = (column, row, columns, rows) => {
  const scale = clamp(Math.min(stage.width / columns, stage.height / rows) * 0.8, 1e-3, largestScale(state.mode));
  const center = [column + columns / 2, row + rows / 2];
  frames[state.mode] = {
    scale, offset: center.map((value, axis) => [stage.width, stage.height][axis] / 2 - value * scale), touched: true,
  };
};

// Adapts to the size of the window. Returns whether it changed.
const resize = () => {
  const box = stage.parentElement.getBoundingClientRect();
  const [width, height] = [box.width, box.height].map((side) => Math.max(1, Math.round(side * ratio())));
  if (stage.width === width && stage.height === height) return false;
  stage.width = width;
  stage.height = height;
  for (const mode of MODES) if (!frames[mode]?.touched) delete frames[mode];
  return true;
};
