// The camera's place: orbit around a point, sideways, nearer, farther. The first place is that of the scene's camera.

const add = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
const scaled = (a, factor) => a.map((value) => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scaled(a, 1 / Math.max(Math.hypot(...a), 1e-300));

const place = { eye: null, target: null };

// The distance to the middle of the image: by depth, else to the middle of the scene.
const distanceAhead = () => {
  const view = seen.view;
  const depth = depthAt(0.5, 0.5);
  if (Number.isFinite(depth) && depth > 0) return depth;
  const bounds = seen.scene?.bounds;
  if (!bounds) return 1;
  const middle = scaled(add(bounds[0], bounds[1]), 0.5);
  const along = -dot(add(middle, view.eye, -1), view.back);
  return along > 0 ? along : Math.max(Math.hypot(...add(bounds[1], bounds[0], -1)), 1e-3);
};

// Begins to place the camera where it stands.
const takePlace = () => {
  if (place.eye || !seen.view) return place.eye !== null;
  place.eye = [...seen.view.eye];
  place.target = add(seen.view.eye, seen.view.back, -distanceAhead());
  return true;
};

const usePlace = () => {
  setSetting('eye', pointText(place.eye));
  setSetting('target', pointText(place.target));
  delete state.settings['fit-object'];
  delete state.settings.camera;
  // A pose has an upward direction of its own.
  if (fields.pose.value !== '') setSetting('up', seen.hello.given.up ?? '');
  fields.pose.value = '';
  changed(true);
};

const leavePlace = () => {
  place.eye = null;
  place.target = null;
  for (const key of ['eye', 'target', 'up', 'fit-object']) delete state.settings[key];
  fields.pose.value = '';
  changed(false);
};

const UP = [0, 1, 0];

// Turns the camera around its target by angles in radians.
const orbit = (around, over) => {
  if (!takePlace()) return;
  const arm = add(place.eye, place.target, -1);
  const length = Math.max(Math.hypot(...arm), 1e-9);
  let azimuth = Math.atan2(arm[0], arm[2]) - around;
  let height = Math.asin(Math.max(-1, Math.min(1, arm[1] / length))) + over;
  height = Math.max(-1.54, Math.min(1.54, height));
  const flat = Math.cos(height);
  place.eye = add(place.target, [Math.sin(azimuth) * flat, Math.sin(height), Math.cos(azimuth) * flat], length);
  usePlace();
};

// Moves nearer by a factor.
const dolly = (factor) => {
  if (!takePlace()) return;
  const arm = add(place.eye, place.target, -1);
  place.eye = add(place.target, arm, factor);
  usePlace();
};

// Moves sideways by parts of the width of the image.
const pan = (right, up) => {
  if (!takePlace()) return;
  const arm = add(place.eye, place.target, -1);
  const length = Math.hypot(...arm);
  const width = 2 * length * Math.tan(((seen.view.fov_deg ?? 45) * Math.PI) / 360);
  const x = unit(cross(UP, arm));
  const y = unit(cross(arm, x));
  const way = add(scaled(x, -right * width), y, up * width);
  place.eye = add(place.eye, way);
  place.target = add(place.target, way);
  usePlace();
};
