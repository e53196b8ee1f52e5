// The readout of the pixel under the pointer, and the legend of a map.

const readoutElement = document.getElementById('readout');
const legendElement = document.getElementById('legend');

// All values of the pixel under the pointer; null outside the image. Depth and disparity are those of the central view at
// that microlens: the page contains no others.
const readout = () => {
  const place = pointed();
  if (!place) return null;
  const at = place.lens[1] * lenses[0] + place.lens[0];
  const value = (map) => (map ? map[at] : NaN);
  const disparity = maps.disparity ? value(maps.disparity) : disparityOfDepth(value(maps.depth));
  const depth = maps.depth ? value(maps.depth) : depthOfDisparity(value(maps.disparity));
  return {
    ...place, depth, disparity, estimate: value(maps.estimate), error: value(maps.error),
    central: place.view.every((index, axis) => index === centralView[axis]),
  };
};

const padded = (pair, counts) => pair.map((value, axis) => String(value).padStart(String(counts[axis] - 1).length, '\u2007')).join(', ');

const updateReadout = () => {
  const found = readout();
  const pair = (name, counts) => (found ? padded(found[name], counts) : '\u2013');
  const rows = [['lens', pair('lens', lenses)]];
  const averaged = state.mode === 'view' && state.refocus;
  rows.push(['view', averaged ? `all ${views[0]} \u00d7 ${views[1]}` : found ? pair('view', views) : padded(state.view, views)]);
  if (maps.depth || (maps.disparity && hasMetricRig)) rows.push(['depth', found ? meters(found.depth) : '\u2013']);
  if (maps.disparity || (maps.depth && hasMetricRig)) rows.push(['disparity', found ? pixels(found.disparity) : '\u2013']);
  if (maps.estimate) rows.push(['estimate', found ? pixels(found.estimate) : '\u2013']);
  if (maps.error) rows.push(['error', found ? pixels(found.error) : '\u2013']);
  const parts = rows.flatMap(([name, value]) => {
    const [term, definition] = [document.createElement('dt'), document.createElement('dd')];
    term.textContent = name;
    definition.textContent = value;
    return [term, definition];
  });
  const elsewhere = rows.length > 2 && (found ? !found.central : state.view.some((value, axis) => value !== centralView[axis]));
  if (elsewhere && !averaged) {
    const note = document.createElement('dd');
    note.className = 'note';
    note.textContent = `depth: of the central view ${centralView.join(', ')}`;
    parts.push(note);
  }
  readoutElement.replaceChildren(...parts);
};

const updateLegend = () => {
  const scale = scales[state.mode];
  legendElement.hidden = !scale;
  if (!scale) return;
  const [caption, bar, ticks, note] = legendElement.children;
  caption.textContent = scale.caption;
  note.textContent = scale.note;
  bar.getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(scale.colors), 256, 1), 0, 0);
  const labels = [0, 0.5, 1].map((part) => {
    const tick = document.createElement('span');
    tick.style.left = `${100 * part}%`;
    tick.textContent = scale.label(scale.low + part * (scale.high - scale.low));
    return tick;
  });
  ticks.classList.toggle('single', !labels[0].textContent.includes('\n'));
  ticks.replaceChildren(...labels);
};

onChange(updateReadout);
onChange((keys) => keys.includes('mode') && updateLegend());
