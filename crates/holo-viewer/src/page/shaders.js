// The shader programs.

// An image that is too large for one texture is in the layers of a texture array, tile by tile.
const TILED = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
uniform ivec2 views;
uniform ivec2 lenses;
uniform sampler2DArray raw;
uniform ivec3 rawTiles; // width, height, tiles in a row
vec4 at(sampler2DArray image, ivec3 tiles, ivec2 pixel) {
  ivec2 tile = pixel / tiles.xy;
  return texelFetch(image, ivec3(pixel - tile * tiles.xy, tile.y * tiles.z + tile.x), 0);
}
vec3 sampleOf(ivec2 lens, ivec2 view) {
  return at(raw, rawTiles, lens * views + view).rgb;
}
`;

const VERTEX = `#version 300 es
void main() {
  // One triangle that covers the screen.
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  gl_Position = vec4(corner, 0.0, 1.0);
}
`;

// Adds some views to the sum, shifted so that points of this disparity coincide. The alpha channel counts the views, because
// near the border not every view contains a point.
//
// Sums are in linear light. The polynomial approximates the sRGB curve within 0.44 of an 8-bit code, without a power.
const REFOCUS = `${TILED}
uniform sampler2D before;
uniform ivec2 center;
uniform ivec2 first;   // the grid of views that take part: its first view,
uniform ivec2 taken;   // its size,
uniform int stride;    // and the distance between adjacent ones
uniform int start;
uniform int count;
uniform vec2 disparity;
out vec4 sum;
vec3 linear(vec3 c) {
  return c * (0.06601302 + c * (0.20631025 + c * (1.6994402 + c * (-1.6392947 + c * 0.66753123))));
}
vec3 light(ivec2 lens, ivec2 view) {
  return linear(sampleOf(clamp(lens, ivec2(0), lenses - 1), view));
}
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  sum = start == 0 ? vec4(0.0) : texelFetch(before, pixel, 0);
  for (int index = start; index < start + count; ++index) {
    ivec2 view = first + stride * ivec2(index % taken.x, index / taken.x);
    vec2 place = vec2(pixel) - disparity * vec2(view - center);
    if (any(lessThan(place, vec2(-0.5))) || any(greaterThan(place, vec2(lenses) - 0.5))) continue;
    vec2 base = floor(place);
    vec2 part = place - base;
    ivec2 lens = ivec2(base);
    vec3 color = light(lens, view);
    if (part != vec2(0.0)) {
      vec3 right = light(lens + ivec2(1, 0), view);
      vec3 below = light(lens + ivec2(0, 1), view);
      vec3 both = light(lens + ivec2(1, 1), view);
      color = mix(mix(color, right, part.x), mix(below, both, part.x), part.y);
    }
    sum += vec4(color, 1.0);
  }
}
`;

// Draws the image of a mode on the screen. An enlarged pixel is a square; a reduced image is averaged.
const SHOW = `${TILED}
const int VIEW = 0, RAW = 1, VIEWS = 2, MAP = 3, FOCUSED = 4;
uniform int kind;
uniform ivec2 view;
uniform ivec2 size;
uniform ivec2 period;
uniform vec2 offset;
uniform float scale;
uniform float height;
uniform int taps;
uniform bool smoothly;
uniform vec3 ground;
uniform sampler2D focused;
uniform sampler2DArray map;
uniform ivec3 mapTiles;
uniform sampler2D colors;
uniform vec2 range;
out vec4 fragment;

vec3 encoded(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(1.055 * pow(max(c, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308))));
}

vec3 pixelAt(ivec2 p) {
  if (kind == RAW) return at(raw, rawTiles, p).rgb;
  if (kind == VIEWS) return sampleOf(p % lenses, p / lenses);
  if (kind == FOCUSED) {
    vec4 sum = texelFetch(focused, p, 0);
    return encoded(sum.rgb / max(sum.a, 1.0));
  }
  if (kind == MAP) {
    float value = at(map, mapTiles, p).r;
    // The value for "unknown", because not every graphics card keeps NaN.
    if (value < -1e37) return vec3((p.x + p.y & 1) == 0 ? 0.13 : 0.16);
    float part = clamp((value - range.x) / (range.y - range.x), 0.0, 1.0);
    return texelFetch(colors, ivec2(int(part * 255.0 + 0.5), 0), 0).rgb;
  }
  return sampleOf(p, view);
}

vec3 between(vec2 place) {
  vec2 base = floor(place - 0.5);
  vec2 part = place - 0.5 - base;
  ivec2 low = clamp(ivec2(base), ivec2(0), size - 1);
  ivec2 high = clamp(ivec2(base) + 1, ivec2(0), size - 1);
  return mix(mix(pixelAt(low), pixelAt(ivec2(high.x, low.y)), part.x),
             mix(pixelAt(ivec2(low.x, high.y)), pixelAt(high), part.x), part.y);
}

bool inside(vec2 place) {
  return all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(size)));
}

// Opacity of a grid line: it is one device pixel wide and fades in with the distance between lines.
float line(vec2 place, vec2 every) {
  bvec2 crossed = notEqual(floor(place / every), floor((place - 1.0 / scale) / every));
  return any(crossed) ? smoothstep(10.0, 48.0, scale * min(every.x, every.y)) : 0.0;
}

void main() {
  vec2 device = vec2(gl_FragCoord.x, height - gl_FragCoord.y);
  vec2 place = (device - offset) / scale;
  vec3 color = vec3(0.0);
  if (taps == 1) {
    color = !inside(place) ? ground : smoothly ? between(place) : pixelAt(ivec2(place));
  } else {
    for (int row = 0; row < taps; ++row) {
      for (int column = 0; column < taps; ++column) {
        vec2 shifted = place + ((vec2(column, row) + 0.5) / float(taps) - 0.5) / scale;
        color += inside(shifted) ? pixelAt(ivec2(shifted)) : ground;
      }
    }
    color /= float(taps * taps);
  }
  if (inside(place)) {
    color = mix(color, vec3(0.5), 0.35 * line(place, vec2(1.0)) * (smoothly ? 0.0 : 1.0));
    if (period != ivec2(1)) {
      // A light line next to a dark one is visible on any image.
      color = mix(color, vec3(0.0), 0.5 * line(place - 1.0 / scale, vec2(period)));
      color = mix(color, vec3(1.0), 0.7 * line(place, vec2(period)));
    }
  }
  fragment = vec4(color, 1.0);
}
`;
