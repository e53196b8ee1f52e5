// Start: from the data to the first image.

const message = document.getElementById('message');

const say = (text) => {
  message.textContent = text;
  message.hidden = text === '';
};

const filled = async (made, bitmap) => {
  await made.setImage(bitmap);
  for (const name of Object.keys(scales)) await made.setMap(name, scales[name]);
  return made;
};

// WebGL if it can hold the image, else the processor.
const chooseRenderer = async (bitmap) => {
  if (!addressOptions.has('canvas')) {
    try {
      return await filled(new WebglRenderer(stage), bitmap);
    } catch (why) {
      console.info(`holo: drawing without WebGL: ${why.message}`);
    }
  }
  return filled(new CanvasRenderer(), bitmap);
};

stage.addEventListener('webglcontextlost', () => say('The graphics card has lost the image; reload the page'));

const start = async () => {
  for (const name of ['depth', 'disparity', 'estimate']) maps[name] = await takeMap(name);
  if (maps.estimate && maps.disparity) {
    maps.error = maps.estimate.map((value, index) => value - maps.disparity[index]);
  }
  const options = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
  let bitmap = null;
  try {
    bitmap = await createImageBitmap(takeImage(), options);
  } catch (why) {
    throw new Error(`this browser cannot decode the image of ${rawSize.join(' x ')} pixels (${why.message})`);
  }
  if (bitmap.width !== rawSize[0] || bitmap.height !== rawSize[1]) throw new Error('the image does not have the size that the page states');
  chooseRange();
  prepareScales();
  resize();
  renderer = await chooseRenderer(bitmap);
  bitmap.close();
  prepareControls();
  updateReadout();
  drawInset();
  new ResizeObserver(() => {
    if (resize()) {
      updateZoom();
      drawInset();
      drawNow();
    }
  }).observe(stage.parentElement);
  say('');
  await settled();
  return performance.now() / 1000;
};

prepareSurface(start().catch((why) => {
  say(`Cannot show this light field: ${why.message}`);
  throw why;
}));
