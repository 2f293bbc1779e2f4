/* SPDX-License-Identifier: MIT */
/* A worker of a live page also paints what the program has drawn. */

let described = {}; /* the keys of the description that is set: see `describe` */
let drawn = null;   /* the key of the planes that are set */

function take_planes(bytes) {
  const {facts: shape, first} = read_head(bytes), at = bytes.byteOffset + first;
  const n = shape.width * shape.height * shape.positions ** 2;
  const n_values = shape.weight_scales.length + shape.texture_scales.length;
  const values = Array.from({length: n_values}, (_, i) => new Float32Array(bytes.buffer, at + 4 * n * i, n));
  set_planes(shape, {surfaces: new Uint16Array(bytes.buffer, at + 4 * n * n_values, n), values});
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
function rasterize(scene_words, key) {
  if (drawn === key) return {};
  drawn = null;
  const {bytes, error} = make(["view", ...scene_words], "/page.planes");
  if (error) return {error};
  take_planes(bytes);
  drawn = key;
  return {};
}

/* Draws and paints. With `whole`, all that the page needs to show spectra comes along. */
function draw({words, size, keys, eye, exposure, whole}) {
  const description = describe(words, keys, whole), since = performance.now();
  const error = description.error || rasterize([...words, ...size], `${keys.geometry} ${size}`).error;
  if (error) return {error};
  const chosen = choice_of(eye);
  const painted = paint({ambients: scene.ambients, lights: scene.lights}, chosen, exposure);
  const out = {painted, chosen, ms: performance.now() - since, moved: [painted.data.buffer]};
  if (whole) Object.assign(out, {description: scene, shape, linear,
    planes: {surfaces: surfaces.slice(), values: [...weights, ...texels].map(plane => plane.slice())}});
  if (whole) out.moved.push(out.planes.surfaces.buffer, ...out.planes.values.map(plane => plane.buffer));
  return out;
}

tasks.draw = draw;
