/* SPDX-License-Identifier: MIT */
/* A worker of a live page: it runs the program, and paints what the program has drawn. */

let program;                   /* the compiled module */
const folder = new Map();      /* the files that the program sees, by their absolute paths */
let described = {};            /* the keys of the description that is set: see `describe` */
let drawn = null;              /* the key of the planes that are set */

const as_bytes = content => typeof content === "string" ? new TextEncoder().encode(content) : content;

/* Runs a command. Returns {status, output, errors}. */
function run(words) {
  const system = new System(program, folder, ["spectral", ...words]), status = system.run();
  return {status, output: system.output[1], errors: system.output[2].trim()};
}

/* Runs a command that writes a file, and returns {bytes} of the file, or {error}. */
function make(words, path) {
  const {status, errors} = run([...words, "-o", path]), file = folder.get(path);
  folder.delete(path);
  return status === 0 && file ? {bytes: file.content()} : {error: errors || `exit status ${status}`};
}

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
  const out = {painted, chosen, ms: performance.now() - since};
  if (whole) Object.assign(out, {description: scene, shape, linear,
    planes: {surfaces: surfaces.slice(), values: [...weights, ...texels].map(plane => plane.slice())}});
  return out;
}

const tasks = {
  start({module}) { program = module; return {}; },
  files({files, gone}) {
    for (const name of gone || []) folder.delete("/" + name);
    for (const [name, content] of Object.entries(files)) folder.set("/" + name, new MemoryFile(as_bytes(content)));
    return {};
  },
  draw,
  run({words}) { return run(words); },
  make({words, path}) { return make(words, path); },
};

onmessage = ({data}) => {
  let answer;
  try {
    answer = tasks[data.task](data);
  } catch (error) {
    answer = {error: `error: ${error.message}`};
  }
  const moved = answer.painted ? [answer.painted.data.buffer] : [];
  if (answer.planes) moved.push(answer.planes.surfaces.buffer, ...answer.planes.values.map(plane => plane.buffer));
  postMessage({id: data.id, ...answer}, moved);
};
