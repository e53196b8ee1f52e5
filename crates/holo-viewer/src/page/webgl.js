// The renderer with WebGL 2: the raw image is one texture, and every image is looked up in it.

const KINDS = { view: 0, raw: 1, views: 2, depth: 3, error: 3, focused: 4 };

class WebglRenderer {
  // Throws if WebGL 2 or a required part of it is missing.
  constructor(canvas) {
    const options = { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true };
    const gl = canvas.getContext('webgl2', options);
    if (!gl) throw new Error('there is no WebGL 2');
    if (!gl.getExtension('EXT_color_buffer_float')) throw new Error('the graphics card cannot add up floats');
    if (Math.max(...lenses) > gl.getParameter(gl.MAX_TEXTURE_SIZE)) throw new Error('a view is larger than a texture');
    this.gl = gl;
    this.name = 'webgl2';
    this.show = this.program(SHOW);
    this.refocus = this.program(REFOCUS);
    this.maps = {};
    // Two alternate for the sum, one is shown.
    this.targets = Array.from({ length: 3 }, () => this.target());
    this.shown = 0;
    gl.bindVertexArray(gl.createVertexArray());
  }

  program(fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const places = {};
    for (let index = 0; index < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); index += 1) {
      const { name } = gl.getActiveUniform(program, index);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  // A float texture of the size of a view, for a sum of views.
  target() {
    const { gl } = this;
    const texture = this.plain(gl.RGBA32F, ...lenses);
    const buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { texture, buffer };
  }

  plain(format, width, height) {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    return texture;
  }

  async setImage(bitmap) {
    const { gl } = this;
    this.raw = new TiledTexture(gl, rawSize, gl.RGBA8);
    await this.raw.fill(bitmap, gl.RGBA, gl.UNSIGNED_BYTE);
  }

  async setMap(name, { values, colors }) {
    const { gl } = this;
    const map = new TiledTexture(gl, lenses, gl.R32F);
    await map.fill(values.map((value) => (Number.isFinite(value) ? value : -3e38)), gl.RED, gl.FLOAT);
    const palette = this.plain(gl.RGBA8, 256, 1);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
    gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, 0);
    gl.pixelStorei(gl.UNPACK_SKIP_ROWS, 0);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 256, 1, gl.RGBA, gl.UNSIGNED_BYTE, colors);
    this.maps[name] = { map, palette };
  }

  bind(unit, kind, texture, place) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, texture);
    gl.uniform1i(place, unit);
    gl.activeTexture(gl.TEXTURE0);
  }

  // Sets the uniforms of both programs.
  begin({ program, places }) {
    const { gl } = this;
    gl.useProgram(program);
    gl.uniform2i(places.views, ...views);
    gl.uniform2i(places.lenses, ...lenses);
    gl.uniform3i(places.rawTiles, ...this.raw.tile, this.raw.columns);
    this.bind(0, gl.TEXTURE_2D_ARRAY, this.raw.texture, places.raw);
    return places;
  }

  // Adds the views `start` to `start + count` of a grid of views to the sum; `start` 0 begins a new sum.
  addViews({ center, first, taken, stride, disparity }, start, count) {
    const { gl } = this;
    const others = [0, 1, 2].filter((index) => index !== this.shown);
    const [from, into] = this.sum === others[0] ? others : [others[1], others[0]];
    const places = this.begin(this.refocus);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[into].buffer);
    gl.viewport(0, 0, ...lenses);
    this.bind(1, gl.TEXTURE_2D, this.targets[from].texture, places.before);
    gl.uniform2i(places.center, ...center);
    gl.uniform2i(places.first, ...first);
    gl.uniform2i(places.taken, ...taken);
    gl.uniform1i(places.stride, stride);
    gl.uniform1i(places.start, start);
    gl.uniform1i(places.count, count);
    gl.uniform2f(places.disparity, ...disparity);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.sum = into;
  }

  showSum() {
    this.shown = this.sum;
  }

  // Resolves when the graphics card has finished all commands.
  async finished() {
    const { gl } = this;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((done) => setTimeout(done, 2));
    gl.deleteSync(fence);
  }

  draw({ kind, mode, view, scale, offset, taps, smooth }) {
    const { gl } = this;
    const places = this.begin(this.show);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.uniform1i(places.kind, KINDS[kind]);
    gl.uniform2i(places.view, ...view);
    gl.uniform2i(places.size, ...sheetSize(mode));
    gl.uniform2i(places.period, ...sheetPeriod(mode));
    gl.uniform2f(places.offset, ...offset);
    gl.uniform1f(places.scale, scale);
    gl.uniform1f(places.height, gl.drawingBufferHeight);
    gl.uniform1i(places.taps, taps);
    gl.uniform1i(places.smoothly, smooth ? 1 : 0);
    gl.uniform3f(places.ground, ...GROUND);
    this.bind(1, gl.TEXTURE_2D, this.targets[this.shown].texture, places.focused);
    const { map, palette } = this.maps[mode] ?? {};
    // A sampler needs a texture of its type even if the program does not read it.
    this.bind(2, gl.TEXTURE_2D_ARRAY, (map ?? this.raw).texture, places.map);
    this.bind(3, gl.TEXTURE_2D, palette ?? this.targets[this.shown].texture, places.colors);
    if (map) {
      gl.uniform3i(places.mapTiles, ...map.tile, map.columns);
      gl.uniform2f(places.range, scales[mode].low, scales[mode].high);
    }
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // The color on the screen, in device pixels from the top left corner.
  pixel([x, y]) {
    const { gl } = this;
    const bytes = new Uint8Array(4);
    gl.readPixels(Math.floor(x), gl.drawingBufferHeight - 1 - Math.floor(y), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return [...bytes.slice(0, 3)];
  }
}
