// source.glb: a torus with normals, texture coordinates and colors, and a tilted, smaller copy below another node.
import fs from 'node:fs';
const R = 24, r = 12;
const P = [], N = [], T = [], C = [], I = [];
for (let i = 0; i <= R; i++) for (let j = 0; j <= r; j++) {
  const a = i / R * 2 * Math.PI, b = j / r * 2 * Math.PI;
  const n = [Math.cos(a) * Math.cos(b), Math.sin(b), Math.sin(a) * Math.cos(b)];
  P.push(Math.cos(a) + 0.4 * n[0], 0.4 * n[1], Math.sin(a) + 0.4 * n[2]);
  N.push(...n); T.push(i / R, j / r); C.push(Math.round(255 * i / R), Math.round(255 * j / r), 128, 255);
}
for (let i = 0; i < R; i++) for (let j = 0; j < r; j++) {
  const a = i * (r + 1) + j, b = a + r + 1;
  I.push(a, a + 1, b, b, a + 1, b + 1);
}
const parts = [new Float32Array(P), new Float32Array(N), new Float32Array(T), new Uint8Array(C), new Uint16Array(I)].map(x => Buffer.from(x.buffer));
const views = []; let off = 0;
for (const p of parts) { views.push({ buffer: 0, byteOffset: off, byteLength: p.length }); off += p.length; }
const bin = Buffer.concat(parts), n = P.length / 3;
const min = [0, 1, 2].map(k => Math.min(...P.map(Math.fround).filter((_, i) => i % 3 == k))), max = [0, 1, 2].map(k => Math.max(...P.map(Math.fround).filter((_, i) => i % 3 == k)));
const png = Buffer.from('iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==', 'base64');
const image = Buffer.concat([png, Buffer.alloc((4 - png.length % 4) % 4)]);
views.push({ buffer: 0, byteOffset: bin.length, byteLength: png.length });
const all = Buffer.concat([bin, image]);
const json = {
  asset: { version: '2.0', generator: 'holo' }, scene: 0, scenes: [{ nodes: [0, 1] }],
  nodes: [{ mesh: 0, name: 'large' }, { children: [2], translation: [0, 1.5, 0], name: 'arm' }, { mesh: 0, scale: [0.5, 0.5, 0.5], rotation: [0.6, 0, 0, 0.8], name: 'small' }],
  meshes: [{ name: 'torus', primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2, COLOR_0: 3 }, indices: 4, material: 0 }] }],
  materials: [{ name: 'plain', pbrMetallicRoughness: { baseColorTexture: { index: 0 }, metallicFactor: 0 } }],
  textures: [{ source: 0 }], images: [{ bufferView: 5, mimeType: 'image/png' }],
  accessors: [
    { bufferView: 0, componentType: 5126, count: n, type: 'VEC3', min, max }, { bufferView: 1, componentType: 5126, count: n, type: 'VEC3' },
    { bufferView: 2, componentType: 5126, count: n, type: 'VEC2' }, { bufferView: 3, componentType: 5121, normalized: true, count: n, type: 'VEC4' },
    { bufferView: 4, componentType: 5123, count: I.length, type: 'SCALAR' }],
  bufferViews: views, buffers: [{ byteLength: all.length }] };
let text = Buffer.from(JSON.stringify(json)); text = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, 32)]);
const h = Buffer.alloc(20); h.write('glTF'); h.writeUInt32LE(2, 4); h.writeUInt32LE(20 + text.length + 8 + all.length, 8); h.writeUInt32LE(text.length, 12); h.write('JSON', 16);
const b = Buffer.alloc(8); b.writeUInt32LE(all.length, 0); b.write('BIN\0', 4);
fs.writeFileSync('source.glb', Buffer.concat([h, text, b, all]));
