// Streams of the npm package meshoptimizer: mode filter stride count compressed decoded, in hexadecimal.
// node streams.mjs small > meshopt_streams.txt, with the package meshoptimizer installed
import { MeshoptEncoder as E, MeshoptDecoder as D } from 'meshoptimizer';
await E.ready; await D.ready;
let seed = 1; const rnd = () => (seed = (seed * 1103515245 + 12345) >>> 0) / 2 ** 32;
const big = process.argv[2] == 'big';
const out = [];
function emit(mode, filter, stride, count, data) {
  const decoded = new Uint8Array(stride * count);
  D.decodeGltfBuffer(decoded, count, stride, data, mode, filter);
  out.push([mode, filter, stride, count, Buffer.from(data).toString('hex'), Buffer.from(decoded).toString('hex')].join(' '));
}
function smooth(stride, count, kind) {
  const b = new Uint8Array(stride * count), v = new DataView(b.buffer);
  for (let i = 0; i < count; i++) for (let k = 0; k < stride; k += 4) {
    const s = (k / 4) % 5;
    if (kind == 'noise') v.setUint32(i * stride + k, rnd() * 2 ** 32, true);
    else if (s == 0) v.setFloat32(i * stride + k, Math.sin(i / 9 + k), true);
    else if (s == 1) { v.setInt16(i * stride + k, 900 * Math.sin(i / 5 + k) + 5 * rnd(), true); v.setInt16(i * stride + k + 2, 3 * i, true); }
    else if (s == 2) v.setUint32(i * stride + k, 0, true);
    else if (s == 3) for (let j = 0; j < 4; j++) v.setUint8(i * stride + k + j, 128 + 20 * Math.sin(i / 3 + j) + (rnd() < 0.1 ? 99 : 0));
    else v.setUint32(i * stride + k, i / 7, true);
  }
  return b;
}
const cases = big ? [] : [[4, 1], [4, 17], [20, 37], [8, 270], [256, 17]];
if (big) for (let k = 0; k < 60; k++) cases.push([4 * (1 + Math.floor(rnd() * 64)), 1 + Math.floor(rnd() * 700)]);
for (const [stride, count] of cases) for (const kind of big ? ['smooth', 'noise'] : ['smooth']) {
  if (!big && stride > 100) { emit('ATTRIBUTES', 'NONE', stride, count, E.encodeVertexBufferLevel(smooth(stride, count, 'x').map((x, i) => i % 256 > 16 ? 7 : x), count, stride, 2, 1)); continue; }
  const b = smooth(stride, count, kind);
  for (const [level, version] of big ? [[0, 0], [2, 0], [0, 1], [1, 1], [2, 1], [3, 1]] : [[2, 0], [3, 1]]) emit('ATTRIBUTES', 'NONE', stride, count, E.encodeVertexBufferLevel(b, count, stride, level, version));
}
const n = big ? 900 : 12, vec = () => { let v; do v = [0, 0, 0, 0].map(() => 2 * rnd() - 1); while (Math.hypot(...v) < 0.1); return v; };
for (let rep = 0; rep < (big ? 14 : 1); rep++) {
  const f = new Float32Array(4 * n);
  for (let i = 0; i < n; i++) { const v = vec(), l = Math.hypot(v[0], v[1], v[2]); f.set([v[0] / l, v[1] / l, v[2] / l, rnd()], 4 * i); }
  for (const [s, bits] of [[4, big ? 2 + rep % 7 : 8], [8, big ? 2 + rep : 12]]) emit('ATTRIBUTES', 'OCTAHEDRAL', s, n, E.encodeVertexBufferLevel(E.encodeFilterOct(f, n, s, bits), n, s, 2, rep % 2));
  for (let i = 0; i < n; i++) { const v = vec(), l = Math.hypot(...v); f.set(v.map(x => x / l), 4 * i); }
  emit('ATTRIBUTES', 'QUATERNION', 8, n, E.encodeVertexBufferLevel(E.encodeFilterQuat(f, n, 8, big ? 4 + rep % 13 : 12), n, 8, 2, rep % 2));
  for (let i = 0; i < 4 * n; i++) f[i] = (2 * rnd() - 1) * 10 ** Math.floor(9 * rnd() - 5);
  for (const mode of ['Separate', 'SharedVector', 'SharedComponent', 'Clamped']) if (big || mode == 'SharedVector') emit('ATTRIBUTES', 'EXPONENTIAL', 16, n, E.encodeVertexBufferLevel(E.encodeFilterExp(f, n, 16, big ? 3 + rep : 15, mode), n, 16, 2, rep % 2));
  for (let i = 0; i < 4 * n; i++) f[i] = rnd();
  for (const [s, bits] of [[4, big ? 2 + rep % 7 : 8], [8, big ? 2 + rep : 12]]) emit('ATTRIBUTES', 'COLOR', s, n, E.encodeVertexBufferLevel(E.encodeFilterColor(f, n, s, bits), n, s, 2, 1));
}
for (const [w, h] of big ? [[5, 4], [40, 33], [100, 3], [61, 60]] : [[3, 3]]) {
  let t = [];
  for (let y = 0; y < h; y++) for (let x = 0; x < w; x++) { const a = y * (w + 1) + x, b = a + w + 1; t.push(a, a + 1, b, b, a + 1, b + 1); }
  if (big) for (let i = 0; i < 300; i++) t.push(Math.floor(rnd() * 999), Math.floor(rnd() * 9), Math.floor(rnd() * 99999 % 65000));
  else t.push(0, 17, 40, 3, 900, 2, 900, 41, 3);
  let idx = new Uint32Array(t);
  for (const optimized of [false, true]) {
    if (optimized) { idx = idx.slice(); const [remap] = E.reorderMesh(idx, true, false); }
    for (const s of [2, 4]) {
      const src = s == 2 ? Uint16Array.from(idx) : idx, bytes = new Uint8Array(src.buffer, src.byteOffset, src.byteLength);
      if (!big && s == 2 && optimized) continue;
      emit('TRIANGLES', 'NONE', s, idx.length, E.encodeIndexBuffer(bytes, idx.length, s));
      if (big || !optimized) { const m = s == 4 && !big ? 20 : idx.length; emit('INDICES', 'NONE', s, m, E.encodeIndexSequence(bytes.subarray(0, m * s), m, s)); }
    }
  }
}
process.stdout.write(out.join('\n') + '\n');
