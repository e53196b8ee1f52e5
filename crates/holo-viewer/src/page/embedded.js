// The data in the page: numbers as JSON, image and maps as blocks of base64.

const numbers = JSON.parse(document.getElementById('numbers').textContent);

const decodeBase64 = (text) => {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let index = 0; index < bytes.length; index += 1) bytes[index] = characters.charCodeAt(index);
  return bytes;
};

// Every block is removed as soon as it is decoded, so that text and bytes of a large image are not in memory together.
const takeBlocks = (name) => {
  const parts = [];
  for (const element of document.querySelectorAll(`script[data-block="${name}"]`)) {
    parts.push(new Blob([decodeBase64(element.textContent)]));
    element.remove();
  }
  return parts;
};

const takeImage = () => new Blob(takeBlocks('image'), { type: 'image/png' });

// A map of the central view, row by row, or null. The bytes are little-endian whatever this machine is.
const takeMap = async (name) => {
  const parts = takeBlocks(name);
  if (parts.length === 0) return null;
  const bytes = new DataView(await new Blob(parts).arrayBuffer());
  return Float32Array.from({ length: bytes.byteLength / 4 }, (_, index) => bytes.getFloat32(4 * index, true));
};
