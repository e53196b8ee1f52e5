// The controls: each changes settings, as text, under the names that the command line has.

const make = (name, attributes = {}, ...children) => {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
};

const rows = {};

// A row of the panel: a label, one or two controls. `key` names it for tests.
const row = (panel, key, label, ...controls) => {
  const made = make('div', { class: 'row', 'data-key': key }, make('span', {}, label), ...controls);
  element(panel).append(made);
  rows[key] = made;
  for (const control of controls) if (!control.getAttribute('aria-label')) control.setAttribute('aria-label', label);
  return made;
};

const choice = (options) => {
  const made = make('select');
  for (const [value, text] of options) made.append(make('option', { value }, text));
  return made;
};

// A text field that sets a setting when it is left or confirmed.
const field = (key, hint) => {
  const made = make('input', { type: 'text', placeholder: hint, spellcheck: 'false', autocomplete: 'off' });
  made.addEventListener('change', () => {
    setSetting(key, made.value.trim());
    changed(false);
  });
  made.dataset.setting = key;
  return made;
};

// A slider with the field of its value. `to` and `from` map the position, 0 to 1, to a value and back.
const slider = (key, text, to, from) => {
  const made = make('input', { type: 'range', min: 0, max: 1, step: 0.001 });
  made.addEventListener('input', () => {
    text.value = to(Number(made.value));
    setSetting(key, text.value);
    changed(true);
  });
  // Where nothing is set, the slider stands at what the program chose.
  made.follow = (chosen) => {
    const value = text.value === '' ? chosen : Number(text.value);
    if (Number.isFinite(value)) made.value = from(value);
  };
  made.follow(0);
  sliders[key] = made;
  return made;
};

const sliders = {};

const followSliders = () => {
  sliders['fov-deg'].follow(seen.view?.fov_deg ?? 45);
  sliders.exposure.follow(seen.view?.exposure_ev ?? 0);
  sliders.sky.follow(0);
  sliders.frame.follow(parseInt(fields.frame.value, 10) || 0);
};

const logarithmic = (low, high) => [
  (part) => Number((low * (high / low) ** part).toPrecision(3)),
  (value) => Math.log(Math.max(value, low) / low) / Math.log(high / low),
];
const linear = (low, high, digits) => [
  (part) => Number((low + (high - low) * part).toFixed(digits)),
  (value) => (value - low) / (high - low),
];

const fields = {};
const ofRig = ['views', 'sensor', 'spacing', 'fov-deg'];

const SPACINGS = { 'f-number': 'f-number', disparity: 'disparities', 'baseline-m': 'baseline' };

const cameraControls = () => {
  fields.camera = choice([['', 'Rig of views']]);
  fields.camera.addEventListener('change', () => {
    state.camera = fields.camera.value;
    showRows();
    changed(false);
  });
  fields.camera.classList.add('whole');
  row('camera', 'camera', 'Camera', fields.camera);

  fields.pose = choice([['', 'anywhere']]);
  fields.pose.classList.add('whole');
  row('camera', 'pose', 'Stands at', fields.pose).hidden = true;

  fields.views = field('views', '100');
  fields.views.classList.add('whole');
  row('camera', 'views', 'Views', fields.views);

  fields.sensor = choice([['8k', '8K, 7952 x 5304'], ['4k', '4K'], ['hd', 'HD'], ['uhd8k', 'UHD 8K'], ['', 'pixels of a view']]);
  fields.lenses = field('lenses', '512x512');
  fields.sensor.addEventListener('change', () => {
    const isOther = fields.sensor.value === '';
    setSetting('sensor', isOther || fields.sensor.value === '8k' ? '' : fields.sensor.value);
    if (isOther && !state.settings.lenses) setSetting('lenses', (fields.lenses.value = '512x512'));
    if (!isOther) setSetting('lenses', (fields.lenses.value = ''));
    showRows();
    changed(false);
  });
  row('camera', 'sensor', 'Sensor', fields.sensor, fields.lenses);

  fields.spacing = choice(Object.entries(SPACINGS));
  fields.spacingValue = make('input', { type: 'text', spellcheck: 'false', autocomplete: 'off' });
  const setSpacing = () => {
    for (const key of Object.keys(SPACINGS)) delete state.settings[key];
    setSetting(fields.spacing.value, fields.spacingValue.value.trim());
    if (fields.spacing.value === 'disparity') setSetting('focus-m', (fields.focus.value = ''));
    showRows();
  };
  fields.spacing.addEventListener('change', () => {
    const defaults = { 'f-number': '', disparity: '-1,1', 'baseline-m': seen.details?.baseline_m?.toPrecision(3) ?? '0.001' };
    fields.spacingValue.value = defaults[fields.spacing.value];
    setSpacing();
    changed(false);
  });
  fields.spacingValue.addEventListener('change', () => {
    setSpacing();
    changed(false);
  });
  row('camera', 'spacing', 'Views apart by', fields.spacing, fields.spacingValue);
  const [toNumber, fromNumber] = logarithmic(1, 32);
  fields.aperture = make('input', { type: 'range', min: 0, max: 1, step: 0.001, value: fromNumber(5), class: 'whole' });
  fields.aperture.addEventListener('input', () => {
    fields.spacingValue.value = toNumber(Number(fields.aperture.value));
    setSpacing();
    changed(true);
  });
  row('camera', 'aperture', '', fields.aperture);
  rows.aperture.querySelector('input').setAttribute('aria-label', 'f-number');
  fields.disparityWidth = make('input', { type: 'range', min: 0, max: 1, step: 0.001, value: 0.5, class: 'whole' });
  const [toWidth] = logarithmic(0.1, 10);
  fields.disparityWidth.addEventListener('input', () => {
    const width = toWidth(Number(fields.disparityWidth.value));
    fields.spacingValue.value = `-${width},${width}`;
    setSpacing();
    changed(true);
  });
  row('camera', 'disparity-width', '', fields.disparityWidth);
  rows['disparity-width'].querySelector('input').setAttribute('aria-label', 'Largest disparity');

  fields.focus = field('focus-m', 'auto');
  const auto = make('button', { type: 'button' }, 'Auto');
  auto.addEventListener('click', () => {
    setSetting('focus-m', (fields.focus.value = ''));
    changed(false);
  });
  row('camera', 'focus-m', 'Focus, m', fields.focus, auto);

  fields.frame = field('frame', 'at rest');
  const lastFrame = () => Math.max((seen.scene?.frames ?? 1) - 1, 1);
  const toFrame = (part) => Math.round(part * lastFrame());
  row('camera', 'frame', 'Frame, A-B', slider('frame', fields.frame, toFrame, (frame) => frame / lastFrame()), fields.frame);

  fields.fov = field('fov-deg', 'scene');
  row('camera', 'fov-deg', 'Angle of view', slider('fov-deg', fields.fov, ...linear(5, 120, 1)), fields.fov);
};

// The poses that the program named. Who moves the camera leaves them.
const fillPoses = (poses) => {
  rows.pose.hidden = poses.length === 0;
  poses.forEach(({ name }, number) => fields.pose.append(make('option', { value: number }, name)));
  fields.pose.addEventListener('change', () => {
    const pose = poses[fields.pose.value];
    if (!pose) return leavePlace();
    [place.eye, place.target] = [null, null];
    for (const key of ['fit-object', 'camera']) delete state.settings[key];
    for (const [key, text] of Object.entries(pose.settings)) if (text !== null) setSetting(key, text);
    fields.fov.value = state.settings['fov-deg'] ?? '';
    changed(false);
  });
};

const lightControls = () => {
  fields.exposure = field('exposure', 'auto');
  row('light', 'exposure', 'Exposure, EV', slider('exposure', fields.exposure, ...linear(-8, 8, 2)), fields.exposure);
  fields.sky = field('sky', 'auto');
  row('light', 'sky', 'Sky', slider('sky', fields.sky, ...linear(0, 2, 2)), fields.sky);
  fields.ground = make('input', { type: 'checkbox' });
  fields.ground.addEventListener('change', () => {
    setSetting('ground', fields.ground.checked ? 'true' : '');
    changed(false);
  });
  row('light', 'ground', 'Ground', fields.ground);
  fields.backdrop = field('backdrop', 'what is there');
  const picker = make('input', { type: 'color', value: '#ffffff', 'aria-label': 'Color of the backdrop' });
  picker.addEventListener('input', () => {
    setSetting('backdrop', (fields.backdrop.value = linearColor(picker.value)));
    changed(true);
  });
  row('light', 'backdrop', 'Backdrop', fields.backdrop, picker);
};

// Linear R,G,B of a color of CSS, #rrggbb.
const linearColor = (text) => {
  const channels = [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);
  const linear = channels.map((code) => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4));
  return linear.map((value) => Number(value.toPrecision(3))).join(',');
};

const QUALITIES = {
  clean: { denoise: 'views', 'target-error': '2%' },
  draft: { spp: '1/16', denoise: 'views' },
  plain: {},
  reference: { spp: '1024', denoise: 'off', reuse: 'off' },
};

const qualityControls = () => {
  fields.quality = choice([
    ['clean', 'clean: about 2 % noise'],
    ['draft', 'draft: fastest image'],
    ['plain', 'samples a pixel:'],
    ['reference', 'reference: 1024 samples'],
  ]);
  fields.spp = field('spp', '16');
  fields.quality.addEventListener('change', () => {
    for (const set of Object.values(QUALITIES)) for (const key of Object.keys(set)) delete state.settings[key];
    for (const [key, text] of Object.entries(QUALITIES[fields.quality.value])) setSetting(key, text);
    showRows();
    changed(false);
  });
  row('quality', 'quality', 'Quality', fields.quality, fields.spp);
};

// Rows that the camera has.
const showRows = () => {
  const isRig = state.camera === '';
  for (const key of ofRig) rows[key].hidden = !isRig;
  rows.frame.hidden = !seen.scene?.frames;
  fields.lenses.hidden = fields.sensor.value !== '';
  rows.aperture.hidden = !isRig || fields.spacing.value !== 'f-number';
  rows['disparity-width'].hidden = !isRig || fields.spacing.value !== 'disparity';
  fields.spp.hidden = fields.quality.value !== 'plain';
  fields.spacingValue.placeholder = fields.spacing.value === 'f-number' ? '5' : '';
};

// Shows the settings that the program was started with.
const takeSettings = (given) => {
  state.settings = { ...given };
  for (const control of document.querySelectorAll('[data-setting]')) control.value = given[control.dataset.setting] ?? '';
  fields.sensor.value = given.lenses ? '' : (given.sensor ?? '8k');
  fields.spacing.value = Object.keys(SPACINGS).find((key) => given[key]) ?? 'f-number';
  fields.spacingValue.value = given[fields.spacing.value] ?? '';
  fields.ground.checked = given.ground === 'true';
  const isSet = (set) => Object.entries(set).every(([key, text]) => given[key] === text);
  const quality = Object.entries(QUALITIES).find(([name, set]) => name !== 'plain' && isSet(set));
  const sampled = ['spp', 'denoise', 'target-error'].some((key) => given[key]);
  fields.quality.value = quality?.[0] ?? (sampled ? 'plain' : 'clean');
  if (fields.quality.value === 'clean') Object.assign(state.settings, QUALITIES.clean);
  showRows();
};

const setFocus = (depth) => {
  if (!Number.isFinite(depth)) return;
  if (fields.spacing.value === 'disparity') {
    fields.spacing.value = 'baseline-m';
    delete state.settings.disparity;
    fields.spacingValue.value = seen.details.baseline_m.toPrecision(4);
    setSetting('baseline-m', fields.spacingValue.value);
  }
  fields.focus.value = Number(depth.toPrecision(4));
  setSetting('focus-m', fields.focus.value);
  showRows();
  changed(false);
};
