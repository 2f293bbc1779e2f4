/* SPDX-License-Identifier: MIT */
/* A worker of a live page also paints what the program has drawn. */

let described = {}; /* the keys of the description that is set: see `describe` */
let drawn = null;   /* the key of the planes that are set */

/* Takes the planes of a picture. With `enlarged`, those of a smaller one than the scene has stand for all its pixels. */
function take_planes(bytes, enlarged) {
  const {facts: shape, first} = read_head(bytes), at = bytes.byteOffset + first;
  const n = shape.width * shape.height * shape.positions ** 2;
  const n_values = shape.weight_scales.length + shape.texture_scales.length;
  const values = Array.from({length: n_values}, (_, i) => new Float32Array(bytes.buffer, at + 4 * n * i, n));
  const planes = {surfaces: new Uint16Array(bytes.buffer, at + 4 * n * n_values, n), values};
  enlarged ? set_planes({...shape, width: scene.width, height: scene.height}, enlarge(planes, shape)) : set_planes(shape, planes);
}

/* Returns planes of the scene's size, each pixel that of the smaller picture at its place. */
function enlarge({surfaces, values}, {width, height}) {
  const columns = Uint32Array.from({length: scene.width}, (_, x) => Math.floor(x * width / scene.width));
  const spread = plane => {
    const out = new plane.constructor(scene.width * scene.height);
    for (let y = 0, at = 0; y < scene.height; y++)
      for (let x = 0, row = Math.floor(y * height / scene.height) * width; x < scene.width; x++) out[at++] = plane[row + columns[x]];
    return out;
  };
  return {surfaces: spread(surfaces), values: values.map(spread)};
}

/* Returns the options for a picture of about so many pixels, or none where the scene has not many more. */
function smaller_words(most) {
  const factor = Math.sqrt(scene.width * scene.height / most), size = part => Math.max(1, Math.round(part / factor));
  return factor < 2 ? [] : [`--size=${size(scene.width)}x${size(scene.height)}`, "--samples=1"];
}

/* Describes the scene, unless the description is of these spectra, and, where the page wants all of it, of this geometry.
 */
function describe(scene_words, {spectra, geometry}, whole) {
  if (described.spectra === spectra && (!whole || described.geometry === geometry)) return {};
  const {bytes, error} = make(["view", ...scene_words], "/page.json");
  if (error) return {error};
  set_scene(JSON.parse(new TextDecoder().decode(bytes)));
  described = {spectra, geometry};
  return {};
}

/* Draws the scene, unless the planes are those of the key. */
function rasterize(scene_words, key, enlarged) {
  if (drawn === key) return {};
  drawn = null;
  const {bytes, error} = make(["view", ...scene_words], "/page.planes");
  if (error) return {error};
  take_planes(bytes, enlarged);
  drawn = key;
  return {};
}

/* Draws and paints. With `whole`, all that the page needs to show spectra comes along. With `most`, a picture of about
 * so many pixels stands for a much larger one, which is `to_come` then. */
function draw({words, size, keys, eye, exposure, whole, most}) {
  const description = describe(words, keys, whole), since = performance.now();
  if (description.error) return description;
  const fewer = most ? smaller_words(most) : [], to_come = fewer.length > 0;
  const {error} = rasterize([...words, ...size, ...fewer], `${keys.geometry} ${size} ${fewer}`, to_come);
  if (error) return {error};
  const chosen = choice_of(eye);
  const painted = paint({ambients: scene.ambients, lights: scene.lights}, chosen, exposure);
  const out = {painted, chosen, to_come, ms: performance.now() - since, moved: [painted.data.buffer]};
  if (whole) Object.assign(out, {description: scene, shape, linear,
    planes: {surfaces: surfaces.slice(), values: [...weights, ...texels].map(plane => plane.slice())}});
  if (whole) out.moved.push(out.planes.surfaces.buffer, ...out.planes.values.map(plane => plane.buffer));
  return out;
}

tasks.draw = draw;
tasks.describe = ({words, keys}) => {
  const {error} = describe(words, keys, true);
  return error ? {error} : {description: scene};
};
