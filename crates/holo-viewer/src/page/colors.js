// Color maps and number formats.

// Stops of the maps in sRGB, evenly spaced. For depth, lightness increases towards near; for error, from a dark neutral
// towards cold (estimate too far) and warm (too near), with equal lightness on both sides.
const STOPS = {
  near: ['#1b1436', '#2b2a6e', '#26508f', '#1c7390', '#25968a', '#51b578', '#95cd62', '#dbdd6a', '#fbf3b6'],
  error: ['#bfe6ff', '#6fb7f0', '#3a82cc', '#2a4d78', '#2b2b2d', '#7a4424', '#cc6a28', '#f4a04e', '#ffe0b8'],
};

const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// 256 colors as RGBA bytes.
const palette = (name) => {
  const stops = STOPS[name].map(channels);
  const bytes = new Uint8Array(4 * 256);
  for (let index = 0; index < 256; index += 1) {
    const at = (index / 255) * (stops.length - 1);
    const lower = Math.min(Math.floor(at), stops.length - 2);
    for (let channel = 0; channel < 3; channel += 1) {
      const [a, b] = [stops[lower][channel], stops[lower + 1][channel]];
      bytes[4 * index + channel] = Math.round(a + (b - a) * (at - lower));
    }
    bytes[4 * index + 3] = 255;
  }
  return bytes;
};

// A number with four digits: 12.34, 1.234, 0.1234.
const digits = (value, count = 4) => {
  if (Number.isNaN(value)) return '\u2013';
  if (!Number.isFinite(value)) return value > 0 ? '\u221e' : '\u2212\u221e';
  const whole = value === 0 ? 1 : Math.floor(Math.log10(Math.abs(value))) + 1;
  return value.toFixed(clamp(count - Math.max(whole, 1), 0, count)).replace('-', '\u2212');
};

const meters = (value) => `${digits(value)} m`;
const pixels = (value) => (Number.isNaN(value) ? '\u2013' : `${value > 0 ? '+' : ''}${digits(value)} px`);

// The range that contains `share` of the finite values.
const percentiles = (values, share) => {
  const step = Math.ceil(values.length / 200000);
  const some = [];
  for (let index = 0; index < values.length; index += step) if (Number.isFinite(values[index])) some.push(values[index]);
  some.sort((a, b) => a - b);
  const at = (part) => some[Math.round(part * (some.length - 1))] ?? NaN;
  return [at((1 - share) / 2), at((1 + share) / 2)];
};

// Display of the two maps: values that are linear in the color scale, their range, the legend.
const scales = {};

// Depth is shown linear in 1/Z, as disparity is.
const prepareScales = () => {
  const source = maps.depth ?? maps.disparity ?? maps.estimate;
  if (source) {
    const inverse = source === maps.depth;
    const values = inverse ? source.map((value) => (value > 0 && value < Infinity ? 1 / value : NaN)) : source;
    let [low, high] = percentiles(values, 0.998);
    if (!(high > low)) [low, high] = [low * 0.9 - (inverse ? 0 : 1), low * 1.1 + (inverse ? 0 : 1)];
    const label = (value) => {
      const depth = inverse ? 1 / value : depthOfDisparity(value);
      const disparity = inverse ? disparityOfDepth(depth) : value;
      return [meters(depth), pixels(disparity)].filter((text) => !text.startsWith('\u2013')).join('\n');
    };
    const caption = `${source === maps.estimate ? 'Estimate' : inverse || hasMetricRig ? 'Depth' : 'Disparity'}, central view`;
    scales.depth = { values, low, high, label, colors: palette('near'), caption, note: '' };
  }
  if (maps.error) {
    const sizes = maps.error.map(Math.abs);
    const end = Math.max(percentiles(sizes, 0.98)[1] || 0, 1e-4);
    const known = sizes.filter(Number.isFinite);
    const mean = known.reduce((sum, value) => sum + value, 0) / Math.max(known.length, 1);
    const bad = known.filter((value) => value > 0.07).length / Math.max(known.length, 1);
    scales.error = {
      values: maps.error, low: -end, high: end, label: pixels, colors: palette('error'),
      caption: 'Estimate minus truth, central view',
      note: `mean ${digits(mean)} px \u00b7 ${(100 * bad).toFixed(2)} % beyond 0.07 px`,
    };
  }
};
