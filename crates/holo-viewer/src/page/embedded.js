// What `holo view` put into the page: numbers as JSON, everything else as blocks of base64.

const numbers = JSON.parse(document.getElementById('numbers').textContent);

const decodeBase64 = (text) => {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let index = 0; index < bytes.length; index += 1) bytes[index] = characters.charCodeAt(index);
  return bytes;
};

// Every block is dropped as soon as it is decoded: text and bytes of a large picture are never there at once.
const takeBlocks = (name) => {
  const parts = [];
  for (const element of document.querySelectorAll(`script[data-block="${name}"]`)) {
    parts.push(new Blob([decodeBase64(element.textContent)]));
    element.remove();
  }
  return parts;
};

const takePicture = () => new Blob(takeBlocks('picture'), { type: 'image/png' });

// A map of the central view, row by row, or null. The bytes are little-endian whatever this machine is.
const takeMap = async (name) => {
  const parts = takeBlocks(name);
  if (parts.length === 0) return null;
  const bytes = new DataView(await new Blob(parts).arrayBuffer());
  return Float32Array.from({ length: bytes.byteLength / 4 }, (_, index) => bytes.getFloat32(4 * index, true));
};
