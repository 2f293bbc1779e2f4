/* SPDX-License-Identifier: MIT */
/* The text of a scene as statements and words, and changes of it that keep all else as it is written. */

/* Returns the place behind the closing quote, or the end of the line. */
function quote_end(text, from, end) {
  const at = text.indexOf('"', from);
  return at < 0 || at >= end ? end : at + 1;
}

/* Returns the words of a line: {text, start, end, quoted}, by their places in the whole text. */
function words_of(text, start, end) {
  const out = [];
  for (let at = start; at < end;) {
    if (text[at] === " " || text[at] === "\t" || text[at] === "\r") { at++; continue; }
    if (text[at] === "#") break;
    const quoted = text[at] === '"', from = at;
    if (quoted) at = quote_end(text, at + 1, end);
    else while (at < end && !/[ \t\r#]/.test(text[at])) at++;
    out.push({text: quoted ? text.slice(from + 1, at - 1) : text.slice(from, at), start: from, end: at, quoted});
  }
  return out;
}

/* Returns the statements of a text: {line, words, start, end}. The words of a material may stand on several lines. */
function statements_of(text) {
  const out = [];
  let line = 0, open = null, depth = 0;
  for (let start = 0; start <= text.length;) {
    const at = text.indexOf("\n", start), end = at < 0 ? text.length : at, words = words_of(text, start, end);
    line++;
    if (words.length > 0 && !open) out.push(open = {line, words: [], start: words[0].start, end});
    if (open) {
      open.words.push(...words);
      if (words.length > 0) open.end = words[words.length - 1].end;
      for (const word of words) depth += !word.quoted && word.text === "{" ? 1 : !word.quoted && word.text === "}" ? -1 : 0;
      if (depth <= 0) { open = null; depth = 0; }
    }
    start = end + 1;
  }
  return out;
}

const replaced = (text, {start, end}, by) => text.slice(0, start) + by + text.slice(end);
const as_word = text => /^[^\s"#{}]+$/.test(text) ? text : `"${text}"`;
/* A number as a scene has it: short, and the same when it is read again. */
const as_number = value => String(+value.toPrecision(8)).replace(/^-0$/, "0");
const as_vector = vector => vector.map(as_number).join(" ");

const statement_at = (text, line) => statements_of(text).find(one => one.line === line);
const statement_named = (text, name) => statements_of(text).find(({words}) => words[0].text === name);

/* Puts a statement in the place of the one of its name, or in front of all others. */
function with_statement(text, name, words) {
  const found = statement_named(text, name), first = statements_of(text)[0];
  if (found) return replaced(text, found, `${name} ${words}`);
  const at = first ? first.start : text.length;
  return text.slice(0, at) + `${name} ${words}\n` + text.slice(at);
}

/* ---- the camera ---- */

/* Writes a camera; keeps `near` and `far` only where the statement has them. */
function with_camera(text, camera) {
  const found = statement_named(text, "camera"), given = found ? found.words.map(({text}) => text) : [];
  const depth = ["near", "far"].filter(word => given.includes(word)).map(word => `${word} ${as_number(camera[word])} `);
  return with_statement(text, "camera", `${camera.perspective ? "perspective" : "ortho"} ${as_number(camera.extent)} ` +
    `${depth.join("")}eye ${as_vector(camera.eye)} look ${as_vector(camera.look)} up ${as_vector(camera.up)}`);
}

/* ---- lights ---- */

/* Light statements are: light SPECTRUM INTENSITY position|direction X Y Z ..., ambient SPECTRUM INTENSITY. */
function with_light(text, line, {spectrum, intensity, vector, shadows}) {
  const found = statement_at(text, line), place = found.words.findIndex(({text}) => text === "position" || text === "direction");
  const changes = [];
  if (spectrum !== undefined) changes.push([found.words[1], as_word(spectrum)]);
  if (intensity !== undefined) changes.push([found.words[2], as_number(intensity)]);
  if (vector !== undefined) changes.push([{start: found.words[place + 1].start, end: found.words[place + 3].end}, as_vector(vector)]);
  const word = found.words.findIndex(({text, quoted}, i) => i > 2 && !quoted && text === "shadows");
  if (shadows && word < 0) changes.push([{start: found.end, end: found.end}, " shadows"]);
  if (shadows === false && word > 0) changes.push([{start: found.words[word - 1].end, end: found.words[word].end}, ""]);
  return changes.sort((a, b) => b[0].start - a[0].start).reduce((all, [range, by]) => replaced(all, range, by), text);
}

/* ---- objects ---- */

const OBJECT_WORDS = new Set(["material", "materials", "scale", "rotate", "translate", "two-sided", "casts", "planar",
  "repeat", "displace", "unitize", "crease"]);

const is_checker = ({words}) => words[0].text === "checker";
const has_shape = ({words}) => ["object", "checker"].includes(words[0].text);

/* Returns the parts of the statement of an object, or of a checker behind its list: the shape, and each option with its words. */
function object_parts(statement) {
  const parts = [{name: "shape", words: []}];
  for (const word of statement.words.slice(is_checker(statement) ? 2 : 1)) {
    const option = !word.quoted && OBJECT_WORDS.has(word.text);
    if (option) parts.push({name: word.text, words: []});
    else parts[parts.length - 1].words.push(word);
  }
  return parts.map(({name, words}) => ({name, values: words.map(({text}) => text)}));
}

function parts_text(parts, head = "object") {
  const words = ({name, values}) => (name === "shape" ? [] : [name]).concat(values.map(as_word));
  return [head, ...parts.flatMap(words)].join(" ");
}

/* Changes the parts of the object or checker whose statement begins in a line. */
function with_object(text, line, change) {
  const found = statement_at(text, line), parts = object_parts(found);
  change(parts);
  return replaced(text, found, parts_text(parts, is_checker(found) ? `checker ${as_word(found.words[1].text)}` : "object"));
}

/* Changes the parts of all objects, but for those that lie behind all others. */
const with_objects = (text, change) => statements_of(text).filter(has_shape).reverse().reduce((left, {line}) => with_object(left, line, parts =>
  parts.some(({name, values}) => name === "material" && /^back(ground|drop)$/.test(values[0])) || change(parts)), text);

const last_of = parts => parts[parts.length - 1];

/* Moves an object: adds to its last translation. */
function move_object(parts, by) {
  if (last_of(parts).name !== "translate") parts.push({name: "translate", values: ["0", "0", "0"]});
  const last = last_of(parts);
  last.values = last.values.map((value, i) => as_number(Number(value) + by[i]));
}

/* Turns a vector about an axis of length 1 (Rodrigues). */
function turned(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)], along = axis.reduce((sum, value, i) => sum + value * v[i], 0) * (1 - c);
  const side = [axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]];
  return v.map((value, i) => value * c + side[i] * s + axis[i] * along);
}

/* What the transforms do to a place. */
const TRANSFORMS = {
  translate: (place, by) => place.map((value, i) => value + by[i]),
  scale: (place, by) => place.map((value, i) => value * by[by.length === 3 ? i : 0]),
  rotate: (place, [angle, ...axis]) => turned(place, axis.map(value => value / Math.hypot(...axis)), angle * Math.PI / 180),
};

/* Returns where the transforms put the object's own origin. */
const origin_of = parts => parts.filter(({name}) => TRANSFORMS[name])
  .reduce((place, {name, values}) => TRANSFORMS[name](place, values.map(Number)), [0, 0, 0]);

/* Ends the transforms with a translation from the origin to the object's place. */
function end_with_place(parts) {
  const place = origin_of(parts), last = last_of(parts);
  if (last.name === "translate" && place.every((value, i) => Math.abs(value - Number(last.values[i])) < 1e-9)) return;
  if (place.some(value => value !== 0)) parts.push({name: "translate", values: place.map(value => as_number(-value))});
  parts.push({name: "translate", values: place.map(as_number)});
}

/* Puts a transform before the last translation, so that the object turns or grows about its own place. `merge` joins it
 * with an equal one before, and returns false if it cannot. */
function insert_transform(parts, part, merge) {
  end_with_place(parts);
  const before = parts[parts.length - 2];
  if (before.name !== part.name || !merge(before)) parts.splice(parts.length - 1, 0, part);
}

function scale_object(parts, factor) {
  insert_transform(parts, {name: "scale", values: [as_number(factor)]}, before => {
    before.values = before.values.map(value => as_number(Number(value) * factor));
    return true;
  });
}

function rotate_object(parts, angle, axis) {
  const vector = axis.map(as_number);
  insert_transform(parts, {name: "rotate", values: [as_number(angle), ...vector]}, before => {
    if (before.values.slice(1).join() !== vector.join()) return false;
    before.values[0] = as_number((Number(before.values[0]) + angle) % 360);
    return true;
  });
}

function set_part(parts, name, values, also = []) {
  const found = parts.find(part => part.name === name || also.includes(part.name));
  if (found) Object.assign(found, {name, values});
  else parts.splice(1, 0, {name, values});
}

/* Gives an object another shape, by its words: "teapot", "mesh chair". */
function give_shape(parts, words) {
  parts[0].values = words.split(" ");
  for (const name of ["unitize", "crease"]) remove_part(parts, name);
  if (parts[0].values[0] === "mesh") parts.splice(1, 0, {name: "unitize", values: []});
  fit_relief(parts);
}

/* The divisions from which on a shape shows a relief, behind its lengths by the first one. */
const DIVIDED = {sphere: [[], [96, 48]], torus: [[3], [48, 96]], box: [[1, 1], [32]], plane: [[1], [64]], cylinder: [[2], [96, 32]],
  cone: [[2], [96, 32]], disk: [[], [96, 32]], teapot: [[], [20]]};

const has_part = (parts, word) => parts.some(({name}) => name === word);

function remove_part(parts, word) {
  const at = parts.findIndex(({name}) => name === word);
  if (at > 0) parts.splice(at, 1);
}

/* Gives an object a relief; "": takes it away. */
function set_relief(parts, relief, height) {
  if (!relief) return remove_part(parts, "displace");
  set_part(parts, "displace", [relief, as_number(height)]);
  fit_relief(parts);
}

/* Gives a shape with a relief as many divisions as show it, and a mesh texture coordinates, which may lack them. */
function fit_relief(parts) {
  if (!has_part(parts, "displace")) return;
  if (parts[0].values[0] === "mesh") set_part(parts, "planar", []);
  const [kind, first = kind === "torus" ? "0.25" : "1", ...sizes] = parts[0].values, fine = DIVIDED[kind];
  if (!fine) return;
  const lengths = fine[0].map((ratio, i) => sizes[i] ?? as_number(ratio * first));
  const counts = fine[1].map((count, i) => String(Math.max(count, Number(sizes[lengths.length + i] ?? 0))));
  parts[0].values = [kind, first, ...lengths, ...counts];
}

/* ---- the thesis's grid ---- */

/* Returns the transform of object i of n of a checker, as statements have it: see `checker` in the scene language. */
function grid_parts(i, n) {
  const rows = n <= 3 ? 1 : n <= 8 ? 2 : n <= 15 ? 3 : 4, scale = [1, 0.66, 0.5, 0.333][rows - 1];
  const columns = Math.ceil(n / rows);
  const place = [6 * (i % columns) - 3 * (columns - 1), 3 * (rows - 1) - 6 * Math.floor(i / columns), 0];
  return [{name: "scale", values: [String(scale)]}, {name: "translate", values: place.map(value => as_number(scale * value))}];
}

/* Replaces a checker by its objects. materials: the name and the file of each. */
function with_checker_opened(text, line, materials) {
  const found = statement_at(text, line), defined = new Map(), lines = [];
  const pattern = object_parts(found);
  for (const {words} of statements_of(text))
    if (words[0].text === "material") defined.set(words[1].text, words[2] && words[2].text);
  materials.forEach(({name, file}, i) => {
    let own = name;
    for (let n = 2; defined.has(own) && defined.get(own) !== file; n++) own = `${name}-${n}`;
    if (!defined.has(own)) lines.push(`material ${as_word(own)} ${as_word(file)}`);
    defined.set(own, file);
    const [shape, ...options] = pattern;
    lines.push(parts_text([shape, {name: "material", values: [own]}, ...options, ...grid_parts(i, materials.length)]));
  });
  return replaced(text, found, lines.join("\n"));
}

/* ---- materials ---- */

/* Sets or removes (value null) a word with its value between the braces of a material. */
function with_material_word(text, name, word, value) {
  const found = statements_of(text).find(({words}) => words[0].text === "material" && words[1] && words[1].text === name);
  const at = found.words.findIndex((one, i) => i > 2 && !one.quoted && one.text === word);
  const more = word === "texture" || word === "spectral-texture" ? 2 : 1;
  if (at > 0) {
    const range = {start: found.words[at].start, end: found.words[at + more].end};
    return replaced(text, range, value === null ? "" : `${word} ${value}`);
  }
  const close = found.words[found.words.length - 1];
  return value === null ? text : replaced(text, {start: close.start, end: close.start}, `${word} ${value} `);
}
