// The toolbar: it shows the state, and its controls change the state.

const element = (id) => document.getElementById(id);
const slider = element('disparity');
const modeButtons = [...document.querySelectorAll('[data-mode]')];

const reset = () => {
  for (const mode of MODES) delete frames[mode];
  change({ view: [...centralView], refocus: false, disparity: 0 });
  updateZoom();
  redraw();
};

const updateZoom = () => {
  // The pixel under the pointer has changed.
  updateReadout();
  // Per CSS pixel, so that it means the same on every screen.
  const scale = frame().scale / ratio();
  element('zoom').textContent = scale < 10 ? `${digits(100 * scale, 3)} %` : `${digits(scale, 3)} \u00d7`;
};

const focusText = () => {
  const depth = depthOfDisparity(state.disparity);
  if (!hasMetricRig) return pixels(state.disparity);
  // The last steps of the slider may be beyond infinity.
  const distance = depth === Infinity || depth < 0 ? '\u221e' : meters(depth);
  return `${pixels(state.disparity)}  \u00b7  ${distance}`;
};

const updateControls = () => {
  const viewing = state.mode === 'view';
  for (const button of modeButtons) {
    const chosen = button.dataset.mode === state.mode;
    button.setAttribute('aria-checked', chosen);
    // One tab stop for the group, as for radio buttons.
    button.tabIndex = chosen ? 0 : -1;
    button.disabled = !available(button.dataset.mode);
  }
  const refocusing = viewing && state.refocus;
  element('refocus').setAttribute('aria-pressed', refocusing);
  element('refocus').disabled = slider.disabled = views[0] * views[1] === 1;
  document.querySelector('.focus').classList.toggle('on', refocusing);
  slider.value = state.disparity;
  slider.setAttribute('aria-valuetext', focusText());
  element('distance').textContent = focusText();
  element('smooth').setAttribute('aria-pressed', state.smooth);
  stage.classList.toggle('turn', viewing && views[0] * views[1] > 1);
  stage.setAttribute('aria-label', viewing
    ? `${refocusing ? `All views focused at ${focusText()}` : `View ${state.view.join(', ')} of ${views.join(' x ')}`}`
    : { raw: 'Raw image', views: 'Grid of views', depth: 'Depth map', error: 'Error map' }[state.mode]);
  updateZoom();
};

const prepareControls = () => {
  element('title').textContent = numbers.title;
  element('title').title = `${numbers.title}: ${views.join(' x ')} views of ${lenses.join(' x ')} px`;
  Object.assign(slider, { min: range.low, max: range.high, step: range.step });
  // The center of the thumb is between 8 px from the start and 8 px from the end; the background image is 2 px wide.
  const zero = -range.low / (range.high - range.low);
  slider.style.setProperty('--zero', `calc(7px + ${zero} * (100% - 14px))`);
  for (const button of modeButtons) {
    button.addEventListener('click', () => show(button.dataset.mode));
    button.addEventListener('keydown', (event) => {
      const by = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
      if (!by) return;
      event.preventDefault();
      event.stopPropagation();
      const usable = modeButtons.filter((other) => !other.disabled);
      const next = usable[(usable.indexOf(button) + by + usable.length) % usable.length];
      next.focus();
      next.click();
    });
  }
  const toggleRefocus = () => {
    if (state.mode !== 'view') change({ mode: 'view', refocus: true });
    else change({ refocus: !state.refocus });
  };
  const toggleHelp = () => {
    element('help').hidden = !element('help').hidden;
    element('keys').setAttribute('aria-expanded', !element('help').hidden);
  };
  slider.addEventListener('input', () => {
    show('view');
    setDisparity(Number(slider.value));
  });
  element('refocus').addEventListener('click', toggleRefocus);
  element('smooth').addEventListener('click', () => change({ smooth: !state.smooth }));
  element('reset').addEventListener('click', reset);
  element('keys').addEventListener('click', toggleHelp);

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const step = (steps) => {
    show('view');
    setDisparity(state.disparity + steps * range.step * 5);
  };
  const others = {
    '+': () => step(1), '=': () => step(1), '-': () => step(-1), 0: reset,
    f: toggleRefocus, i: () => change({ smooth: !state.smooth }), '?': toggleHelp,
    Escape: () => element('help').hidden || toggleHelp(),
  };
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    if (arrow) {
      if (event.target === slider) return;
      moveTo(state.view[0] + arrow[0], state.view[1] + arrow[1]);
    } else if (MODES[event.key - 1]) {
      show(MODES[event.key - 1]);
    } else if (others[event.key.toLowerCase()] ?? others[event.key]) {
      if ((event.key === '+' || event.key === '-' || event.key === '=' || event.key.toLowerCase() === 'f') && views[0] * views[1] === 1) return;
      (others[event.key.toLowerCase()] ?? others[event.key])();
    } else {
      return;
    }
    event.preventDefault();
  });
  onChange((keys) => keys.some((key) => key !== 'pointer') && updateControls());
  updateControls();
};
