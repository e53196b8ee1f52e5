// Images of any size as textures: equal tiles, each a layer of a texture array.

// For tests: `#tile=64` sets the size of tiles, `#canvas` selects the renderer without WebGL.
const addressOptions = new URLSearchParams(location.hash.slice(1));

// Rows that are uploaded at a time, so that copies of the browser stay small.
const BAND_ROWS = 512;

class TiledTexture {
  constructor(gl, size, internalFormat) {
    const largest = Number(addressOptions.get('tile')) || gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const counts = size.map((side) => Math.ceil(side / largest));
    this.gl = gl;
    this.size = size;
    this.tile = size.map((side, axis) => Math.ceil(side / counts[axis]));
    this.columns = counts[0];
    const layers = counts[0] * counts[1];
    if (layers > gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS)) throw new Error('the image has too many tiles');
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, side, gl.NEAREST);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, internalFormat, this.tile[0], this.tile[1], layers);
    if (gl.getError() !== gl.NO_ERROR) throw new Error('the image does not fit into graphics memory');
  }

  // `source` is an image bitmap, or values row by row.
  async fill(source, format, type) {
    const { gl, tile, columns } = this;
    const typed = ArrayBuffer.isView(source);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    for (let top = 0; top < this.size[1]; top += tile[1]) {
      for (let left = 0; left < this.size[0]; left += tile[0]) {
        const layer = (top / tile[1]) * columns + left / tile[0];
        const width = Math.min(tile[0], this.size[0] - left);
        const bottom = Math.min(top + tile[1], this.size[1]);
        for (let row = top; row < bottom; row += BAND_ROWS) {
          const rows = Math.min(BAND_ROWS, bottom - row);
          gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
          gl.pixelStorei(gl.UNPACK_ROW_LENGTH, typed ? this.size[0] : 0);
          gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, typed ? left : 0);
          gl.pixelStorei(gl.UNPACK_SKIP_ROWS, typed ? row : 0);
          // Not every browser applies the offsets to an image bitmap, so it is cropped first.
          const whole = left === 0 && width === this.size[0] && rows === this.size[1];
          const part = typed || whole ? source : await createImageBitmap(source, left, row, width, rows);
          const place = [gl.TEXTURE_2D_ARRAY, 0, 0, row - top, layer, width, rows, 1, format, type, part];
          gl.texSubImage3D(...place);
          if (part !== source) part.close();
        }
      }
    }
    if (gl.getError() !== gl.NO_ERROR) throw new Error('the image could not be uploaded to the graphics card');
  }
}
