/* SPDX-License-Identifier: MIT */
/* A live page: its controls, opening and saving, and its start. */

/* ---- pictures that arrive ---- */

function show_moving({painted}) {
  show_picture(painted);
  count_frame(painted);
}

/* Counts pictures a second, while something moves. */
const frames = [];
function count_frame({width}) {
  const now = performance.now();
  frames.push(now);
  while (frames.length > 1 && now - frames[0] > 1000) frames.shift();
  set_text("progress", `${frames.length} ${frames.length === 1 ? "picture" : "pictures"} a second, ${width === shape.width ? "in full" : `${width} pixels wide`}`);
}

function show_whole(answer, of) {
  if (is_described(of)) set_scene(answer.description);
  set_planes(answer.shape, answer.planes);
  linear = answer.linear;
  sources = {ambients: scene.ambients, lights: scene.lights};
  refresh_eye_menus(answer.chosen);
  eye = eye_of(answer.chosen);
  white = white_of(sources);
  if (!gesture) camera = scene.camera;
  lines_are_known(of);
  fit_frame();
  present(answer.painted);
  refresh(of);
  set_text("progress", answer.to_come ? DRAWING : `Drawn in ${answer.ms.toFixed(0)} ms.`);
  show_text_error("");
}

/* A scene that cannot be drawn: the last good picture stays. */
function refuse(error, of) {
  lines_are_known(of, error);
  show_refusal(error);
  show_text_error(error);
}

/* What stays true of the page, whatever picture comes. */
function show_notice(text) {
  set_text("notice", text);
  element("notice").hidden = text === "";
}

function show_refusal(error) {
  show_message(error);
  set_text("progress", "");
}

/* ---- the names in menus ---- */

const catalogue = {}; /* what is built in, by its kind */

async function read_catalogue() {
  for (const kind of ["scenes", "materials", "textures", "reliefs", "shapes", "models"]) {
    const {output} = await run_program(["list", kind]);
    catalogue[kind] = output.split("\n").filter(line => line.startsWith("  ")).map(line => line.trim().split(" ")[0]);
  }
}

/* Fills a menu with groups of [value, text], unless it has them already. */
function fill_menu(id, groups, selected) {
  const menu = element(id), key = JSON.stringify(groups);
  if (menu.dataset.filled !== key) {
    menu.replaceChildren(...Object.entries(groups).filter(([, rows]) => rows.length > 0).map(([label, rows]) => {
      const group = document.createElement("optgroup");
      group.label = label;
      group.append(...rows.map(([value, text]) => new Option(text, value)));
      return group;
    }));
    menu.dataset.filled = key;
  }
  menu.value = selected;
}

/* Calls act(value, number) after each change of a control. An edit runs later, when the control may show the scene as it was
 * before: so act gets the value that was chosen, and never the control. */
function on_change(id, act) {
  element(id).addEventListener("change", ({target}) => act(target.value, target.valueAsNumber));
}

/* ---- controls of lights ---- */

const LAMPS = [["blackbody", "Planck’s law at …", 2856], ["daylight", "daylight of …", 6504]];
const kelvin_of = word => { const found = word.match(/^(blackbody|daylight):([\d.]+)$/); return found && found.slice(1); };

/* Returns the numbers of an input for three coordinates, with a label for each. */
function add_triple(id, values, change) {
  const group = element(id);
  if (group.childElementCount === 0) {
    group.classList.add("triple");
    for (const axis of "xyz") {
      const input = document.createElement("input");
      Object.assign(input, {type: "number", step: "any", id: `${id}-${axis}`});
      input.setAttribute("aria-label", axis);
      group.append(input);
      on_change(input.id, () => change([..."xyz"].map(one => element(`${id}-${one}`).valueAsNumber || 0)));
    }
  }
  [..."xyz"].forEach((axis, i) => set_number(`${id}-${axis}`, values[i]));
}

/* Sets a number that nobody is typing. */
function set_number(id, value) {
  if (document.activeElement !== element(id) || gesture) element(id).value = +value.toPrecision(6);
}

function edit_light(kind, i, change) {
  const concerns = kind === "lights" && change.shadows === undefined ? SPECTRA : SPECTRA | GEOMETRY;
  if (kind === "ambients" && !scene.ambients[i].line) {
    const {illuminant, intensity} = {...scene.ambients[i], ...change};
    const statement = `ambient ${as_word(change.spectrum || scene.illuminants[illuminant].word)} ${as_number(intensity)}`;
    edit(GEOMETRY | SPECTRA, text => {
      const own = statements_of(text).find(({words}) => words[0].text === "ambient"); /* of the edit before this one */
      return own ? with_light(text, own.line, change) : with_first_statement(text, statement);
    });
  } else edit(concerns, (text, {line}) => with_light(text, line, change), () => scene[kind][i]);
}

function button_of(id, text, act) {
  const button = Object.assign(document.createElement("button"), {type: "button", id, textContent: text});
  button.addEventListener("click", act);
  return button;
}

/* A new light stands where the camera stands, so that it shines into the picture. */
function add_light() {
  const unit = scene.radiance_unit ? " unit W" : "";
  edit(GEOMETRY | SPECTRA, text => with_first_statement(text, `light d65 ${unit ? 0.01 : 0.5} position ${as_vector(camera.eye)}${unit}`));
}

const remove_light = (kind, i) => edit(GEOMETRY | SPECTRA, (text, {line}) => replaced(text, statement_at(text, line), ""), () => scene[kind][i]);

/* Adds the rows of a light: spectrum and intensity as in every page; colour temperature; place. */
function add_live_source(kind, i) {
  const id = `${kind}-${i + 1}`, name = (kind === "lights" ? "Light" : "Ambient") + number_of(kind, i);
  add_source(name, id, scene[kind][i]);
  const menu = element(id), more = document.createElement("div");
  for (const [value, text] of LAMPS) menu.add(new Option(text, value));
  for (const file of Object.keys(state.files).filter(name => /[.](csv|sp|txt)$/i.test(name)))
    if (!scene.illuminants.some(({word}) => word === file)) menu.add(new Option(file, "file " + file));
  more.className = "row";
  more.innerHTML = `<div id="${id}-kelvin-row" class="second"><input type="number" id="${id}-kelvin" min="1" step="any"
    aria-label="Colour temperature of ${name}"> K</div>` +
    (kind === "lights" ? `<span id="${id}-label" class="dim">${scene.lights[i].position ? "Stands at" : "Shines from"}</span>
    <div id="${id}-place" role="group" aria-labelledby="${id}-label"></div>
    <label class="check second"><input type="checkbox" id="${id}-shadows"> throws shadows</label>` : "");
  menu.closest(".row").after(more);
  if (scene[kind][i].line) more.append(Object.assign(button_of(id + "-remove", `Remove ${name.toLowerCase()}`, () => remove_light(kind, i)), {className: "second"}));
  on_change(id, value => {
    const lamp = LAMPS.find(([name]) => name === value);
    edit_light(kind, i, {spectrum: lamp ? `${lamp[0]}:${lamp[2]}` : value.startsWith("file ") ? value.slice(5)
      : scene.illuminants[value].word});
  });
  element(id + "-shadows")?.addEventListener("change", event => edit_light(kind, i, {shadows: event.target.checked}));
  on_change(id + "-kelvin", value => edit_light(kind, i,
    {spectrum: `${kelvin_of(scene.illuminants[scene[kind][i].illuminant].word)[0]}:${value}`}));
  element(id + "-slider").addEventListener("pointerdown", begin_gesture);
  element(id + "-slider").addEventListener("pointerup", end_gesture);
  for (const part of ["-slider", "-intensity"])
    element(id + part).addEventListener("input", event =>
      edit_light(kind, i, {intensity: Math.max(0, event.target.valueAsNumber || 0)}));
}

function refresh_sources() {
  const key = JSON.stringify([scene.illuminants.map(({name}) => name), scene.ambients.length, scene.lights.length,
    scene.lights.map(light => !light.position), Object.keys(state.files)]);
  if (element("sources").dataset.key !== key) {
    const typing = document.activeElement.matches("#sources input") && document.activeElement;
    element("sources").replaceChildren();
    for (const kind of ["ambients", "lights"]) scene[kind].forEach((_, i) => add_live_source(kind, i));
    element("sources").append(button_of("add-light", "Add a light", add_light));
    element("sources").dataset.key = key;
    if (typing && element(typing.id)) { /* somebody types: the field stays, with half a number in it */
      element(typing.id).replaceWith(typing);
      typing.focus();
    }
  }
  for (const kind of ["ambients", "lights"]) scene[kind].forEach(({illuminant, intensity, position, direction, shadows}, i) => {
    const id = `${kind}-${i + 1}`, kelvin = kelvin_of(scene.illuminants[illuminant].word);
    element(id).value = illuminant;
    set_number(id + "-intensity", intensity);
    set_number(id + "-slider", intensity);
    element(id + "-kelvin-row").hidden = !kelvin;
    if (kelvin) set_number(id + "-kelvin", Number(kelvin[1]));
    if (kind !== "lights") return;
    add_triple(id + "-place", position || direction, vector => set_light_vector(i, vector));
    element(id + "-shadows").checked = shadows;
  });
  show_source_heads();
}

/* ---- controls of the object ---- */

/* Returns what the chosen object's statement says, as far as it is one. */
function object_facts() {
  const object = chosen_object(), text = object && state.files[object.file];
  const found = text && statement_at(text, object.line);
  if (!found || !has_shape(found)) return {};
  const parts = object_parts(found);
  const material = materials_in(text).find(({words}) => words[1].text === object.name);
  const after = word => {
    const at = material ? material.words.findIndex((one, i) => i > 2 && one.text === word) : -1;
    return at > 0 ? material.words[at + 1].text : null;
  };
  const relief = parts.find(({name}) => name === "displace");
  return {shape: parts[0].values, relief: relief ? relief.values : ["", "0"], texture: after("texture"), gloss: after("gloss")};
}

function refresh_object() {
  const object = chosen_object(), facts = object_facts();
  for (const control of element("object-group").querySelectorAll("input, select:not(#all-shapes), button")) control.disabled = !object;
  set_text("chosen", object ? object_name(chosen) : "Click an object of the picture, or choose one under Spectrum.");
  const own = state.baked ? material_names(text_of(state)) : [];
  const named = object ? object.name : "";
  fill_menu("material", {
    "in the scene": [...new Set([named, ...own])].filter(name => name).map(name => [`own ${name}`, name]),
    "built in": catalogue.materials.map(name => [`file ${name}`, name]),
    files: Object.keys(state.files).filter(name => /[.]txt$/i.test(name)).map(name => [`file ${name}`, name])}, `own ${named}`);
  const pictures = kind => ({"": [["", "none"]], "built in": catalogue[kind].map(name => [name, name]),
    files: files_of_bytes().map(name => [name, name])});
  fill_menu("texture", pictures("textures"), facts.texture || "");
  const [relief, height] = facts.relief || ["", "0"];
  fill_menu("relief", pictures("reliefs"), relief);
  element("relief-slider").disabled = element("relief-height").disabled = !relief;
  refresh_height(Number(height));
  const [kind, file] = facts.shape || [object ? object.shape : ""];
  const shapes = {shapes: catalogue.shapes.filter(name => name !== "mesh").map(name => [name, name]),
    models: catalogue.models.map(name => [`mesh ${name}`, name]),
    files: Object.keys(state.files).filter(name => /[.]obj$/i.test(name)).map(name => [`mesh ${name}`, name])};
  fill_menu("object-shape", shapes, kind === "mesh" ? `mesh ${file}` : kind);
  fill_menu("all-shapes", {"": [["", "choose …"]], ...shapes}, "");
  if (document.activeElement !== element("gloss")) element("gloss").value = facts.gloss || "";
  add_triple("place", object ? place_of_object(object) : [0, 0, 0], vector => edit_object(GEOMETRY, parts =>
    move_object(parts, add_vectors(vector, origin_of(parts), -1))));
  add_triple("turn", [0, 0, 0], angles => angles.forEach((angle, i) => {
    if (angle !== 0) edit_object(GEOMETRY, parts => rotate_object(parts, angle, [0, 1, 2].map(k => k === i ? 1 : 0)));
  }));
  if (document.activeElement !== element("grow")) element("grow").value = 1;
}

function refresh_height(height) {
  const slider = element("relief-slider");
  if (!gesture) [slider.min, slider.max] = [-1, 1].map(side => side * Math.max(0.3, 2 * Math.abs(height)));
  if (!gesture) slider.value = height;
  if (document.activeElement !== element("relief-height") || gesture) element("relief-height").value = height;
}

function listen_to_relief() {
  const slider = element("relief-slider");
  const edit_height = height => edit_object(GEOMETRY, parts => parts.find(({name}) => name === "displace").values[1] = as_number(height));
  on_change("relief", value => edit_object(GEOMETRY | SPECTRA, parts => set_relief(parts, value, Number(element("relief-height").value) || 0.1)));
  on_change("relief-height", (_, height) => Number.isFinite(height) && edit_height(height));
  slider.addEventListener("pointerdown", begin_gesture);
  slider.addEventListener("input", () => {
    element("relief-height").value = +slider.valueAsNumber.toPrecision(3);
    edit_height(Number(element("relief-height").value));
  });
  slider.addEventListener("pointerup", end_gesture);
}

function listen_to_object() {
  listen_to_relief();
  element("copy-object").addEventListener("click", copy_object);
  element("remove-object").addEventListener("click", remove_object);
  on_change("material", value => {
    const [kind, name] = [value.slice(0, value.indexOf(" ")), value.slice(value.indexOf(" ") + 1)];
    kind === "own" ? choose_material(name) : choose_material(file_stem(name), name);
  });
  on_change("texture", value => edit_material("texture", value === "" ? null : `${as_word(value)} linear`));
  on_change("gloss", value => edit_material("gloss", value === "" ? null : value));
  on_change("object-shape", value => edit_object(GEOMETRY | SPECTRA, parts => give_shape(parts, value)));
  on_change("all-shapes", value => value && shape_all(value));
  on_change("grow", (_, factor) => {
    if (factor > 0 && factor !== 1) edit_object(GEOMETRY, parts => scale_object(parts, factor));
  });
}

/* ---- controls of camera, size and text ---- */

function refresh_camera() {
  add_triple("eye", camera.eye, eye => set_camera({...camera, eye}));
  add_triple("look", camera.look, look => set_camera({...camera, look}));
  set_text("extent-label", camera.perspective ? "Angle °" : "Width");
  set_number("extent", camera.extent);
  set_number("size-width", shape.width);
  set_number("size-height", shape.height);
  if (document.activeElement !== element("wavelengths")) element("wavelengths").value = wavelengths_text();
}

function listen_to_camera() {
  on_change("extent", (_, extent) => {
    if (extent > 0) set_camera({...camera, extent});
  });
  for (const id of ["size-width", "size-height"])
    on_change(id, () => {
      const size = `${element("size-width").value} ${element("size-height").value}`;
      edit(GEOMETRY | SPECTRA, text => with_statement(text, "size", size), () => place_of_statement("size"));
    });
  on_change("wavelengths", value => {
    const words = wavelength_words(value);
    edit(GEOMETRY | SPECTRA, text => with_statement(text, "wavelengths", words), () => place_of_statement("wavelengths"));
  });
  element("zoom-in").addEventListener("click", () => zoom_view(KEY_ZOOM));
  element("zoom-out").addEventListener("click", () => zoom_view(1 / KEY_ZOOM));
  for (const [name, key] of [["Left", "a"], ["Right", "d"], ["Up", "w"], ["Down", "s"]]) {
    element("camera-buttons").append(button_of(`camera-${key}`, name, () => KEYS[key]()));
  }
}

/* Files of bytes are pictures, in the formats that the program knows; all others are texts. */
const files_of_bytes = () => Object.keys(state.files).filter(name => typeof state.files[name] !== "string");
const text_files = () => Object.keys(state.files).filter(name => typeof state.files[name] === "string");

async function refresh_text() {
  if (!element("text-group").open) return;
  const names = is_text(state) ? text_files() : [state.scene];
  const before = element("text-file").value;
  fill_menu("text-file", {files: names.map(name => [name, name])}, names.includes(before) ? before : state.scene);
  if (document.activeElement === element("text")) return;
  const text = is_text(state) ? state.files[element("text-file").value] : await builtin_text(state.scene);
  if (element("text").value !== text) element("text").value = text;
}

let typing = 0; /* the timer that waits for a pause; 0: all that was typed is taken */
function type_text() {
  clearTimeout(typing);
  typing = setTimeout(take_text, 300);
}

/* Takes the text that was typed. */
function take_text() {
  clearTimeout(typing);
  typing = 0;
  const typed = element("text").value, shown_file = element("text-file").value;
  return queue_edit(async () => {
    const base = await editable(state), name = is_text(state) ? shown_file : base.scene;
    if (base.files[name] !== typed) commit({...base, files: {...base.files, [name]: typed}}, GEOMETRY | SPECTRA);
  });
}

/* Waits until the state has all that was typed and changed so far. */
const all_edits = () => typing ? take_text() : edits;

/* Shows the message under the text, with a button that leads to its line. */
function show_text_error(message) {
  const place = message.match(/^(.*):(\d+):(\d+): /), error = element("text-error");
  set_text("text-error", message);
  error.hidden = message === "";
  element("text").setAttribute("aria-invalid", message !== "");
  if (!place || !is_text(state) || !(place[1] in state.files)) return;
  error.append(" ", button_of("to-error", `Show line ${place[2]}`, () => select_line(place[1], Number(place[2]))));
}

async function select_line(file, line) {
  const area = element("text");
  element("text-file").value = file;
  await refresh_text();
  const lines = area.value.split("\n"), start = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
  area.focus();
  area.setSelectionRange(start, start + (lines[line - 1] || "").length);
}

/* ---- all controls ---- */

function refresh(of) {
  show_names();
  set_text("name", of.scene);
  refresh_sources();
  refresh_objects();
  refresh_object();
  refresh_camera();
  refresh_text();
  show_handles();
  element("undo").disabled = past.length === 0;
  element("redo").disabled = future.length === 0;
  element("builtin-scene").value = is_text(state) ? "" : state.scene;
}

/* Fills the menus of detectors and displays where the description has others than before. */
function refresh_eye_menus(chosen) {
  for (const id of ["detector", "display"]) {
    const menu = element(id), names = scene[id + "s"].map(({name}) => name);
    if ([...menu.options].map(({text}) => text).join("\n") === names.join("\n")) continue;
    menu.replaceChildren();
    fill_select(menu, names, chosen[id]);
  }
}

const eye_names = () => ({
  detector: element("detector").selectedOptions[0]?.text,
  adaptation: element("adaptation").selectedOptions[0]?.text || "none",
  display: element("display").selectedOptions[0]?.text,
  luminance: amount("luminance"), view: element("scene-view").value, band: Number(element("scene-band").value),
});

/* ---- saving and opening ---- */

/* Returns the head of a file in a tar archive (POSIX.1-2017, ustar), without date and owner. It counts its own sum as blanks. */
function tar_head(name, length) {
  const head = new Uint8Array(512), octal = (value, digits) => value.toString(8).padStart(digits, "0");
  const put = (at, text) => head.set(new TextEncoder().encode(text), at);
  if (new TextEncoder().encode(name).length > 100) throw new Error(`${name}: the name is too long for an archive`);
  for (const [at, text] of [[0, name], [100, octal(0o644, 7)], [108, octal(0, 7)], [116, octal(0, 7)], [124, octal(length, 11)],
    [136, octal(0, 11)], [148, " ".repeat(8)], [156, "0"], [257, "ustar\0" + "00"]]) put(at, text);
  put(148, octal(head.reduce((sum, byte) => sum + byte, 0), 6) + "\0");
  return head;
}

/* Returns files {name: text or bytes} as a tar archive. */
function tar_of(files) {
  const parts = Object.entries(files).flatMap(([name, content]) => {
    const bytes = typeof content === "string" ? new TextEncoder().encode(content) : content;
    return [tar_head(name, bytes.length), bytes, new Uint8Array((512 - bytes.length % 512) % 512)];
  });
  return new Blob([...parts, new Uint8Array(1024)], {type: "application/x-tar"});
}

/* Saves the scene. If it names other files, an archive has all files below its folder. */
async function save_scene() {
  await all_edits();
  state.baked || commit(await editable(state), GEOMETRY | SPECTRA);
  const below = Object.entries(state.files).filter(([name]) => !/^[/]|(^|[/])[.][.]([/]|$)/.test(name)), stem = file_stem(state.scene);
  if (!below.some(([name]) => name !== state.scene && text_of(state).includes(name)))
    return save_as(new Blob([text_of(state)], {type: "text/plain"}), state.scene);
  save_as(tar_of(Object.fromEntries(below.map(([name, content]) => [`${stem}/${name}`, content]))), stem + ".tar");
}

async function save_stack() {
  await all_edits();
  set_text("progress", "Rendering the stack …");
  const {bytes, error} = await ask_apart({task: "make", path: "/" + file_stem(state.scene) + ".tif",
    words: ["render", state.scene, "--renderer=raster", "--no-check", ...without_detector(state.words), "--quiet"]});
  set_text("progress", "");
  error ? show_refusal(error) : save_as(new Blob([bytes], {type: "image/tiff"}), file_stem(state.scene) + ".tif");
}

const without_detector = words => words.filter(word => !word.startsWith("--detector="));

/* Returns how many values a text has at each wavelength; 0: it is no table. Behind semicolons commas are decimal. */
function channels_of(text) {
  const row = typeof text === "string" && text.split(/[\r\n]+/).find(line => /^\s*[\d.]/.test(line));
  return row ? row.trim().split(row.includes(";") ? ";" : /[\s,]+/).length - 1 : 0;
}

/* Returns a state that is seen by the detector of a file. */
function seen_by(name, state) {
  element("detector").add(new Option(name, "", true, true));
  return {...state, words: [...without_detector(state.words), `--detector=${name}`]};
}

/* Opens files: a stack; or the first scene or list among them becomes the scene, and others become files that a scene can name. */
async function open_files(dropped) {
  const list = [...dropped], files = {}, heads = await Promise.all(list.map(file => content_of(file.slice(0, 512))));
  const cube = list.find((_, i) => typeof heads[i] !== "string"), refusal = cube && await open_stack_file(cube.name, list);
  if (cube && !refusal) return;
  if (cube && is_stack() && !list_has_scene(list)) return show_message(refusal);
  const large = list.find(({size}) => size > LARGEST_FILE);
  if (large) return show_message(`${large.name} is too large for this page.`);
  for (const file of list) files[file.name] = await content_of(file);
  const scene_name = Object.keys(files).find(name => /[.](scene|list)$/i.test(name));
  const is_named = name => Object.values(files).some(text => typeof text === "string" && text.includes(name)); /* by a scene */
  const tables = Object.keys(files).filter(name => /[.](csv|txt)$/i.test(name) && !is_named(name));
  const detector = tables.find(name => channels_of(files[name]) === 3);
  if (detector && is_stack()) return show_message(`A page of a stack is made with a detector: spectral view STACK --detector ${detector}`);
  const all = {...state, files: {...state.files, ...files}}, next = detector ? seen_by(detector, all) : all;
  await show_state(scene_name ? {...next, scene: scene_name, words: detector ? next.words.slice(-1) : [], baked: false} : next);
  const notices = tables.filter(name => channels_of(files[name]) > 3).map(name => `${name} has ${channels_of(files[name])} channels, and ` +
    `a page sees by three; develop --raw and probe take any number. A light can take one of its spectra: write ${name}:NAME into the text.`);
  if (refusal && !list_has_scene(list)) notices.push(`${refusal}; it is in the menus Texture and Relief now.`);
  show_notice(notices.join(" "));
}

/* Shows another scene, also where the page has shown a stack so far. */
async function show_state(next) {
  document.body.classList.remove("stack");
  document.body.classList.add("live");
  stack = null;
  show_notice("");
  if (live_started) return commit(next, GEOMETRY | SPECTRA);
  set_state(next, GEOMETRY | SPECTRA);
  await first_picture(null).catch(error => show_message(error.message));
}

/* Opens a stack from the disk: the program reads it piece by piece. Returns why it is none, as a texture; "": it is one. */
async function open_stack_file(name, list) {
  set_text("progress", `Reading ${name} …`);
  const {bytes, error} = await ask_apart({task: "make", words: ["view", name, `--budget=${DROPPED_MB}`], path: "/page.planes"},
    Object.fromEntries(list.map(file => [file.name, file])));
  set_text("progress", "");
  if (bytes) (stack && element("opens-beside").checked ? open_beside : open_stack)(read_stack(bytes));
  if (!error) return "";
  const reason = error.replace(/^error: /, "");
  return reason.startsWith(name + ":") ? reason : `${name} is no stack`;
}

const DROPPED_MB = 1000, LARGEST_FILE = 256e6;
const list_has_scene = list => list.some(({name}) => /[.](scene|list|obj)$/i.test(name));

async function content_of(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  return bytes.includes(0) ? bytes : new TextDecoder().decode(bytes);
}

let start_words = []; /* the options that the page was made with; they hold for other built-in scenes, too */

function open_builtin(name) {
  show_state({scene: name, words: start_words, files: {}, baked: false});
}

/* ---- links ---- */

async function packed(text) {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  return btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/* The address of the page with its state, but for files of bytes. */
async function link_of_state() {
  const files = Object.fromEntries(text_files().map(name => [name, state.files[name]]));
  const facts = {scene: state.scene, words: state.words, baked: state.baked, files, eye: eye_names(), exposure: wanted_exposure()};
  return location.href.replace(/#.*/, "") + "#" + await packed(JSON.stringify(facts));
}

async function copy_link() {
  await all_edits();
  const link = await link_of_state();
  history.replaceState(null, "", link);
  show_notice("");
  await navigator.clipboard?.writeText(link).catch(() => {});
  set_text("progress", `The address of this page holds its state now: ${link.length} characters.`);
}

async function state_of_link() {
  const text = location.hash.slice(1).replaceAll("-", "+").replaceAll("_", "/");
  if (text === "") return null;
  try {
    const link = JSON.parse(new TextDecoder().decode(await unpack(text, "deflate")));
    if (link.scene && link.words && link.files && link.eye) return link;
    throw new Error();
  } catch {
    show_notice("The address of this page was cut or changed, so that its link cannot be read. The page shows its own scene.");
    return null;
  }
}

function take_eye({eye, exposure}) {
  for (const id of ["detector", "adaptation", "display"])
    element(id).value = Math.max(0, scene[id + "s"].findIndex(({name}) => name === eye[id]));
  element("luminance").value = eye.luminance || "";
  element("scene-view").value = eye.view || "detector";
  element("scene-band").value = eye.band || 0;
  element("auto").checked = exposure === null;
  if (exposure !== null) element("exposure").value = exposure;
}

/* ---- the gallery ---- */

const THUMBNAIL = {width: 240, height: 160};

/* Shows a small picture of each built-in scene, as the eye sees it that the page begins with. */
async function show_gallery() {
  const drawer = new Drawer(compiled);
  element("gallery").hidden = false;
  for (const name of catalogue.scenes) {
    const button = document.createElement("button"), small = document.createElement("canvas");
    Object.assign(button, {type: "button", id: `gallery-${name}`});
    Object.assign(small, THUMBNAIL);
    button.append(small, name);
    button.addEventListener("click", () => open_builtin(name));
    element("gallery").append(button);
    const {painted} = await drawer.ask({task: "draw", words: [name], size: [`--size=${THUMBNAIL.width}x${THUMBNAIL.height}`, "--samples=2"],
      keys: {geometry: name, spectra: name}, eye: {...eye_names(), view: "detector"}, exposure: wanted_exposure(), whole: false});
    if (painted) small.getContext("2d").putImageData(new ImageData(painted.data, painted.width, painted.height), 0, 0);
  }
  drawer.end();
  document.body.dataset.gallery = "true";
}

/* ---- the start ---- */

async function state_of_page(start) {
  const bytes = await unpack(element("files").textContent, "deflate");
  return {scene: start.scene, words: start.options, files: read_files(start.files, {bytes, at: 0}), baked: false};
}

/* Says what the page is and what it waits for, until its program has drawn. */
function show_start({scene, program}) {
  document.title = `${scene} – spectral`;
  set_text("name", scene);
  set_text("program", program);
  set_text("progress", "Starting: the program draws the scene …");
  if (location.hash && element("first")) element("first").hidden = true; /* the link shows another picture */
  show_started(false);
}

function show_started(started) {
  document.body.classList.toggle("starting", !started);
  for (const part of document.querySelectorAll("#tools, #zooming, #spectrum, #light-and-eye")) part.inert = !started;
}

function listen_to_opening() {
  element("open").addEventListener("click", () => element("opened").click());
  element("opened").addEventListener("change", ({target}) => open_files(target.files));
  addEventListener("dragover", event => { event.preventDefault(); document.body.classList.add("dropping"); });
  addEventListener("dragleave", () => document.body.classList.remove("dropping"));
  addEventListener("drop", event => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    open_files(event.dataTransfer.files);
  });
}

function listen_to_page() {
  element("undo").addEventListener("click", () => go_back(past, future));
  element("redo").addEventListener("click", () => go_back(future, past));
  element("save-scene").addEventListener("click", () => save_scene().catch(error => show_refusal(error.message)));
  element("save-stack").addEventListener("click", save_stack);
  element("copy-link").addEventListener("click", copy_link);
  on_change("builtin-scene", name => name && open_builtin(name));
  element("text").addEventListener("input", type_text);
  element("text-group").addEventListener("toggle", refresh_text);
  element("text-file").addEventListener("change", refresh_text);
  for (const form of document.querySelectorAll(".edits")) form.addEventListener("submit", event => event.preventDefault());
  addEventListener("keydown", event => {
    const command = (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z";
    if (!command || /^(INPUT|TEXTAREA)$/.test(document.activeElement.tagName)) return;
    event.preventDefault();
    event.shiftKey ? go_back(future, past) : go_back(past, future);
  });
}

function choose_object(surface) {
  chosen = surface;
  refresh_object();
}

/* Takes back all changes, as one more that undo takes back. */
function reset_live() {
  const first = past[0] || state;
  if (first !== state) commit(first, GEOMETRY | SPECTRA);
  else want(false);
}

/* The eye's controls ask for another picture of the same planes. */
function redraw_live(event) {
  if (!event.target.closest("#sources")) want(false);
}

async function start_live() {
  const since = performance.now(), start = element("stack") ? null : JSON.parse(element("start").textContent);
  if (start) show_start(start);
  compiled = await WebAssembly.compile(await unpack(element("module").textContent, "gzip"));
  start_drawers();
  if (!start) return start_opened_stack(since);
  start_words = start.options;
  const own = await state_of_page(start), link = await state_of_link();
  const linked = link && {scene: link.scene, words: link.words, files: link.files, baked: link.baked};
  set_state(linked || own, GEOMETRY | SPECTRA);
  let error = "";
  await first_picture(link).catch(async failure => {
    if (!linked) throw failure;
    error = failure.message;
    set_state(own, GEOMETRY | SPECTRA);
    await first_picture(null);
  });
  listen();
  listen_to_opening();
  listen_to_stack();
  if (error) mend_link(link, linked, error);
  show_started(true);
  show_busy();
  document.body.dataset.ready = "true";
  if (start.gallery) await show_gallery();
}

/* A link to a scene that cannot be drawn: the page shows its own, and the text of the other to mend it. */
function mend_link(link, linked, error) {
  take_eye(link);
  commit(linked, GEOMETRY | SPECTRA);
  element("text-group").open = is_text(linked);
  refuse(error, linked);
  element("text-error").scrollIntoView({block: "end"});
}

/* A page of a stack can open scenes and other stacks, too. */
async function start_opened_stack(since) {
  document.body.classList.remove("live");
  state = {scene: "colorchecker", words: [], files: {}, baked: false};
  listen_to_opening();
  await start_stack();
  set_text("progress", `The first picture took ${(performance.now() - since).toFixed(0)} ms.`);
}

let live_started = false;

const FIRST_PIXELS = 60000; /* these are drawn first where a scene has more, so that the page can be used soon */

/* The picture in the page is the whole one already: it stays while the program draws it. */
async function shown_first(painted) {
  const image = element("first"), {width, height} = painted;
  await image.decode();
  const context = new OffscreenCanvas(width, height).getContext("2d");
  context.drawImage(image, 0, 0);
  return {...painted, data: context.getImageData(0, 0, width, height).data};
}

/* The first picture comes before all that only menus need. */
async function first_picture(link) {
  const drawer = drawers[0];
  drawer.send_files(state.files);
  const answer = await drawer.ask({task: "draw", words: [state.scene, ...state.words], size: [], keys: {...keys}, most: FIRST_PIXELS,
    eye: link ? link.eye : eye_names(), exposure: link ? link.exposure : wanted_exposure(), whole: true});
  if (answer.error) throw new Error(answer.error);
  set_scene(answer.description);
  fill_eye_menus();
  element("handles").replaceChildren();
  if (link) take_eye(link);
  if (answer.to_come && !link && element("first")) answer.painted = await shown_first(answer.painted);
  show_picture(answer.painted);
  await read_catalogue();
  fill_menu("builtin-scene", {"": [["", "choose …"]], "built in": catalogue.scenes.map(name => [name, name])}, state.scene);
  show_whole(answer, state);
  guess_coarseness(answer.to_come ? answer.ms * n_pixels / FIRST_PIXELS : answer.ms);
  choose_scaling();
  if (!link && pixel !== null) cursor = first_place();
  listen_to_object();
  listen_to_camera();
  listen_to_drags();
  listen_to_page();
  live_started = true;
  pick(cursor.x, cursor.y);
  if (answer.to_come) want(false);
}
