// The small grid of views, which shows the current one; a press changes the view.

const inset = document.getElementById('inset');
const INSET_SIDE = 112;

const insetView = () => {
  if (state.mode === 'depth' || state.mode === 'error') return centralView;
  if (state.mode === 'view') return state.view;
  return pointed()?.view ?? state.view;
};

const drawInset = () => {
  // One view needs no grid.
  inset.hidden = views[0] * views[1] === 1;
  if (inset.hidden) return;
  const cell = (INSET_SIDE - 16) / Math.max(...views);
  const [width, height] = views.map((count) => Math.max(count * cell, 6) + 16);
  const dense = ratio();
  inset.style.width = `${width}px`;
  inset.style.height = `${height}px`;
  inset.width = Math.round(width * dense);
  inset.height = Math.round(height * dense);
  const context = inset.getContext('2d');
  context.setTransform(dense, 0, 0, dense, 8 * dense, 8 * dense);
  const gap = cell > 4 ? 1 : 0;
  context.fillStyle = state.mode === 'view' && state.refocus ? '#6b5630' : '#3c3c40';
  if (gap === 0) context.fillRect(0, 0, views[0] * cell, views[1] * cell);
  for (let row = 0; gap > 0 && row < views[1]; row += 1) {
    for (let column = 0; column < views[0]; column += 1) context.fillRect(column * cell, row * cell, cell - gap, cell - gap);
  }
  const side = Math.max(cell - gap, 4);
  const corner = insetView().map((index) => (index + 0.5) * cell - gap / 2 - side / 2);
  context.fillStyle = '#f2b84b';
  context.fillRect(...corner, side, side);
};

const insetMove = (event) => {
  if (event.type === 'pointerdown') inset.setPointerCapture(event.pointerId);
  else if (!inset.hasPointerCapture(event.pointerId)) return;
  const box = inset.getBoundingClientRect();
  const cell = (INSET_SIDE - 16) / Math.max(...views);
  show('view');
  moveTo(Math.floor((event.clientX - box.left - 8) / cell), Math.floor((event.clientY - box.top - 8) / cell));
};

inset.addEventListener('pointerdown', insetMove);
inset.addEventListener('pointermove', insetMove);
onChange((keys) => (keys.includes('pointer') ? state.mode === 'raw' || state.mode === 'views' : true) && drawInset());
