// Counts, and the microlens and view of each pixel of a shown image. Pairs are [column, row].

const views = [numbers.views.columns, numbers.views.rows];
const lenses = [numbers.lenses.columns, numbers.lenses.rows];
const rawSize = [views[0] * lenses[0], views[1] * lenses[1]];

// A real view for even counts too.
const centralView = [Math.floor(views[0] / 2), Math.floor(views[1] / 2)];

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// The size of the image of a mode, in its pixels.
const sheetSize = (mode) => (mode === 'raw' || mode === 'views' ? rawSize : lenses);

// Number of image pixels between the grid lines of a mode.
const sheetPeriod = (mode) => (mode === 'raw' ? views : mode === 'views' ? lenses : [1, 1]);

// Microlens and view of an image pixel, or null outside. `view` is the one that mode `view` shows.
const placeInLightField = (mode, [column, row], view) => {
  const size = sheetSize(mode);
  if (!(column >= 0 && row >= 0 && column < size[0] && row < size[1])) return null;
  const pixel = [Math.floor(column), Math.floor(row)];
  const divided = (period) => [
    pixel.map((value, axis) => Math.floor(value / period[axis])),
    pixel.map((value, axis) => value % period[axis]),
  ];
  if (mode === 'raw') {
    const [lens, within] = divided(views);
    return { lens, view: within };
  }
  if (mode === 'views') {
    const [which, within] = divided(lenses);
    return { lens: within, view: which };
  }
  return { lens: pixel, view: mode === 'view' ? view : centralView };
};

// Eq. 3 in both directions, for the disparity between horizontally adjacent views.
const rig = numbers.rig;
const hasMetricRig = rig !== null && rig.scale_m_px.x > 0;

const depthOfDisparity = (disparity) => {
  if (!hasMetricRig) return NaN;
  const scale = rig.scale_m_px.x;
  const focus = rig.focus_distance_m;
  if (focus === null) return scale / disparity;
  if (rig.orthographic) return (focus * (scale - disparity * focus)) / scale;
  return (scale / (disparity * focus + scale)) * focus;
};

const disparityOfDepth = (depth) => {
  if (!hasMetricRig) return NaN;
  const scale = rig.scale_m_px.x;
  const focus = rig.focus_distance_m;
  if (focus === null) return scale / depth;
  if (rig.orthographic) return (scale * ((focus - depth) / focus)) / focus;
  if (depth === Infinity) return -scale / focus;
  return (scale * ((focus - depth) / depth)) / focus;
};

// Ratio of the disparities between vertically and horizontally adjacent views.
const verticalPerHorizontal = hasMetricRig ? rig.scale_m_px.y / rig.scale_m_px.x : 1;
