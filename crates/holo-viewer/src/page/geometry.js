// Counts, and which pixel of a shown picture is which lens and view. Pairs are [column, row].

const views = [numbers.views.columns, numbers.views.rows];
const lenses = [numbers.lenses.columns, numbers.lenses.rows];
const rawSize = [views[0] * lenses[0], views[1] * lenses[1]];

// A real view for even counts too.
const centralView = [Math.floor(views[0] / 2), Math.floor(views[1] / 2)];

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// The picture that a mode shows, in its own pixels.
const sheetSize = (mode) => (mode === 'raw' || mode === 'views' ? rawSize : lenses);

// How many pixels of a picture lie between the lines that are drawn on it.
const sheetPeriod = (mode) => (mode === 'raw' ? views : mode === 'views' ? lenses : [1, 1]);

// Lens and view of a picture's pixel, or null outside. `view` is the one that mode `view` shows.
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

// Eq. 3 both ways, for the disparity between horizontal neighbours.
const rig = numbers.rig;
const knowsMetres = rig !== null && rig.scale_m_px.x > 0;

const depthOfDisparity = (disparity) => {
  if (!knowsMetres) return NaN;
  const scale = rig.scale_m_px.x;
  const focus = rig.focus_distance_m;
  if (focus === null) return scale / disparity;
  if (rig.orthographic) return (focus * (scale - disparity * focus)) / scale;
  return (scale / (disparity * focus + scale)) * focus;
};

const disparityOfDepth = (depth) => {
  if (!knowsMetres) return NaN;
  const scale = rig.scale_m_px.x;
  const focus = rig.focus_distance_m;
  if (focus === null) return scale / depth;
  if (rig.orthographic) return (scale * ((focus - depth) / focus)) / focus;
  if (depth === Infinity) return -scale / focus;
  return (scale * ((focus - depth) / depth)) / focus;
};

// How far a point moves between vertical neighbours, for each pixel between horizontal ones.
const verticalPerHorizontal = knowsMetres ? rig.scale_m_px.y / rig.scale_m_px.x : 1;
