/* SPDX-License-Identifier: MIT */
/* From the planes of a drawn scene to its picture, and to the spectra of its pixels. A page runs this itself, and the
 * workers of a live page do. */

let scene;     /* the description of the scene: spectra, lights, objects, detectors, adaptations, displays */
let shape;     /* of its planes: width, height, positions, scales */
let n_bands, standard_observer;
let n_pixels, side, n_positions; /* a pixel is the mean of side x side positions */

const clamp = (value, low, high) => Math.max(low, Math.min(high, value));
const place_of = pixel => [pixel % shape.width, Math.floor(pixel / shape.width)];

function set_scene(description) {
  scene = description;
  n_bands = scene.wavelengths.length;
  standard_observer = scene.detectors.find(({name}) => name === "cie1931") || scene.detectors.find(({observer}) => observer);
}

function set_shape(new_shape) {
  shape = new_shape;
  n_pixels = shape.width * shape.height;
  side = shape.positions;
  n_positions = n_pixels * side * side;
}

/* Reads the head of the program's data: the length of a JSON text in 11 digits, a line's end, and the text. `first` is the
 * place of the samples behind it. */
function read_head(bytes) {
  const text = (start, end) => new TextDecoder().decode(bytes.subarray(start, end)), first = 12 + Number(text(0, 11));
  return {facts: JSON.parse(text(12, first)), first};
}

/* Returns the indices of a pixel's positions. */
function positions_of(pixel) {
  const [x, y] = place_of(pixel), first = (y * side * shape.width + x) * side;
  return Array.from({length: side * side}, (_, i) => first + Math.floor(i / side) * side * shape.width + i % side);
}

/* ---- planes ---- */

/* Decodes planes from the differences between neighbours. */
function decode_planes(raw) {
  const planes = [];
  for (let low = 0, high = n_positions; low < raw.length; low += 2 * n_positions, high += 2 * n_positions) {
    const plane = new Uint16Array(n_positions);
    for (let i = 0, value = 0; i < n_positions; i++) {
      value += raw[low + i] + 256 * raw[high + i];
      plane[i] = value;
    }
    planes.push(plane);
  }
  return planes;
}

let surfaces; /* the number of each position's object, from 1; 0: background */
let shown;    /* the number that most positions of each pixel have; of equally many the first */
let weights;  /* a plane for each term: constant, then diffuse and specular of each light */
let texels;   /* planes of spectral textures at their own wavelengths */
let runs;     /* neighbouring positions of one object: {surface, first, end} */

function most_frequent(numbers) {
  const counts = new Map();
  for (const number of numbers) counts.set(number, (counts.get(number) || 0) + 1);
  return [...counts].reduce((best, one) => one[1] > best[1] ? one : best)[0];
}

/* Takes the planes of a picture of this shape: {surfaces, values}. */
function set_planes(new_shape, planes) {
  const n_weights = new_shape.weight_scales.length;
  set_shape(new_shape);
  surfaces = planes.surfaces;
  shown = side === 1 ? surfaces
    : Uint16Array.from({length: n_pixels}, (_, pixel) => most_frequent(positions_of(pixel).map(i => surfaces[i])));
  weights = planes.values.slice(0, n_weights);
  texels = planes.values.slice(n_weights);
  runs = [];
  for (let first = 0, end = 1; first < n_positions; first = end++) {
    while (end < n_positions && surfaces[end] === surfaces[first]) end++;
    if (surfaces[first] > 0) runs.push({surface: surfaces[first], first, end});
  }
}

const material_of = surface => scene.shaded_materials[scene.objects[surface - 1].shaded_material];

/* ---- spectra ---- */

function spectrum(of) {
  return Float64Array.from({length: n_bands}, (_, i) => of(i));
}

const dark = () => spectrum(() => 0);
const radiance_of = source => scene.illuminants[source.illuminant].radiance;

/* Adds factor x of x other to out. An absent spectrum `of` counts as 0, an absent `other` as 1. */
function add(out, factor, of, other) {
  for (let i = 0; i < n_bands && of; i++) out[i] += factor * of[i] * (other ? other[i] : 1);
}

/* Returns the fluorescence of a material in each term at weight 1, in the order of the planes. */
function fluorescence_of(material, sources) {
  const emitted = ({illuminant, intensity}, out) => {
    add(out, intensity, material.luminescence && material.luminescence[illuminant]);
    return out;
  };
  const constant = dark();
  for (const ambient of sources.ambients) emitted(ambient, constant);
  return [constant, ...sources.lights.flatMap(light => [emitted(light, dark()), dark()])];
}

/* Returns the radiance of each term at weight 1. */
function terms_of(material, sources) {
  const terms = fluorescence_of(material, sources);
  add(terms[0], 1, material.glow);
  for (const ambient of sources.ambients) add(terms[0], ambient.intensity, material.diffuse, radiance_of(ambient));
  sources.lights.forEach((light, l) => {
    add(terms[1 + 2 * l], light.intensity, material.diffuse, radiance_of(light));
    add(terms[2 + 2 * l], light.intensity, material.specular, radiance_of(light));
  });
  return terms;
}

/* Returns the mean of all lights, by intensity; null if no light shines. */
function white_of(sources) {
  const all = sources.ambients.concat(sources.lights);
  const intensity = total(all.map(source => source.intensity)), radiance = dark();
  for (const source of all) add(radiance, source.intensity / intensity, radiance_of(source));
  return radiance.some(value => value > 0) ? {radiance, intensity} : null;
}

/* Returns the factors by which a texture multiplies the radiance of a position. Grey textures are part of
 * the weights. */
function texture_at(position, material) {
  if (!material.texture) return spectrum(() => 1);
  const out = dark();
  material.texture.forEach((parts, page) => add(out, texels[page][position] * shape.texture_scales[page], parts));
  return out;
}

/* Returns the radiance of a pixel; `terms` is terms_of or fluorescence_of. */
function radiance_at(pixel, sources, terms) {
  const out = dark(), part = 1 / (side * side);
  for (const position of positions_of(pixel)) {
    if (surfaces[position] === 0) continue;
    const material = material_of(surfaces[position]), texture = texture_at(position, material);
    terms(material, sources).forEach((term, t) =>
      add(out, part * weights[t][position] * shape.weight_scales[t], term, texture));
  }
  return out;
}

/* ---- colour ---- */

function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

const apply = (rows, column) => rows.map(row => dot(row, column));
const product = (a, b) => a.map(row => b[0].map((_, j) => dot(row, b.map(other => other[j]))));
const scaled = (rows, factors) => rows.map((row, i) => row.map(value => value * factors[i]));
const total = values => values.reduce((sum, value) => sum + value, 0);

/* Returns how far each kind of cones adapts: equations 21 and 22 of the thesis. */
function incompleteness(white, equal, luminance) {
  const root = Math.cbrt(luminance), ratio = white.map((value, i) => value / equal[i]);
  return ratio.map(value => 3 * value / total(ratio)).map(m => (1 + root + m) / (1 + root + 1 / m));
}

/* Returns the responses of a detector to the white; null: there is no white. A stack may record them. */
const white_responses = (detector, white) => detector.of_white !== undefined
  ? detector.of_white.length > 0 ? detector.of_white : null : white && apply(detector.weights, white.radiance);

/* Returns the responses to a radiance of 1 at all wavelengths. */
const equal_responses = detector => detector.equal || detector.weights.map(total);

/* Scales weights so that each response to the white is 1. With a luminance adaptation is incomplete, and
 * responses keep a part of their differences. Returns null if a response is not above 0. */
function adapted(weights, responses, equal, luminance) {
  if (!responses || !responses.every(response => response > 0)) return null;
  const part = luminance > 0 ? incompleteness(responses, equal, luminance) : [1, 1, 1];
  return scaled(weights, part.map((value, i) => value / responses[i]));
}

/* Returns the weights from radiances to linear display channels at exposure 1. Returns null if the eye
 * cannot adapt to the white, or the camera cannot be balanced for it. */
function channel_weights({detector, adaptation, display, luminance}, white) {
  const responses = white_responses(detector, white), equal = equal_responses(detector);
  if (!detector.observer) return adapted(detector.weights, responses, equal, 0);
  if (!adaptation.cones) return product(display.matrix, detector.weights);
  const cones = adapted(product(adaptation.cones, detector.weights), responses && apply(adaptation.cones, responses),
    apply(adaptation.cones, equal), adaptation.incomplete && white ? luminance || 10 * white.intensity : 0);
  return cones && product(product(display.matrix, adaptation.from_cones), cones);
}

/* Returns L*, a*, b*: CIE 15:2018, 8.2.1. */
function cielab(xyz, white) {
  const [x, y, z] = xyz.map((value, i) => white[i] !== 0 ? value / white[i] : 0)
    .map(ratio => ratio > 216 / 24389 ? Math.cbrt(ratio) : ratio * 841 / 108 + 4 / 29);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

/* Returns CIEDE2000 of two colours (CIE 142-2001; Sharma, Wu and Dalal, Color Research and Application 30, 2005). */
function ciede2000([l1, a1, b1], [l2, a2, b2]) {
  const degrees = Math.PI / 180, seventh = x => Math.sqrt(x ** 7 / (x ** 7 + 25 ** 7));
  const g = 0.5 * (1 - seventh((Math.hypot(a1, b1) + Math.hypot(a2, b2)) / 2));
  const c1 = Math.hypot(a1 * (1 + g), b1), c2 = Math.hypot(a2 * (1 + g), b2);
  const hue = (a, b) => a === 0 && b === 0 ? 0 : (Math.atan2(b, a) / degrees + 360) % 360;
  const h1 = hue(a1 * (1 + g), b1), h2 = hue(a2 * (1 + g), b2), grey = c1 * c2 === 0;
  let turn = grey ? 0 : h2 - h1;
  if (turn > 180) turn -= 360;
  if (turn < -180) turn += 360;
  const hues = h1 + h2, l = (l1 + l2) / 2, c = (c1 + c2) / 2;
  const h = grey ? hues : Math.abs(h1 - h2) <= 180 ? hues / 2 : hues < 360 ? (hues + 360) / 2 : (hues - 360) / 2;
  const t = 1 - 0.17 * Math.cos((h - 30) * degrees) + 0.24 * Math.cos(2 * h * degrees) +
    0.32 * Math.cos((3 * h + 6) * degrees) - 0.2 * Math.cos((4 * h - 63) * degrees);
  const dl = (l2 - l1) / (1 + 0.015 * (l - 50) ** 2 / Math.sqrt(20 + (l - 50) ** 2));
  const dc = (c2 - c1) / (1 + 0.045 * c), dh = 2 * Math.sqrt(c1 * c2) * Math.sin(turn / 2 * degrees) / (1 + 0.015 * c * t);
  const rotation = -Math.sin(60 * Math.exp(-(((h - 275) / 25) ** 2)) * degrees) * 2 * seventh(c);
  return Math.sqrt(dl * dl + dc * dc + dh * dh + rotation * dc * dh);
}

function chromaticity(xyz) {
  const sum = total(xyz);
  return [0, 1].map(i => sum !== 0 ? xyz[i] / sum : 0);
}

/* ---- the tone curve ---- */

/* Returns the function from linear values to codes. steps[code] is the least linear value with a code
 * above `code`. A table finds a code near the right one. */
function tone_curve(steps, largest) {
  const size = 4096, near = new Uint8Array(size + 1);
  const search = (code, value) => {
    while (code < 255 && value >= steps[code]) code++;
    return code;
  };
  for (let i = 1; i <= size; i++) near[i] = search(near[i - 1], i / size * largest);
  return value => !(value > 0) ? 0 : value >= largest ? 255
    : search(near[Math.floor(value / largest * size)], value);
}

const tone_curves = new Map(); /* by display: they are the same in all descriptions */

/* Returns the tone curves of a display's three channels. */
function encoders(display) {
  if (!tone_curves.has(display.name))
    tone_curves.set(display.name, display.steps.map((steps, channel) =>
      tone_curve(Float64Array.from(steps), display.largest[channel])));
  return tone_curves.get(display.name);
}

/* ---- the picture ---- */

let linear = []; /* display channels at exposure 1 */
let fine = [];   /* the same of positions */

function make_channels() {
  if (linear.length !== 3 || linear[0].length !== n_pixels)
    linear = [0, 1, 2].map(() => new Float32Array(n_pixels));
  if (side === 1) fine = linear;
  else if (fine === linear || fine.length !== 3 || fine[0].length !== n_positions)
    fine = [0, 1, 2].map(() => new Float32Array(n_positions));
}

/* Returns the summands of a material's pixels: a plane of weights, times a plane of a texture (null: 1),
 * times a factor for each channel. */
function fold(material, sources, channels) {
  const out = [];
  terms_of(material, sources).forEach((term, t) => {
    const products = channels.map(channel => term.map((value, i) => value * channel[i] * shape.weight_scales[t]));
    const put = (texel, factors) => {
      if (factors.some(factor => factor !== 0)) out.push({plane: weights[t], texel, factors});
    };
    if (!material.texture) return put(null, products.map(total));
    material.texture.forEach((parts, page) =>
      put(texels[page], products.map(row => shape.texture_scales[page] * dot(row, parts))));
  });
  return out;
}

function add_run(first, end, {plane, texel, factors}) {
  const [r, g, b] = fine, [of_r, of_g, of_b] = factors;
  for (let i = first; i < end; i++) {
    const weight = texel ? plane[i] * texel[i] : plane[i];
    r[i] += weight * of_r;
    g[i] += weight * of_g;
    b[i] += weight * of_b;
  }
}

function compute_linear(sources, channels) {
  make_channels();
  const folded = scene.shaded_materials.map(material => fold(material, sources, channels));
  for (const channel of fine) channel.fill(0);
  for (const {surface, first, end} of runs)
    for (const summand of folded[scene.objects[surface - 1].shaded_material]) add_run(first, end, summand);
  if (side > 1) fine.forEach((channel, c) => take_means(channel, linear[c]));
}

function take_means(channel, out) {
  const columns = side * shape.width, part = 1 / (side * side);
  out.fill(0);
  for (let y = 0, i = 0; y < side * shape.height; y++)
    for (let x = 0, row = Math.floor(y / side) * shape.width; x < columns; x++, i++)
      out[row + Math.floor(x / side)] += part * channel[i];
}

/* Returns the exposure that makes the largest displayed value 1. */
function automatic_exposure(display) {
  let largest = 0;
  linear.forEach((channel, c) => {
    for (let i = 0; i < n_pixels; i++) largest = Math.max(largest, channel[i] / display.largest[c]);
  });
  return largest > 0 ? 1 / largest : 1;
}

/* A value beyond the gamut by less than this may be there by rounding. */
const SLACK = 1e-6;

/* Writes one channel of the picture, and marks the pixels out of gamut in `clipped`. */
function develop_channel(display, channel, exposure, data, clipped) {
  const values = linear[channel], largest = display.largest[channel], encode = encoders(display)[channel];
  for (let i = 0; i < n_pixels; i++) {
    const value = values[i] * exposure;
    if (value < -SLACK || value > largest + SLACK) clipped[i] = 1;
    data[4 * i + channel] = encode(value);
  }
}

/* Returns the picture's bytes, red, green, blue and 255 of each pixel, and the number of pixels out of gamut. */
function develop(display, exposure) {
  const data = new Uint8ClampedArray(4 * n_pixels).fill(255), clipped = new Uint8Array(n_pixels);
  for (let channel = 0; channel < 3; channel++) develop_channel(display, channel, exposure, data, clipped);
  return {data, outside: clipped.reduce((sum, one) => sum + one, 0)};
}

/* ---- one band, and false colours ---- */

/* Returns channels that show one band in grey. At exposure 1 a radiance of 1 is the display's white. */
const band_channels = (display, band) => display.largest.map(largest => spectrum(i => i === band ? largest : 0));

/* Colours of maps from 0 to the largest value: dark blue, blue, green, yellow; even steps look alike. */
const RAMP = [[20, 20, 70], [40, 90, 160], [30, 150, 140], [120, 195, 80], [250, 230, 60]];

function ramp(part) {
  const at = clamp(part, 0, 1) * (RAMP.length - 1), i = Math.min(Math.floor(at), RAMP.length - 2);
  return RAMP[i].map((value, c) => value + (at - i) * (RAMP[i + 1][c] - value));
}

/* Returns the bytes of a picture of one band in false colours, from 0 to the radiance 1 / exposure. */
function false_colours(display, exposure) {
  const data = new Uint8ClampedArray(4 * n_pixels).fill(255), factor = exposure / display.largest[0];
  linear[0].forEach((value, i) => data.set(ramp(value * factor), 4 * i));
  return data;
}

/* Returns the eye of a choice: {detector, adaptation, display: their numbers, luminance}. */
const eye_of = chosen => ({detector: scene.detectors[chosen.detector], adaptation: scene.adaptations[chosen.adaptation],
  display: scene.displays[chosen.display], luminance: chosen.luminance});

/* Computes the picture under the sources, for a chosen eye, or of one band: see choice_of. exposure null: automatic.
 * `balanced` is false if the eye cannot adapt: the picture is black then. */
function paint(sources, chosen, wanted_exposure) {
  const eye = eye_of(chosen);
  const channels = chosen.view === "detector" ? channel_weights(eye, white_of(sources)) : band_channels(eye.display, chosen.band);
  compute_linear(sources, channels || [0, 1, 2].map(dark));
  const exposure = wanted_exposure === null ? automatic_exposure(eye.display) : wanted_exposure;
  const picture = {...develop(eye.display, exposure), exposure, balanced: channels !== null, width: shape.width, height: shape.height};
  return chosen.view === "map" ? {...picture, data: false_colours(eye.display, exposure)} : picture;
}

/* Returns the choice of an eye by the names of detector, adaptation and display. An unknown detector or display
 * is the one that the page was made with, or cie1931 and srgb; another adaptation is the first one. view: "detector", "band" (in grey) or "map" (a band in false colours). */
function choice_of({detector, adaptation, display, luminance, view = "detector", band = 0}) {
  const number = (list, name) => Math.max(0, list.findIndex(one => one.name === name));
  const known = (list, name, first) => number(list, list.some(one => one.name === name) ? name : first);
  return {detector: known(scene.detectors, detector, scene.detector || "cie1931"), adaptation: number(scene.adaptations, adaptation),
    display: known(scene.displays, display, scene.display || "srgb"), luminance, view, band: Math.min(band, n_bands - 1)};
}
