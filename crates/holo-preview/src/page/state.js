// The state of the page, which goes to the server whole. At most two looks of a moving camera are on their way, so that one
// is drawn while the other is shown; what changes meanwhile goes with the next one.

// A camera that has not moved for this long stands still.
const SETTLE_MS = 180;

const state = {
  scene: '',
  camera: '',
  settings: {},
  lens: null,
};

// What the server said about the newest image.
const seen = { hello: null, scene: null, view: null, details: null, strip: null, depth: null };

const look = { number: 0, onItsWay: [], isDirty: false, isHeld: false, moving: false, timer: 0, shown: 0, settled: 0 };

const stageSize = () => {
  const box = document.getElementById('stage').getBoundingClientRect();
  const ratio = look.moving ? 1 : Math.min(window.devicePixelRatio || 1, 2);
  // While the camera moves the image is small, so that it follows.
  const most = look.moving ? 480 : 720;
  const scale = Math.min(1, most / Math.max(box.width * ratio, 1));
  return [Math.max(16, Math.round(box.width * ratio * scale)), Math.max(16, Math.round(box.height * ratio * scale))];
};

const lookMessage = (kind) => ({
  kind,
  number: look.number,
  scene: state.scene,
  camera: state.camera,
  settings: state.settings,
  size: stageSize(),
  moving: look.moving,
  lens: state.lens,
});

const sendLook = () => {
  if (!isOpen()) return;
  if (look.onItsWay.length >= (look.moving ? 2 : 1)) {
    look.isDirty = true;
    return;
  }
  look.isDirty = false;
  look.number += 1;
  look.onItsWay.push(look.number);
  send(lookMessage('look'));
};

// The answer to a look has come, or it failed.
const answered = (number) => {
  // Older ones will not be answered any more.
  look.onItsWay = look.onItsWay.filter((other) => other > number);
  if (look.isDirty) sendLook();
};

// Something changed; `moving`: more will follow at once.
const changed = (moving) => {
  clearTimeout(look.timer);
  look.moving = moving;
  // A hand on the image is not done yet.
  if (moving && !look.isHeld) look.timer = setTimeout(() => changed(false), SETTLE_MS);
  sendLook();
};

const setSetting = (key, text) => {
  if (text === '' || text === null) delete state.settings[key];
  else state.settings[key] = String(text);
};

const short = (value) => String(Number(value.toPrecision(6)));
const pointText = (point) => point.map(short).join(',');
