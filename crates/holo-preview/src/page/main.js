// Pointers, keys, messages; and the start.

// What tests read.
const counters = { views: 0, settled: 0, rendered: 0, errors: [] };

const showMessage = (text) => {
  element('message').textContent = text;
  element('message').hidden = text === '';
};

const CLICK_PIXELS = 4;
const pointers = new Map();
let drag = null;

const middleOf = () => {
  const all = [...pointers.values()];
  return [0, 1].map((axis) => all.reduce((sum, at) => sum + at[axis], 0) / all.length);
};
const spreadOf = () => {
  const [a, b] = [...pointers.values()];
  return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 1;
};

image.addEventListener('pointerdown', (event) => {
  image.setPointerCapture(event.pointerId);
  image.focus({ preventScroll: true });
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  const slides = event.shiftKey || event.button !== 0;
  drag = { at: middleOf(), spread: spreadOf(), way: 0, slides };
  look.isHeld = true;
  image.classList.add('dragging');
});

image.addEventListener('pointermove', (event) => {
  readout(event);
  if (!pointers.has(event.pointerId) || !drag) return;
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  const at = middleOf();
  const [x, y] = [at[0] - drag.at[0], at[1] - drag.at[1]];
  drag.way += Math.hypot(x, y);
  drag.at = at;
  if (pointers.size > 1) {
    const spread = spreadOf();
    dolly(drag.spread / Math.max(spread, 1));
    drag.spread = spread;
    return;
  }
  if (drag.way < CLICK_PIXELS) return;
  const width = Math.max(shown.frame.width, 1);
  if (drag.slides) pan(x / width, y / width);
  else orbit((x / width) * Math.PI, (y / width) * Math.PI);
});

const release = (event) => {
  pointers.delete(event.pointerId);
  image.classList.toggle('dragging', pointers.size > 0);
  if (drag && pointers.size === 0) {
    look.isHeld = false;
    if (look.moving) changed(false);
    if (event.type === 'pointerup' && drag.way < CLICK_PIXELS && event.button === 0) {
      const at = placeInImage(event);
      if (at) setFocus(depthAt(...at));
    }
    drag = null;
  }
};
image.addEventListener('pointerup', release);
image.addEventListener('pointercancel', release);
image.addEventListener('contextmenu', (event) => event.preventDefault());

image.addEventListener('dblclick', (event) => {
  const at = placeInImage(event);
  const lenses = seen.details?.lenses;
  if (!at || !lenses) return;
  state.lens = [0, 1].map((axis) => Math.floor(at[axis] * lenses[axis]));
  changed(false);
});

image.addEventListener('wheel', (event) => {
  event.preventDefault();
  dolly(1.0015 ** Math.max(-200, Math.min(200, event.deltaY)));
}, { passive: false });

const readout = (event) => {
  const at = placeInImage(event);
  const depth = at ? depthAt(...at) : NaN;
  const list = element('readout');
  list.replaceChildren();
  if (Number.isNaN(depth)) return;
  const lines = Number.isFinite(depth)
    ? [['depth', `${depth.toPrecision(4)} m`], ['disparity', `${pixelText(disparityOf(depth))} px`]]
    : [['depth', 'nothing is hit']];
  for (const [name, value] of lines) list.append(make('dt', {}, name), make('dd', {}, value));
};
image.addEventListener('pointerleave', () => element('readout').replaceChildren());

const KEYS = {
  ArrowLeft: () => orbit(-0.08, 0),
  ArrowRight: () => orbit(0.08, 0),
  ArrowUp: () => orbit(0, 0.06),
  ArrowDown: () => orbit(0, -0.06),
  '+': () => dolly(0.92),
  '=': () => dolly(0.92),
  '-': () => dolly(1.08),
  f: () => setFocus(depthAt(0.5, 0.5)),
  g: () => toggle('gallery'),
  r: () => element('render').click(),
  0: () => leavePlace(),
  '?': () => toggle('help'),
  Escape: () => {
    toggle('gallery', false);
    toggle('help', false);
  },
};

document.addEventListener('keydown', (event) => {
  const inField = /^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(event.target.tagName);
  if (event.ctrlKey || event.metaKey || event.altKey || (inField && event.key !== 'Escape')) return;
  const action = KEYS[event.key];
  if (!action) return;
  event.preventDefault();
  action();
});

const BUTTONS = { gallery: 'gallery-button', help: 'keys' };
let hasThumbnails = false;

const toggle = (id, open = element(id).hidden) => {
  element(id).hidden = !open;
  element(BUTTONS[id]).setAttribute('aria-expanded', String(open));
  if (id === 'gallery' && open && !hasThumbnails) {
    hasThumbnails = true;
    send({ kind: 'gallery' });
  }
};
for (const [id, button] of Object.entries(BUTTONS)) element(button).addEventListener('click', () => toggle(id));
element('home').addEventListener('click', leavePlace);

const openScene = (name) => {
  state.scene = name;
  state.lens = null;
  setSetting('frame', (fields.frame.value = ''));
  [seen.details, seen.depth] = [null, null];
  toggle('gallery', false);
  leavePlace();
};

const fillGallery = (scenes) => {
  element('gallery').replaceChildren();
  for (const { name, purpose } of scenes) {
    const button = make('button', { type: 'button', 'data-scene': name }, make('div', { class: 'blank' }), make('b', {}, name), purpose);
    button.addEventListener('click', () => openScene(name));
    element('gallery').append(button);
  }
};

on('thumbnail', (header, bytes) => {
  const button = document.querySelector(`[data-scene="${CSS.escape(header.name)}"]`);
  const thumbnail = make('img', { alt: '' });
  thumbnail.src = URL.createObjectURL(new Blob([bytes], { type: 'image/jpeg' }));
  button?.firstChild.replaceWith(thumbnail);
});

document.addEventListener('dragover', (event) => event.preventDefault());
document.addEventListener('drop', async (event) => {
  event.preventDefault();
  const file = event.dataTransfer?.files[0];
  if (file) await openFile(file);
});

const openFile = async (file) => {
  if (!/\.glb$/i.test(file.name)) {
    showMessage(`${file.name}: a scene is one file, .glb; convert .gltf with its files to .glb first`);
    return;
  }
  const bytes = await file.arrayBuffer();
  send({ kind: 'drop', name: file.name });
  send(bytes);
  openScene('');
};

on('hello', (header) => {
  const isFirst = seen.hello === null;
  seen.hello = header;
  if (isFirst) {
    for (const { name, description } of header.cameras) fields.camera.append(make('option', { value: name }, description));
    if (header.camera) fields.camera.append(make('option', { value: 'own' }, header.camera));
    state.camera = fields.camera.value = header.camera ? 'own' : '';
    fillPoses(header.poses);
    takeSettings(header.given);
    fillGallery(header.gallery);
    if (!header.scene) {
      state.scene = header.gallery[0].name;
      toggle('gallery', true);
    }
  }
  // A page that comes back has another studio, which draws what the last one did not.
  if (!isFirst && hasThumbnails && document.querySelector('#gallery .blank')) send({ kind: 'gallery' });
  element('render').disabled = !header.renders;
  look.onItsWay = [];
  // A small image first, as while the camera moves.
  changed(true);
});

on('scene', (header) => {
  seen.scene = header;
  element('title').textContent = header.name;
  document.title = `${header.name} - holo preview`;
  showRows();
  const notes = header.notes.filter((note) => note.startsWith('warning'));
  element('about').textContent = [`${header.triangles.toLocaleString()} triangles`, ...notes].join('; ');
});

const duration = (seconds) => {
  if (seconds < 60) return `${rounded(Math.max(seconds, 0.1))} s`;
  return seconds < 5400 ? `${rounded(seconds / 60)} min` : `${rounded(seconds / 3600)} h`;
};
const rounded = (value) => (value < 100 ? Number(value.toPrecision(2)) : Math.round(value));
const size = (bytes) => (bytes < 1e9 ? `${rounded(bytes / 1e6)} MB` : `${rounded(bytes / 1e9)} GB`);

on('details', (header, bytes) => {
  seen.details = header;
  seen.depth = header.map ? new Float32Array(bytes) : null;
  const { seconds, bytes: disk, pixels } = header.estimate;
  const what = header.views
    ? `${header.views.join(' x ')} views of ${header.lenses.join(' x ')} px`
    : `${(pixels / 1e6).toPrecision(3)} million pixels, sees ${header.angles_deg.map((angle) => angle.toFixed(1)).join(' x ')} degrees`;
  const each = header.frames > 1 ? ` for each of ${header.frames} frames` : '';
  element('estimate').textContent = `${what}: about ${duration(seconds)} and ${size(disk)}${each}`;
  element('warnings').replaceChildren(...header.warnings.map((text) => make('li', {}, text)));
  element('command').textContent = header.command;
  element('python').textContent = header.python;
  element('readout').replaceChildren();
  drawMap();
  drawLens();
  followSliders();
});

on('settled', (header) => {
  look.settled = header.number;
  counters.settled += 1;
  showMessage('');
});

on('error', (header) => {
  counters.errors.push(header.text);
  showMessage(header.text);
  answered(header.number);
});

element('render').addEventListener('click', () => {
  element('stop').disabled = false;
  element('render').disabled = true;
  element('progress').hidden = false;
  element('progress').value = 0;
  send(lookMessage('render'));
});
element('stop').addEventListener('click', () => send({ kind: 'stop' }));

const ended = () => {
  element('stop').disabled = true;
  element('render').disabled = !seen.hello.renders;
  element('progress').hidden = true;
};

on('progress', (header) => {
  element('progress').value = header.done / Math.max(header.total, 1);
  element('status').textContent = `rendering: ${header.stage}`;
});

on('rendered', (header) => {
  counters.rendered += 1;
  const line = make('li', {});
  const address = `${header.path}?token=${token}`;
  line.append(make('a', { href: address, target: '_blank', rel: 'noopener' }, `Look at the ${header.stage} render`), ' ');
  // A click asked for it, so that the browser lets it open.
  if (header.stage === 'full') window.open(address, 'holo-view', 'noopener');
  line.append(`${duration(header.seconds)}, in ${header.folder}`);
  element('finished').prepend(line);
  if (header.stage === 'full') ended();
});

on('ended', (header) => {
  showMessage(header.text === 'stopped' ? '' : header.text);
  ended();
});

for (const button of document.querySelectorAll('.copy')) {
  button.addEventListener('click', async () => {
    await navigator.clipboard.writeText(element(button.dataset.of).textContent);
    button.textContent = 'Copied';
    setTimeout(() => (button.textContent = 'Copy'), 1200);
  });
}

connection.onLost = () => {
  element('status').textContent = 'the program does not answer; trying again';
};

new ResizeObserver(() => {
  drawView();
  if (isOpen()) changed(true);
}).observe(element('stage'));

cameraControls();
lightControls();
qualityControls();
showRows();
window.holoPreview = { state, seen, look, counters, place, openFile, drop: () => connection.socket.close() };
connect();
