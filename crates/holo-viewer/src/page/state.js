// What the person has chosen. Everything that is shown follows from it; who shows something asks to be told of changes.

const MODES = ['view', 'raw', 'views', 'depth', 'error'];

const state = {
  mode: 'view',
  view: [...centralView],
  refocus: false,
  disparity: 0,
  smooth: false,
  // Where the pointer is on the picture, in device pixels, or null.
  pointer: null,
};

// Maps of the central view, once they are read.
const maps = { depth: null, disparity: null, estimate: null, error: null };

const listeners = [];
const onChange = (listener) => listeners.push(listener);

// Changes some of the state. Listeners hear which keys.
const change = (changes) => {
  const keys = Object.keys(changes).filter((key) => state[key] !== changes[key]);
  if (keys.length === 0) return;
  Object.assign(state, changes);
  for (const listener of listeners) listener(keys);
};

const moveTo = (column, row) => {
  const view = [clamp(column, 0, views[0] - 1), clamp(row, 0, views[1] - 1)];
  if (view[0] !== state.view[0] || view[1] !== state.view[1]) change({ view });
};

const available = (mode) => {
  if (mode === 'depth') return (maps.depth ?? maps.disparity ?? maps.estimate) !== null;
  return mode !== 'error' || maps.error !== null;
};

const show = (mode) => {
  if (available(mode)) change({ mode });
};

// What the slider reaches: the scene's own disparities with some room, or two pixels either way.
const range = { low: -2, high: 2, step: 0.01 };

const chooseRange = () => {
  const map = maps.disparity ?? maps.estimate;
  let [low, high] = [Infinity, -Infinity];
  for (const value of map ?? []) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return;
  const room = Math.max(0.15 * (high - low), 1e-3);
  range.low = Math.min(low - room, 0);
  range.high = Math.max(high + room, 0);
  // A power of ten, so that the slider rests on short numbers; 200 to 2000 of them.
  range.step = 10 ** Math.floor(Math.log10((range.high - range.low) / 200));
  range.low = Math.floor(range.low / range.step) * range.step;
  range.high = Math.ceil(range.high / range.step) * range.step;
};

const setDisparity = (disparity) => {
  const steps = Math.round(clamp(disparity, range.low, range.high) / range.step);
  // Through text: 3 * 0.1 is not 0.3.
  change({ refocus: true, disparity: Number((steps * range.step).toPrecision(10)) });
};
