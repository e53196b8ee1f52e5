// Scheduling of drawing: immediately with reduced quality, and with full quality when the state no longer changes.

// Number of views of a refocused image of reduced quality, and time of a step at full quality.
const QUICK_VIEWS = 36;
const STEP_MILLISECONDS = 30;
const PAUSE_MILLISECONDS = 120;
const MOST_TAPS = 8;

let renderer = null;
let requested = 0;
let pause = 0;
// Counts changes of the refocused image: work on an older one stops.
let generation = 0;
let whole = true;
let stale = true;
let calm = true;
const waiting = [];

// Every `stride`-th view, including the current one.
const viewsApart = (stride) => {
  const first = state.view.map((value) => value % stride);
  const taken = first.map((value, axis) => Math.floor((views[axis] - 1 - value) / stride) + 1);
  const disparity = [state.disparity, state.disparity * verticalPerHorizontal];
  return { center: state.view, first, taken, stride, disparity };
};

const refocusQuickly = () => {
  const chosen = viewsApart(Math.ceil(Math.sqrt((views[0] * views[1]) / QUICK_VIEWS)));
  renderer.addViews(chosen, 0, chosen.taken[0] * chosen.taken[1]);
  renderer.showSum();
  stale = false;
  whole = chosen.stride === 1;
};

const addAllViews = async () => {
  const mine = generation;
  const chosen = viewsApart(1);
  const total = chosen.taken[0] * chosen.taken[1];
  let count = 4;
  for (let start = 0; start < total;) {
    const begun = performance.now();
    count = Math.min(count, total - start);
    renderer.addViews(chosen, start, count);
    start += count;
    await renderer.finished();
    if (mine !== generation) return;
    const took = performance.now() - begun;
    count = Math.max(1, Math.round(count * clamp(STEP_MILLISECONDS / Math.max(took, 1), 0.5, 4)));
  }
  renderer.showSum();
  whole = true;
  draw();
};

// There is one sum: a second request during the work waits for the same work.
let work = { generation: -1, done: null };

const refocusWholly = () => {
  if (work.generation !== generation) work = { generation, done: addAllViews() };
  return work.done;
};

const draw = () => {
  const refocused = state.mode === 'view' && state.refocus;
  const { scale, offset } = frame();
  // The mean over the image pixels of one screen pixel; of at most two by two during changes.
  const wanted = clamp(Math.ceil(1 / scale - 1e-6), 1, MOST_TAPS);
  renderer.draw({
    kind: refocused ? 'focused' : state.mode, mode: state.mode, view: state.view, scale, offset,
    taps: calm ? wanted : Math.min(wanted, 2), smooth: state.smooth && state.mode === 'view' && scale > 1,
  });
};

const settle = async () => {
  pause = 0;
  calm = true;
  draw();
  if (state.mode === 'view' && state.refocus && !whole) {
    const mine = generation;
    await refocusWholly();
    if (mine !== generation) return;
  }
  await renderer.finished();
  if (!requested && !pause) for (const done of waiting.splice(0)) done();
};

const drawNow = () => {
  requested = 0;
  calm = false;
  if (stale && state.mode === 'view' && state.refocus) refocusQuickly();
  draw();
  clearTimeout(pause);
  // The full quality is drawn at once where something waits for it.
  pause = setTimeout(settle, waiting.length ? 0 : PAUSE_MILLISECONDS);
};

// Draws at the next animation frame.
const redraw = () => {
  if (renderer && !requested) requested = requestAnimationFrame(drawNow);
};

onChange((keys) => {
  if (!renderer || !keys.some((key) => key !== 'pointer')) return;
  if (keys.some((key) => key === 'view' || key === 'disparity')) {
    generation += 1;
    stale = true;
  }
  redraw();
});

// Resolves when the image is shown with full quality.
const settled = () => new Promise((done) => {
  waiting.push(done);
  redraw();
});
