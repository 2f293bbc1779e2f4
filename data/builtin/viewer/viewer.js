/* SPDX-License-Identifier: MIT */
/* The page: its controls, the picked pixel, its start. */

/* ---- controls ---- */

const canvas = element("picture");

function fill_select(select, names, selected) {
  names.forEach((name, i) => select.add(new Option(name, i, i === selected, i === selected)));
}

const numeric_order = new Intl.Collator("en", {numeric: true});

/* Fills a menu with lamps, f2 before f10. Equal energy has two names, 1 and e: where the scene has 1, e is left out. */
function fill_lamps(select, selected) {
  const used = i => SOURCES.some(([kind]) => scene[kind].some(({illuminant}) => illuminant === i));
  const lamps = scene.illuminants.map(({name}, i) => ({name, i})).sort((a, b) => numeric_order.compare(a.name, b.name));
  const twice = ({name, i}) => name === "e" && !used(i) && lamps.some(other => other.name === "1");
  for (const {name, i} of lamps.filter(lamp => !twice(lamp)))
    select.add(new Option(/^[1e]$/.test(name) ? `${name} (equal energy)` : name, i, i === selected, i === selected));
}

const SOURCES = [["ambients", "Ambient"], ["lights", "Light"]];
const FEW_SOURCES = 3;

/* Returns the place for a light's controls. More than a few lights are a list, where one form is open at a time. */
function place_of_source(id) {
  if (scene.ambients.length + scene.lights.length <= FEW_SOURCES) return element("sources");
  const item = document.createElement("details"), head = document.createElement("summary");
  item.setAttribute("name", "source");
  head.id = id + "-head";
  item.append(head);
  element("sources").append(item);
  return item;
}

/* Names each light of a list, with what it shines. */
function show_source_heads() {
  for (const [kind, name] of SOURCES)
    source_ids(kind).forEach((id, i) => {
      const {illuminant, intensity} = sources[kind][i];
      if (element(id + "-head")) set_text(id + "-head", `${name}${number_of(kind, i)}: ${scene.illuminants[illuminant].name} × ${+intensity.toPrecision(4)}`);
    });
}

/* Adds a row of controls for one light. The ids of its controls begin with `id`. */
function add_source(name, id, source) {
  const row = document.createElement("div");
  row.className = "row";
  row.innerHTML = `<label for="${id}">${name}</label><select id="${id}"></select><span></span>
    <div><input type="range" id="${id}-slider" min="0" step="0.01" aria-label="Intensity of ${name}">
    <input type="number" id="${id}-intensity" min="0" step="any"
      aria-label="Intensity of ${name}, as a number"></div>`;
  place_of_source(id).append(row);
  const slider = element(id + "-slider"), number = element(id + "-intensity");
  fill_lamps(element(id), source.illuminant);
  slider.max = Math.max(1, 2 * source.intensity);
  slider.defaultValue = number.defaultValue = source.intensity;
  slider.addEventListener("input", () => number.value = slider.value);
  number.addEventListener("input", () => slider.value = amount(number.id));
}

const source_ids = kind => scene[kind].map((_, i) => `${kind}-${i + 1}`);

/* A single ambient light has no number. */
const number_of = (kind, i) => kind === "lights" || scene[kind].length > 1 ? ` ${i + 1}` : "";

function add_controls() {
  for (const [kind, name] of SOURCES)
    source_ids(kind).forEach((id, i) => add_source(name + number_of(kind, i), id, scene[kind][i]));
  fill_eye_menus();
}

/* Fills the menus of the eye with what the description has. */
function fill_eye_menus() {
  for (const [id, selected] of [["detector", scene.detector || "cie1931"], ["adaptation", "none"], ["display", scene.display || "srgb"]]) {
    const names = scene[id + "s"].map(({name}) => name);
    element(id).replaceChildren();
    fill_select(element(id), names, Math.max(0, names.indexOf(selected)));
  }
}

/* Returns the number in a field. A text that is no number, and a negative number, count as 0. */
const amount = id => Math.max(0, element(id).valueAsNumber || 0);

function read_sources() {
  const read = kind => source_ids(kind).map(id =>
    ({illuminant: Number(element(id).value), intensity: amount(id + "-intensity")}));
  return {ambients: read("ambients"), lights: read("lights")};
}

/* Returns the choice of an eye: see eye_of. */
function read_choice() {
  const chosen = id => Number(element(id).value);
  return {detector: chosen("detector"), adaptation: chosen("adaptation"), display: chosen("display"),
    luminance: amount("luminance"), view: element("scene-view").value, band: chosen("scene-band")};
}

const wanted_exposure = () => element("auto").checked ? null : amount("exposure");

/* ---- facts ---- */

let sources, eye, white, exposure;

/* Numbers are written as the reader's language writes them. */
const with_decimals = digits => new Intl.NumberFormat(undefined,
  {minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false, signDisplay: "negative"});
const with_digits = digits => new Intl.NumberFormat(undefined,
  {minimumSignificantDigits: digits, maximumSignificantDigits: digits, useGrouping: false});
const short_number = new Intl.NumberFormat(undefined, {maximumSignificantDigits: 12, useGrouping: false});
const percent = part => with_decimals(2).format(100 * part) + "\u00a0%";
const figures = (values, digits) => Array.from(values, value => with_decimals(digits).format(value).replace("-", "−"));

function show_message(text) {
  set_text("message", text);
  element("message").hidden = text === "";
}

function show_title() {
  const lights = sources.ambients.concat(sources.lights).filter(({intensity}) => intensity > 0);
  const names = [...new Set(lights.map(({illuminant}) => scene.illuminants[illuminant].name))];
  const under = names.join(", ") || "no light";
  set_text("caption", `${scene.scene} under ${under}, seen by ${eye.detector.name}`);
  document.title = `${element("caption").textContent} – spectral`;
}

function show_facts(outside) {
  const names = eye.detector.observer ? ["x", "y", "z"] : ["r", "g", "b"];
  set_text("gamut", `Out of gamut: ${outside} of ${n_pixels} pixels (${percent(outside / n_pixels)}).`);
  set_text("lost", "The detector's sensitivity outside the picture's wavelengths: " +
    names.map((name, i) => `${name} ${percent(eye.detector.lost[i])}`).join(", ") + ".");
  const xyz = white && apply(observer().weights, white.radiance);
  set_text("white", xyz ? "White: the mean of the lights, x " + figures(chromaticity(xyz), 4).join(", y ") +
    `, Y ${figures([xyz[1]], 2)}.` : "No light shines, so there is no white.");
}

function show_controls() {
  const {detector, adaptation} = eye;
  element("scene-band").max = n_bands - 1; /* a band beyond it becomes the last one */
  element("scene-band-row").hidden = element("scene-view").value === "detector";
  set_text("scene-band-nm", `${scene.wavelengths[Number(element("scene-band").value)]} nm`);
  element("adaptation").disabled = !detector.observer;
  element("luminance-row").hidden = !detector.observer || !adaptation.incomplete;
  element("luminance").placeholder = white ? String(+(10 * white.intensity).toPrecision(6)) : "";
  element("exposure").disabled = element("auto").checked;
  if (element("auto").checked) element("exposure").value = +exposure.toPrecision(6);
}

/* ---- commands ---- */

const quoted = word => /^[\w.,:/*=@%+-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;

function wavelengths_text() {
  const nm = scene.wavelengths, step = n_bands > 1 ? nm[1] - nm[0] : 1;
  const even = n_bands > 1 && nm.every((value, i) => value === nm[0] + i * step);
  return even ? `${nm[0]}:${nm[n_bands - 1]}:${step}` : nm.join(",");
}

function command_lines() {
  const word_of = ({illuminant, intensity}) => `${scene.illuminants[illuminant].word}*${intensity}`;
  const changed = (kind, i) => word_of(sources[kind][i]) !== word_of(scene[kind][i]);
  const other_ambient = sources.ambients.some((_, i) => changed("ambients", i));
  if (other_ambient && sources.ambients.length > 1)
    return "The command line can set one ambient light only. A scene file can set more.";
  const render = ["spectral render", quoted(scene.scene), "--renderer raster",
    `--size ${shape.width}x${shape.height}`, ...(side > 1 ? [`--samples ${side}`] : []),
    "--wavelengths", wavelengths_text()];
  const {view, band} = read_choice();
  const develop = ["spectral develop picture.tif", "--detector", quoted(eye.detector.name),
    "--display", quoted(eye.display.name), "--exposure", element("auto").checked ? "auto" : exposure];
  sources.lights.forEach((light, i) => {
    if (changed("lights", i)) render.push("--light", quoted(`${i + 1}=${word_of(light)}`));
  });
  if (other_ambient) render.push("--ambient", quoted(word_of(sources.ambients[0])));
  if (view !== "detector") return render.concat(`-o picture.tif  # page ${band + 1} is this band`).join(" ");
  if (eye.detector.observer)
    develop.push("--adaptation", eye.adaptation.name +
      (eye.adaptation.incomplete && eye.luminance ? `:${eye.luminance}` : ""));
  return render.concat("-o picture.tif &&").concat(develop, "-o developed.tif").join(" ");
}

/* ---- the picked pixel ---- */

let cursor = null;
let pixel = null;   /* the picked pixel */
let hovered = null; /* the pixel under the pointer */
let kept = null;    /* {name, radiance, white}: a pixel for comparison, and the white of its light */
const hidden = new Set(); /* names of curves that are not drawn */

/* XYZ needs an observer: a camera has no tristimulus values. */
const observer = () => eye.detector && eye.detector.observer ? eye.detector : standard_observer;

function object_name(surface) {
  if (surface === 0) return "background";
  const {name, shape, half} = scene.objects[surface - 1];
  return `${surface}. ${name}${half ? `, ${half} half` : ""} (${shape})`;
}

/* Returns the number of the other half of an object of two metameric halves; 0: there is none. */
function other_half(surface) {
  const {half} = scene.objects[surface - 1] || {};
  return half === "left" ? surface + 1 : half === "right" ? surface - 1 : 0;
}

/* Returns the curves of the lights. Lights of the same illuminant and intensity share a curve. */
function light_curves() {
  const alike = new Map();
  for (const [kind, name] of [["ambients", "ambient"], ["lights", "light"]])
    sources[kind].forEach(({illuminant, intensity}, i) => {
      const key = `${illuminant} ${intensity}`;
      if (intensity > 0 && !alike.has(key)) alike.set(key, {illuminant, intensity, names: []});
      if (intensity > 0) alike.get(key).names.push(name + number_of(kind, i));
    });
  return [...alike.values()].map(({illuminant, intensity, names}, i) => ({style: "numbered light", look: look_of(i), axis: "light",
    name: `${names.join(", ")} (${scene.illuminants[illuminant].name})`,
    values: radiance_of({illuminant}).map(value => intensity * value)}));
}

/* Returns the detector's functions, so that the largest value is 1. They are not drawn until they are switched on. */
function detector_curves() {
  const {name, weights, observer} = eye.detector, largest = Math.max(...weights.flat());
  return weights.map((row, i) => ({name: `${name} ${(observer ? "xyz" : "rgb")[i]}`, style: `sees-${"rgb"[i]}`, axis: "relative",
    off: true, values: row.map(value => value / largest)}));
}

/* Returns the curves of a pixel with their classes and axes: see AXES. */
function curves_at(pixel) {
  const curves = [{name: "radiance", style: "radiance", values: radiance_at(pixel, sources, terms_of)}];
  const material = shown[pixel] > 0 ? material_of(shown[pixel]) : {};
  const named = [["diffuse", "reflectance"], ["specular", "specular reflectance"],
    ["excitation", "excitation"], ["emission", "emission"]];
  if (is_hovered()) curves.push({name: "under the pointer", style: "hovered", values: radiance_at(hovered, sources, terms_of)});
  if (kept) curves.push({name: kept.name, style: "kept", values: kept.radiance});
  if (material.luminescence)
    curves.push({name: "fluorescence", style: "fluorescence",
      values: radiance_at(pixel, sources, fluorescence_of)});
  curves.push(...light_curves());
  if (material.glow) curves.push({name: "own light", style: "glow", values: material.glow});
  for (const [style, name] of named)
    if (material[style]) curves.push({name, style, values: material[style], axis: "relative"});
  const other = other_half(shown[pixel]), {diffuse} = other ? material_of(other) : {};
  if (diffuse) curves.push({name: `reflectance of the ${scene.objects[other - 1].half} half`, style: "partner", values: diffuse, axis: "relative"});
  return curves.concat(detector_curves());
}

/* Returns L*a*b* of a pixel relative to the white of its own light; null without a white. */
function lab_of({radiance, white}) {
  const {weights} = observer(), of_white = white && apply(weights, white.radiance);
  return of_white && of_white[1] > 0 ? cielab(apply(weights, radiance), of_white) : null;
}

function colour_rows(radiance) {
  const xyz = apply(observer().weights, radiance), lab = lab_of({radiance, white});
  const other = kept && lab_of(kept);
  const rows = [["XYZ", figures(xyz, 4)], ["x, y", figures(chromaticity(xyz), 5)]];
  if (lab) rows.push(["L*a*b*", figures(lab, 3)]);
  if (lab && other)
    rows.push(["ΔE00 to the kept", figures([ciede2000(other, lab)], 3)]);
  return rows;
}

function channel_rows() {
  const codes = [0, 1, 2].map(channel => encoders(eye.display)[channel](linear[channel][pixel] * exposure));
  return [["RGB, linear", figures(linear.map(channel => channel[pixel] * exposure), 5)],
    ["RGB, 0 to 255", codes.map(String)]];
}

/* Makes a row of a table. A cell whose scope is not empty is a head. */
function table_row(texts, head_scope = i => i === 0 ? "row" : "") {
  const row = document.createElement("tr");
  row.append(...texts.map((text, i) => {
    const scope = head_scope(i), cell = document.createElement(scope ? "th" : "td");
    if (scope) cell.scope = scope;
    cell.textContent = text;
    return cell;
  }));
  return row;
}

function show_numbers(rows) {
  const key = JSON.stringify(rows);
  if (element("numbers").dataset.shown === key) return; /* screen readers need not repeat it */
  element("numbers").dataset.shown = key;
  element("numbers").replaceChildren(...rows.map(([name, values]) =>
    table_row([name, ...values, ...Array(3 - values.length).fill("")])));
}

/* ---- picking ---- */

const pixel_words = pixel => is_stack() ? stack_pixel_words(pixel) : `pixel ${place_of(pixel).join(", ")}: ${object_name(shown[pixel])}`;
const sentence = words => words[0].toUpperCase() + words.slice(1);

function show_pixel() {
  if (is_stack()) return show_stack_pixel();
  if (pixel === null || pixel >= n_pixels) return;
  const curves = curves_at(pixel);
  set_text("picked", sentence(pixel_words(pixel)));
  show_numbers(colour_rows(curves[0].values).concat(element("scene-view").value === "detector" ? channel_rows() : []));
  show_plot(curves);
  show_legend(curves);
  show_values(curves);
}

function move_cursor(x, y) {
  cursor = {x: clamp(x, 0, shape.width - 1), y: clamp(y, 0, shape.height - 1)};
  for (const cross of [element("cross"), element("cross-2")].filter(one => one)) {
    cross.style.left = `${(cursor.x + 0.5) / shape.width * 100}%`;
    cross.style.top = `${(cursor.y + 0.5) / shape.height * 100}%`;
  }
  show_cross();
}

function pick(x, y) {
  move_cursor(x, y);
  pixel = cursor.y * shape.width + cursor.x;
  element("objects").value = shown[pixel];
  show_pixel();
}

/* The same by the user: in a live page the object is then the chosen one. */
function choose(x, y) {
  if (is_stack()) return pointing() === "pick" && pick_stack(x, y);
  pick(x, y);
  if (is_live()) choose_object(shown[pixel]);
}

function pick_by_key(event) {
  const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
  const step = steps[event.key], by = event.shiftKey ? 10 : 1;
  if (step) move_cursor(cursor.x + by * step[0], cursor.y + by * step[1]);
  else if (event.key === "Enter" || event.key === " ") choose(cursor.x, cursor.y);
  else return;
  event.preventDefault();
}

/* Returns where in the picture the pointer is, in pixels. A click has the corner of a screen pixel. Its middle is meant. */
function place_under({clientX, clientY}) {
  const box = canvas.getBoundingClientRect();
  return [(clientX + 0.5 - box.left) / box.width * shape.width, (clientY + 0.5 - box.top) / box.height * shape.height];
}

function pick_by_pointer(event) {
  if (!panned) choose(...place_under(event).map(Math.floor));
}

const is_hovered = () => hovered !== null && hovered !== pixel && hovered < n_pixels;

/* Shows the spectrum of the pixel under the pointer beside that of the picked one, unless the pointer drags something. */
function hover(event) {
  const [x, y] = place_under(event).map(Math.floor), before = hovered;
  const inside = event.type !== "pointerleave" && event.buttons === 0 && x >= 0 && y >= 0 && x < shape.width && y < shape.height;
  hovered = inside ? y * shape.width + x : null;
  if (hovered === before || pixel === null) return;
  set_text("at-cursor", inside ? `Under the pointer: ${pixel_words(hovered)}` : "");
  show_pixel();
}

/* ---- zooming; in a live page a drag, the plain wheel, fingers, + and - move the camera instead ---- */

const zoom = {scale: 1, x: 0, y: 0}; /* 1: the picture fits; where the frame's corner is, off its place */
const MOST_ZOOM = 64;
const fingers = new Map(); /* pointers on the picture: where each was last */
let panned = false;        /* a drag has moved the picture: its end is no click */

const both_frames = () => [element("frame"), element("frame-2")];

/* Returns a length of the frame, "width" or "height", in which the picture fits. */
const frame_size = name => parseFloat(getComputedStyle(element("frame"))[name]);

/* Returns the width of a pixel of the picture, in pixels of the page. */
const pixel_size = () => frame_size("width") * zoom.scale / shape.width;

/* Moves and scales the frames, so that they cover their places. A picture that is smaller stands in the middle. */
function show_zoom() {
  const {scale} = zoom;
  const placed = (at, length) => scale > 1 ? clamp(at, length * (1 - scale), 0) : length * (1 - scale) / 2;
  Object.assign(zoom, {x: placed(zoom.x, frame_size("width")), y: placed(zoom.y, frame_size("height"))});
  const whole = value => `${Math.round(value)}px`; /* so that 1:1 is not blurred */
  for (const {style} of both_frames())
    for (const [name, value] of [["--x", whole(zoom.x)], ["--y", whole(zoom.y)], ["--zoom", scale]]) style.setProperty(name, value);
  document.body.classList.toggle("enlarged", scale > 1);
  canvas.style.touchAction = scale > 1 ? "none" : "";
  set_text("zoom-figure", with_decimals(0).format(100 * pixel_size()) + "\u00a0%");
  choose_scaling();
  if (is_live()) show_handles(); /* they keep their size */
}

/* Zooms by a factor, at most to fit or to 1:1, whichever is smaller. The point at x, y in the window stays where it is. */
function zoom_at(x, y, factor) {
  const box = element("frame").getBoundingClientRect(), before = zoom.scale;
  zoom.scale = clamp(before * factor, Math.min(1, before / pixel_size()), MOST_ZOOM);
  zoom.x += (x - box.left) * (1 - zoom.scale / before);
  zoom.y += (y - box.top) * (1 - zoom.scale / before);
  show_zoom();
}

/* Shows pixels so large. The cross stays where it is; if it is out of sight, the border that is next to it does. */
function zoom_to(size) {
  const cross = element("cross").getBoundingClientRect(), place = element("frame").parentElement.getBoundingClientRect();
  zoom_at(clamp(cross.left + cross.width / 2, place.left, place.right), clamp(cross.top + cross.height / 2, place.top, place.bottom),
    size / pixel_size());
}

function fit_picture() {
  zoom.scale = 1;
  show_zoom();
}

/* To the next power of two: pixels of the picture then are whole pixels of the page, from 1:1 on. */
const zoom_in = () => zoom_to(2 ** (Math.floor(Math.log2(pixel_size()) + 0.01) + 1));
const zoom_out = () => zoom_to(2 ** (Math.ceil(Math.log2(pixel_size()) - 0.01) - 1));

const ZOOM_KEYS = {"0": fit_picture, "1": () => zoom_to(1), "+": zoom_in, "=": zoom_in, "-": zoom_out};

function zoom_by_key(event) {
  const act = !(is_live() && /[-+=]/.test(event.key)) && ZOOM_KEYS[event.key];
  if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  act();
}

/* The wheel scrolls the page as long as the picture fits. */
function zoom_by_wheel(event) {
  if (!event.ctrlKey && (is_live() || zoom.scale <= 1)) return;
  event.preventDefault();
  event.stopPropagation(); /* a live page's camera stays */
  zoom_at(event.clientX, event.clientY, 2 ** (-event.deltaY * (event.deltaMode === 1 ? 16 : 1) / 240));
}

/* Shifts an enlarged picture, so that the cross and its pixel are in sight. */
function show_cross() {
  const margin = Math.max(12, pixel_size() / 2);
  const shifted = (at, place, length) => length > 2 * margin ? clamp(at, margin - place, length - margin - place) : length / 2 - place;
  zoom.x = shifted(zoom.x, (cursor.x + 0.5) * pixel_size(), frame_size("width"));
  zoom.y = shifted(zoom.y, (cursor.y + 0.5) * pixel_size(), frame_size("height"));
  show_zoom();
}

/* Follows one pointer, which shifts a picture that is zoomed in, or two, which zoom. */
function follow_finger(event) {
  const last = fingers.get(event.pointerId), others = [...fingers].filter(([id]) => id !== event.pointerId);
  if (is_live() || !last) return;
  const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
  if (others.length === 1) {
    const [[, other]] = others, apart = ({x, y}) => Math.hypot(x - other.x, y - other.y) || 1;
    const now = {x: event.clientX, y: event.clientY};
    zoom_at((now.x + other.x) / 2, (now.y + other.y) / 2, apart(now) / apart(last));
    panned = true;
  } else if (zoom.scale > 1 && (panned || Math.hypot(dx, dy) > 4) && !(is_stack() && pointing() !== "pick")) {
    Object.assign(zoom, {x: zoom.x + dx, y: zoom.y + dy});
    show_zoom();
    panned = true;
  } else return;
  fingers.set(event.pointerId, {x: event.clientX, y: event.clientY});
}

function listen_to_zoom() {
  const leave = event => fingers.delete(event.pointerId);
  element("frame").addEventListener("wheel", zoom_by_wheel, {passive: false, capture: true});
  canvas.addEventListener("keydown", zoom_by_key);
  for (const [id, act] of [["fit", fit_picture], ["one-to-one", ZOOM_KEYS[1]], ["reduce", zoom_out], ["enlarge", zoom_in]])
    element(id).addEventListener("click", act);
  new ResizeObserver(() => { if (shape) show_zoom(); }).observe(element("frame")); /* a stack is read later */
  canvas.addEventListener("pointerdown", event => {
    if (fingers.size === 0) panned = false;
    fingers.set(event.pointerId, {x: event.clientX, y: event.clientY});
  });
  canvas.addEventListener("pointermove", follow_finger);
  for (const name of ["pointerup", "pointercancel", "pointerleave"]) canvas.addEventListener(name, leave);
}

/* Shows an enlarged picture without smoothing, so that pixels keep their colours. */
function choose_scaling() {
  for (const one of [canvas, element("picture-2")])
    one.style.imageRendering = pixel_size() * devicePixelRatio >= 1.5 ? "pixelated" : "auto";
}

/* Returns the objects that are seen: {surface, n: pixels, x, y: the sums of their places, beside: its neighbours}. */
function seen_objects() {
  const seen = new Map();
  shown.forEach((surface, i) => {
    const [x, y] = place_of(i);
    if (!seen.has(surface)) seen.set(surface, {surface, n: 0, x: 0, y: 0, beside: new Set()});
    const one = seen.get(surface);
    Object.assign(one, {n: one.n + 1, x: one.x + x, y: one.y + y});
    for (const other of [x > 0 ? shown[i - 1] : surface, y > 0 ? shown[i - shape.width] : surface])
      if (other !== surface) { one.beside.add(other); seen.get(other).beside.add(surface); }
  });
  return [...seen.values()];
}

/* Returns the place that a page opens with: in the middle of the object with the most pixels that is not behind all others. The
 * background is; without it the object with the most neighbours, if they are half of all others, as a wall or a table has. */
function first_place() {
  const all = seen_objects(), neighbours = ({surface, beside}) => surface === 0 ? Infinity : beside.size;
  const behind = all.reduce((most, one) => (neighbours(one) - neighbours(most) || one.n - most.n) > 0 ? one : most);
  const before = all.filter(one => one !== behind || 2 * neighbours(one) < all.length - 1);
  const {surface, n, x, y} = (before.length > 0 ? before : all).reduce((most, one) => one.n > most.n ? one : most);
  const apart = i => Math.hypot(place_of(i)[0] - x / n, place_of(i)[1] - y / n);
  const nearest = shown.reduce((best, one, i) => one === surface && (best < 0 || apart(i) < apart(best)) ? i : best, -1);
  return {x: place_of(nearest)[0], y: place_of(nearest)[1]};
}

/* Finds for each visible object the pixel that reflects most, without highlights. */
function best_pixels() {
  const best = new Map();
  for (let i = 0; i < n_pixels; i++) {
    let weight = 0;
    for (const position of positions_of(i))
      for (let t = 0; t < weights.length; t += t > 0 ? 2 : 1)
        weight += weights[t][position] * shape.weight_scales[t];
    if (!best.has(shown[i]) || weight > best.get(shown[i]).weight) best.set(shown[i], {i, weight});
  }
  return best;
}

/* Lists the objects that can be seen. */
function refresh_objects() {
  const seen = [...best_pixels().keys()].sort((a, b) => a - b), select = element("objects"), key = seen.map(object_name).join("\n");
  if (select.dataset.key === key) return; /* so that an open menu stays open */
  select.replaceChildren(...seen.map(surface => new Option(object_name(surface), surface)));
  select.dataset.key = key;
  if (pixel !== null && pixel < n_pixels) select.value = shown[pixel];
}

function pick_object() {
  const best = best_pixels().get(Number(element("objects").value));
  if (best) choose(...place_of(best.i));
}

function keep() {
  kept = kept ? null : {name: `kept: ${object_name(shown[pixel])}`, white,
    radiance: radiance_at(pixel, sources, terms_of)};
  set_text("keep", kept ? "Forget the kept pixel" : "Keep for comparison");
  show_pixel();
}

/* ---- start and redraw ---- */

function show_picture({width, height, data}) {
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
  canvas.getContext("2d").putImageData(new ImageData(data, width, height), 0, 0);
  element("first")?.remove();
}

/* Shows the colours of a map below it, with values at even steps up to the largest; null: there is no map. */
function show_map_legend(largest, unit) {
  const legend = element("map-legend"), value = part => with_digits(4).format(part * largest);
  legend.hidden = largest === null;
  if (largest === null) return;
  legend.style.background = `linear-gradient(to right, ${RAMP.map(rgb => `rgb(${rgb})`).join()}) no-repeat 0 0 / 100% 0.9rem`;
  legend.replaceChildren(...["0", ...[0.25, 0.5, 0.75].map(value), `${value(1)} ${unit}`].map(text => Object.assign(document.createElement("span"), {textContent: text})));
}

/* Keeps a copy of the picture beside the one that goes on changing, or takes it away. */
function keep_picture() {
  const second = element("picture-2"), keeps = element("frame-2").hidden;
  element("frame-2").hidden = !keeps;
  document.body.classList.toggle("beside", keeps);
  set_text("keep-picture", keeps ? "Take the kept picture away" : "Keep the picture beside");
  if (!keeps) return;
  Object.assign(second, {width: canvas.width, height: canvas.height});
  second.getContext("2d").drawImage(canvas, 0, 0);
  set_text("caption-2", element("caption").textContent);
}

/* Shows a painted picture, with its facts. */
function present(painted) {
  show_picture(painted);
  exposure = painted.exposure;
  show_message(!painted.balanced
    ? "The eye cannot adapt to this light, or the camera cannot be balanced for it. The picture stays black."
    : exposure > 0 ? "" : "The picture stays black: enter an exposure above 0.");
  show_title();
  show_source_heads();
  show_facts(painted.outside);
  show_map_legend(element("scene-view").value === "map" ? 1 / exposure : null, "of radiance");
  show_controls();
  set_text("commands", command_lines());
  show_pixel();
}

function redraw() {
  const since = performance.now();
  sources = read_sources();
  eye = eye_of(read_choice());
  white = white_of(sources);
  present(paint(sources, read_choice(), wanted_exposure()));
  set_text("speed", `The last redraw took ${(performance.now() - since).toFixed(0)} ms.`);
}

let due = false;
function redraw_soon() {
  if (!due) requestAnimationFrame(() => { due = false; redraw(); });
  due = true;
}

/* In a live page the scene itself changes: see live.js. */
const is_live = () => document.body.classList.contains("live");
const is_stack = () => document.body.classList.contains("stack");

function listen() {
  element("controls").addEventListener("input", event => is_live() ? redraw_live(event) : is_stack() || redraw_soon());
  element("controls").addEventListener("reset", () => setTimeout(is_live() ? reset_live : is_stack() ? redraw_stack : redraw_soon));
  element("controls").addEventListener("reset", fit_picture);
  element("controls").addEventListener("submit", event => event.preventDefault());
  element("objects").addEventListener("change", pick_object);
  canvas.addEventListener("click", pick_by_pointer);
  for (const name of ["pointermove", "pointerleave"]) canvas.addEventListener(name, hover);
  listen_to_zoom();
  canvas.addEventListener("keydown", pick_by_key);
  element("values-shown").addEventListener("toggle", show_pixel);
  element("keep").addEventListener("click", () => is_stack() ? keep_spectrum() : keep());
  element("keep-picture").addEventListener("click", keep_picture);
  element("save").addEventListener("click", () => canvas.toBlob(blob => save(blob, ".png")));
  element("save-values").addEventListener("click", () =>
    save(new Blob([values_csv(is_stack() ? stack_curves() : curves_at(pixel))], {type: "text/csv"}), ".csv"));
  new ResizeObserver(show_pixel).observe(element("chart"));
}

/* Fits the page to a picture's shape. */
function fit_frame() {
  if (element("frame").style.getPropertyValue("--width") !== `${shape.width}px`) zoom.scale = 1;
  for (const {style} of both_frames()) {
    style.setProperty("--width", `${shape.width}px`);
    style.setProperty("--aspect", shape.width / shape.height);
  }
  if (!cursor) cursor = first_place();
  show_zoom();
}

function show_names() {
  const nm = scene.wavelengths;
  set_text("name", scene.scene);
  set_text("about", `${shape.width} × ${shape.height} pixels, ` + (n_bands > 1
    ? `${n_bands} wavelengths from ${nm[0]} to ${nm[n_bands - 1]} nm` : `one wavelength, ${nm[0]} nm`));
  set_text("program", scene.program);
}

async function start_still() {
  const read = id => JSON.parse(element(id).textContent);
  set_scene(read("scene"));
  set_shape(read("shape"));
  const [surfaces, ...values] = decode_planes(await unpack(element("planes").textContent, "deflate"));
  set_planes(shape, {surfaces, values});
  show_names();
  fit_frame();
  add_controls();
  refresh_objects();
  redraw();
  choose_scaling();
  pick(cursor.x, cursor.y);
  listen();
  document.body.dataset.ready = "true";
}
