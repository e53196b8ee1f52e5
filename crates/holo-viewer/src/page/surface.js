// `window.holo`: the interface for tests and scripts. All pairs are [column, row].

const prepareSurface = (ready) => {
  const box = () => stage.getBoundingClientRect();
  window.holo = Object.freeze({
    // Resolves when the first image is on the screen, with the seconds since the page was opened.
    ready,
    // Resolves when the image is shown with full quality: all views are averaged.
    settled,
    // The state of the page.
    state: () => ({
      mode: state.mode, view: [...state.view], refocus: state.refocus, disparity: state.disparity, smooth: state.smooth,
      views, lenses, centralView, range: { ...range }, pixelsPerView, renderer: renderer?.name ?? null,
      distance: depthOfDisparity(state.disparity), modes: MODES.filter(available),
      tiles: renderer?.raw?.tile ?? null,
    }),
    // The values of the pixel under the pointer; null outside the image.
    readout,
    // The color on the screen at a position in CSS pixels of the window, as [red, green, blue].
    colorAt: (x, y) => renderer.pixel(devicePosition({ clientX: x, clientY: y })),
    // The center of a pixel of the shown image, in CSS pixels of the window.
    placeOf: (column, row) => {
      const { scale, offset } = frame();
      const { left, top, width, height } = box();
      const [x, y] = [column, row].map((value, axis) => offset[axis] + (value + 0.5) * scale);
      return [left + (x * width) / stage.width, top + (y * height) / stage.height];
    },
    // Chooses a mode, a view, a disparity (null: no refocus); zooms so that a part of the image fills the screen.
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
