// `window.holo`: what a test or a curious person may ask the page and tell it. All pairs are [column, row].

const prepareSurface = (ready) => {
  const box = () => stage.getBoundingClientRect();
  window.holo = Object.freeze({
    // Resolves when the first picture is on the screen, with the seconds since the page was opened.
    ready,
    // Resolves when the picture is whole: nothing moves, all views are averaged.
    settled,
    // What is shown.
    state: () => ({
      mode: state.mode, view: [...state.view], refocus: state.refocus, disparity: state.disparity, smooth: state.smooth,
      views, lenses, centralView, range: { ...range }, pixelsPerView, renderer: renderer?.name ?? null,
      distance: depthOfDisparity(state.disparity), modes: MODES.filter(available),
      tiles: renderer?.raw?.tile ?? null,
    }),
    // What the corner tells of the pixel under the pointer; null outside the picture.
    readout,
    // The colour on the screen at a place in CSS pixels of the window, as [red, green, blue].
    colourAt: (x, y) => renderer.pixel(devicePosition({ clientX: x, clientY: y })),
    // Where a pixel of the shown picture has its centre, in CSS pixels of the window.
    placeOf: (column, row) => {
      const { scale, offset } = frame();
      const { left, top, width, height } = box();
      const [x, y] = [column, row].map((value, axis) => offset[axis] + (value + 0.5) * scale);
      return [left + (x * width) / stage.width, top + (y * height) / stage.height];
    },
    // Chooses a mode, a view, a disparity (null: no refocus); zooms so that a part of the picture fills the screen.
    show,
    moveTo,
    setDisparity: (disparity) => (disparity === null ? change({ refocus: false }) : setDisparity(disparity)),
    zoomTo: (column, row, columns, rows) => {
      zoomTo(column, row, columns, rows);
      moved();
    },
    reset,
  });
};
