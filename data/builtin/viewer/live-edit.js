/* SPDX-License-Identifier: MIT */
/* A live page: changes of the scene's text by controls. */

/* ---- a scene that can be edited ---- */

const file_stem = name => name.replace(/^.*[/]/, "").replace(/[.][^.]*$/, "");
const SCENE_WORDS = new Set(["wavelengths", "size", "camera", "viewer", "shading", "ambient", "light", "material", "object",
  "checker", "include"]);

/* Returns whether a text is a scene; otherwise it may be a list of material files. */
const is_scene_text = text => statements_of(text).some(({words}) => SCENE_WORDS.has(words[0].text));

async function builtin_text(name) {
  const {status, output, errors} = await run_program(["show", name]);
  if (status !== 0) throw new Error(errors);
  return output;
}

/* The thesis's grid shows the materials of a list. */
async function scene_of_list(name) {
  return (await builtin_text("colorchecker")).replace(/^checker colorchecker /m, `checker ${as_word(name)} `);
}

/* Puts the texts of built-in scenes in the place of statements that include them. */
async function with_includes(text, files) {
  for (const {words, start, end} of statements_of(text).reverse())
    if (words[0].text === "include" && words[1] && !(words[1].text in files))
      text = replaced(text, {start, end}, (await builtin_text(words[1].text)).trimEnd());
  return text;
}

const without_factor = value => value.replace(/[*][^*]*$/, "");

/* Changes of the text for the options that have a statement; the others stay options, and so do those whose statement is
 * in another file. The description has the intensities that the program has read. */
const BAKED = {
  "--light": (text, value) => {
    const n = parseInt(value, 10) - 1, found = statements_of(text).filter(({words}) => words[0].text === "light")[n];
    return found ? with_light(text, found.line, {intensity: scene.lights[n].intensity,
      spectrum: without_factor(value.slice(value.indexOf("=") + 1))}) : null;
  },
  "--ambient": (text, value) => {
    const all = statements_of(text).filter(({words}) => words[0].text === "ambient");
    const rest = all.reverse().reduce((left, one) => replaced(left, one, ""), text);
    return with_first_statement(rest, `ambient ${as_word(without_factor(value))} ${as_number(scene.ambients[0].intensity)}`);
  },
  "--size": (text, value) => with_own_statement(text, "size", value.replace(/x/i, " ")),
  "--wavelengths": (text, value) => with_own_statement(text, "wavelengths", wavelength_words(value)),
  "--shading": (text, value) => with_own_statement(text, "shading", value),
};

/* Puts a statement that a scene has once; null where an included file may have it. */
const with_own_statement = (text, name, words) => statement_named(text, name) || !statement_named(text, "include")
  ? with_statement(text, name, words) : null;

/* Returns the names of the texts that the scene is made of. */
const scene_texts = () => [state.scene, ...statements_of(text_of(state)).filter(({words}) => words[0].text === "include")
  .map(({words}) => words[1].text)].filter(file => typeof state.files[file] === "string");

/* Returns the place of a statement that a scene has once: the file that has it, or else the scene's own. */
const place_of_statement = name => ({file: scene_texts().find(file => statement_named(state.files[file], name)) || state.scene});

const wavelength_words = value => value.includes(":") ? value.replaceAll(":", " ") : "list " + value.replaceAll(",", " ");

function bake(text, words) {
  const left = [];
  for (const word of words) {
    const [name, value] = [word.slice(0, word.indexOf("=")), word.slice(word.indexOf("=") + 1)];
    const next = BAKED[name] ? BAKED[name](text, value) : null;
    if (next === null) left.push(word);
    else text = next;
  }
  return {text, words: left};
}

/* Returns the state with the scene as a text of its own. */
async function editable(from) {
  if (is_text(from) && is_scene_text(text_of(from)) && from.baked) return from;
  let name = from.scene, text;
  if (!is_text(from)) [text, name] = [await builtin_text(name), file_stem(name) + ".scene"];
  else if (is_scene_text(text_of(from))) text = text_of(from);
  else [text, name] = [await scene_of_list(from.scene), file_stem(from.scene) + ".scene"];
  const baked = bake(await with_includes(text, from.files), from.words);
  return {scene: name, words: baked.words, baked: true, files: {...from.files, [name]: baked.text}};
}

let gesture = null;            /* the group of changes while something is dragged: {recorded, moving: true} */
let described_state = null;    /* the state that `scene` describes, so that its lines are known */
let waiting_for_lines = [];    /* {then, fail} */
let edits = Promise.resolve(); /* edits follow each other, as one may have to wait for the program */

const n_lines = state => Object.values(state.files).map(text =>
  typeof text === "string" ? text.split("\n").length : 0).join();

/* A picture of a scene that has become a text of its own since shows nothing else, but does not know its lines. */
const is_described = of => of.baked || !state.baked;

/* Waits until the description has the places of statements in the present text. A scene that has just become a text of its own
 * looks as before, and needs no picture. */
async function lines_known() {
  if (!described_state) {
    const {description, error} = await ask_program({task: "describe", words: [state.scene, ...state.words], keys: {...keys}});
    if (error) throw new Error(error);
    set_scene(description);
    described_state = state;
  }
  if (state.baked && n_lines(described_state) === n_lines(state)) return;
  if (!whole_is_coming()) want(false);
  await new Promise((then, fail) => waiting_for_lines.push({then, fail}));
}

function lines_are_known(of, error) {
  if (!error && is_described(of)) described_state = of;
  if (of !== state) return;
  for (const {then, fail} of waiting_for_lines.splice(0)) error ? fail(new Error(error)) : then();
}

/* Changes the text of a file of the scene. change(text, place) returns the new text, or {text, files} with more files.
 * place, if it is given, returns the {file, line} of a statement by the current description. Undo takes back all
 * edits of a group together. */
function edit(concerns, change, place = null, group = gesture || {recorded: false}) {
  return queue_edit(async () => {
    if (!state.baked) {
      record(await editable(state), SPECTRA, group);
      described_state = null; /* names of files and places have changed */
    }
    if (place) await lines_known();
    const at = place ? place() : {file: state.scene}, file = at.file;
    if (!(file in state.files)) throw new Error(`${file} is built in. Copy it into the scene to change it here.`);
    const result = change(state.files[file], at);
    const {text, files} = typeof result === "string" ? {text: result, files: {}} : result;
    const next = {...state.files, ...files, [file]: text};
    if (Object.keys(next).some(name => next[name] !== state.files[name])) commit({...state, files: next}, concerns, group);
  });
}

/* Does an edit after all earlier ones. */
function queue_edit(act) {
  pending_edits++;
  show_busy();
  edits = edits.then(act).catch(error => show_refusal(error.message)).finally(() => {
    pending_edits--;
    show_busy();
  });
  return edits;
}

/* ---- the chosen object ---- */

let chosen = 0; /* its surface, from 1; 0: none */
const chosen_object = () => chosen > 0 && chosen <= scene.objects.length ? scene.objects[chosen - 1] : null;

/* The word by which a scene names the file of a material. */
function material_word(path) {
  const builtin = path && path.match(/^builtin:materials\/(.*)[.]txt$/);
  return builtin ? builtin[1] : path;
}

/* Changes the text at the statement of the chosen object: change(text, line). Opens a checker first, so that each of its
 * objects has a statement of its own. */
function edit_at_object(concerns, change, group) {
  const number = chosen;
  if (!chosen_object()) return edits;
  return edit(concerns, (text, object) => {
    const found = statement_at(text, object.line);
    if (found.words[0].text === "object") return change(text, object.line);
    const group = same_checker(object), i = group.indexOf(object.object);
    const opened = with_checker_opened(text, object.line, checker_materials(group));
    const own = statements_of(opened).filter(({start, words}) => start >= found.start && words[0].text === "object")[i];
    return change(opened, own.line);
  }, () => scene.objects[number - 1], group);
}

/* Changes the parts of the chosen object: change(parts). */
const edit_object = (concerns, change, group) =>
  edit_at_object(concerns, (text, line) => with_object(text, line, change), group);

/* Gives all objects of the scene a shape. */
function shape_all(words) {
  const shaped = text => with_objects(text, parts => give_shape(parts, words));
  edit(GEOMETRY | SPECTRA, text => ({text: shaped(text),
    files: Object.fromEntries(scene_texts().map(name => [name, shaped(state.files[name])]))}));
}

/* Puts a copy of the chosen object beside it, to the right in the picture. */
function copy_object() {
  const by = way_of(shape.width / 8, 0, place_of_object(chosen_object()));
  edit_at_object(GEOMETRY | SPECTRA, (text, line) => {
    const found = statement_at(text, line), parts = object_parts(found);
    move_object(parts, by);
    return replaced(text, {start: found.end, end: found.end}, "\n" + parts_text(parts));
  });
}

function remove_object() {
  edit_at_object(GEOMETRY | SPECTRA, (text, line) => replaced(text, statement_at(text, line), ""));
  choose_object(0);
}

/* The numbers of all objects of the checker that made this one. */
const same_checker = object => [...new Set(scene.objects.filter(({file, line}) =>
  file === object.file && line === object.line).map(({object}) => object))];

const checker_materials = group => group.map(number => {
  const {name, material_file} = scene.objects.find(({object}) => object === number);
  return {name, file: material_word(material_file)};
});

/* ---- materials ---- */

const materials_in = text => statements_of(text).filter(({words}) => words[0].text === "material" && words.length > 2);
const material_names = text => materials_in(text).map(({words}) => words[1].text);

/* Returns a name that the text does not use yet. */
function new_name(text, name) {
  const known = new Set(material_names(text));
  let own = name;
  for (let n = 2; known.has(own); n++) own = `${name}-${n}`;
  return own;
}

/* Gives the chosen object a material of the scene, or the one of a file. */
function choose_material(name, file) {
  const group = {recorded: false};
  let own = name;
  if (file) edit(GEOMETRY | SPECTRA, text => {
    const defined = materials_in(text).find(({words}) => words[2].text === file);
    own = defined ? defined.words[1].text : new_name(text, name);
    return defined ? text : with_first_statement(text, `material ${as_word(own)} ${as_word(file)}`);
  }, null, group);
  edit_object(GEOMETRY | SPECTRA, parts => set_part(parts, "material", [own], ["materials"]), group);
}

/* Returns the place of an object, also where it has been moved since the scene was described. */
function place_of_object(object) {
  const text = state.files[object.file], found = typeof text === "string" && statement_at(text, object.line);
  return found && found.words[0].text === "object" ? origin_of(object_parts(found)) : object.origin;
}

/* Puts a statement before the first object or material. */
function with_first_statement(text, statement) {
  const all = statements_of(text), at = all.find(({words}) => ["material", "object", "checker"].includes(words[0].text));
  const place = at ? at.start : text.length;
  return text.slice(0, place) + statement + "\n" + text.slice(place);
}

/* Returns the words of a material file as a material in words, or null if it says more than words can. */
function words_of_material_file(file, text) {
  const lines = text.split("\n").map(line => line.replace(/#.*/, "").trim()).filter(line => line !== "");
  if (lines.some(line => !/^(g\s|[\d.])/.test(line))) return null;
  const gloss = lines.find(line => line.startsWith("g"));
  return `{ diffuse ${as_word(file)}${gloss ? " gloss " + gloss.slice(1).trim() : ""} }`;
}

/* Returns a material file with another value of a line: g GLOSS, t TEXTURE. Metameric partners keep theirs. */
function with_file_line(text, letter, value) {
  const kept = text.split("\n").filter(line => !new RegExp(`^\\s*${letter}\\s`).test(line));
  return (value === null ? [] : [`${letter} ${value}`]).concat(kept).join("\n");
}

/* Sets a word of the chosen object's material: gloss or texture. A material in a file becomes one in words, or, where
 * words cannot say all that it says, another file. */
async function edit_material(word, value) {
  const object = chosen_object(), path = object && material_word(object.material_file);
  if (!object) return;
  const own = path in state.files, source = path ? (own ? state.files[path] : await builtin_text(path)) : "";
  const group = {recorded: false};
  await edit_object(GEOMETRY | SPECTRA, () => {}, group); /* opens a checker, so that the material has a statement */
  return edit(GEOMETRY | SPECTRA, text => {
    const found = materials_in(text).find(({words}) => words[1].text === object.name);
    if (!found) throw new Error(`The material ${object.name} has no statement in this text.`);
    if (found.words[2].text === "{") return with_material_word(text, object.name, word, value);
    const content = {start: found.words[2].start, end: found.end}, words = own ? null : words_of_material_file(path, source);
    if (words) return with_material_word(replaced(text, content, words), object.name, word, value);
    const file = `${file_stem(path).replace(/-changed$/, "")}-changed.txt`;
    const line = word === "gloss" ? ["g", value] : ["t", value && value.split(" ")[0]];
    return {text: replaced(text, content, as_word(file)), files: {[file]: with_file_line(source, ...line)}};
  }, null, group);
}
