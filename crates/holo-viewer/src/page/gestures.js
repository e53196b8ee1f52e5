// Pointers on the image: drag, pan, pinch, wheel, click.

// A drag by this many CSS pixels changes the view by one.
const pixelsPerView = clamp(480 / Math.max(...views), 4, 48);

// A pointer that moved less than this is a click.
const CLICK_PIXELS = 4;

const pointers = new Map();
let drag = null;

const middle = () => {
  const all = [...pointers.values()];
  return [0, 1].map((axis) => all.reduce((sum, place) => sum + place[axis], 0) / all.length);
};

const spread = () => {
  const [a, b] = [...pointers.values()];
  return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 1;
};

const point = (event) => change({ pointer: devicePosition(event) });

const moved = () => {
  updateZoom();
  redraw();
};

const focusAt = (position) => {
  const place = placeInLightField('view', toSheet(position), state.view);
  const map = maps.disparity ?? maps.estimate;
  const value = place && map ? map[place.lens[1] * lenses[0] + place.lens[0]] : NaN;
  if (Number.isFinite(value)) setDisparity(value);
};

stage.addEventListener('pointerdown', (event) => {
  stage.setPointerCapture(event.pointerId);
  stage.focus({ preventScroll: true });
  pointers.set(event.pointerId, devicePosition(event));
  point(event);
  const turns = state.mode === 'view' && event.button === 0 && !event.shiftKey && pointers.size === 1;
  drag = { turns, from: [event.clientX, event.clientY], view: [...state.view], middle: middle(), spread: spread(), far: false };
  stage.classList.toggle('dragging', pointers.size === 1);
});

stage.addEventListener('pointermove', (event) => {
  if (!pointers.has(event.pointerId)) {
    point(event);
    return;
  }
  pointers.set(event.pointerId, devicePosition(event));
  const way = [event.clientX - drag.from[0], event.clientY - drag.from[1]];
  if (Math.hypot(...way) >= CLICK_PIXELS || pointers.size > 1) drag.far = true;
  if (drag.turns && pointers.size === 1) {
    moveTo(...drag.view.map((start, axis) => start + Math.trunc(way[axis] / pixelsPerView)));
  } else {
    // One pointer pans; two also zoom around their center.
    const [at, size] = [middle(), spread()];
    pan(at[0] - drag.middle[0], at[1] - drag.middle[1]);
    if (pointers.size > 1) zoomAt(at, size / Math.max(drag.spread, 1));
    Object.assign(drag, { middle: at, spread: size });
    moved();
  }
  point(event);
});

const release = (event) => {
  if (!pointers.delete(event.pointerId)) return;
  const clicked = event.type === 'pointerup' && !drag.far && drag.turns && pointers.size === 0;
  if (clicked && state.refocus) focusAt(devicePosition(event));
  // The remaining pointer of a pinch pans, but does not change the view.
  if (pointers.size > 0) Object.assign(drag, { turns: false, middle: middle(), spread: spread() });
  stage.classList.toggle('dragging', pointers.size === 1);
};

stage.addEventListener('pointerup', release);
stage.addEventListener('pointercancel', release);
stage.addEventListener('pointerleave', () => pointers.size === 0 && change({ pointer: null }));
stage.addEventListener('contextmenu', (event) => event.preventDefault());

stage.addEventListener('wheel', (event) => {
  event.preventDefault();
  // Some mice report lines or pages.
  const pixelsTurned = event.deltaY * [1, 18, 400][event.deltaMode];
  zoomAt(devicePosition(event), Math.exp(-clamp(pixelsTurned, -240, 240) * (event.ctrlKey ? 0.01 : 0.0022)));
  point(event);
  moved();
}, { passive: false });

// From a pixel of a view to its elemental image, and from a pixel of an elemental image to its view.
stage.addEventListener('dblclick', (event) => {
  const position = toSheet(devicePosition(event));
  const place = placeInLightField(state.mode, position, state.view);
  if (!place) return;
  if (state.mode === 'view' && !state.refocus) {
    change({ mode: 'raw' });
    zoomTo(place.lens[0] * views[0], place.lens[1] * views[1], ...views);
  } else if (state.mode === 'raw' || state.mode === 'views') {
    change({ mode: 'view', refocus: false, view: place.view });
  }
  point(event);
  moved();
});
