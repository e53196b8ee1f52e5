// The state that the user has chosen. Everything that is shown depends on it; parts of the page register for changes.

const MODES = ['view', 'raw', 'views', 'depth', 'error'];

const state = {
  mode: 'view',
  view: [...centralView],
  refocus: false,
  disparity: 0,
  smooth: true,
  // Position of the pointer on the image in device pixels, or null.
  pointer: null,
};

// Maps of the central view, once they are read.
const maps = { depth: null, disparity: null, estimate: null, error: null };

const listeners = [];
const onChange = (listener) => listeners.push(listener);

// Changes the state. Listeners receive the changed keys.
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

// Range of the slider: the disparities of the scene with a margin, or two pixels in both directions.
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
  // A power of ten, so that values are short numbers: 200 to 2000 steps.
  range.step = 10 ** Math.floor(Math.log10((range.high - range.low) / 200));
  range.low = Math.floor(range.low / range.step) * range.step;
  range.high = Math.ceil(range.high / range.step) * range.step;
};

const setDisparity = (disparity) => {
  const steps = Math.round(clamp(disparity, range.low, range.high) / range.step);
  // By way of text, because 3 * 0.1 is not 0.3.
  change({ refocus: true, disparity: Number((steps * range.step).toPrecision(10)) });
};
