/* SPDX-License-Identifier: MIT */
/* A page of a stack: its bands, its colours, the spectra of pixels and regions, and maps against a kept spectrum. */

let stack = null; /* {facts, pages: the samples of each band, unit: the radiance of 1, objects} */

/* ---- samples ---- */

function decode_counts(bytes, n) {
  const out = new Uint16Array(n);
  for (let i = 0, value = 0; i < n; i++) out[i] = value += bytes[i] + 256 * bytes[n + i];
  return out;
}

/* Reads the data of a stack: see stack_page_write in the program. */
function read_stack(bytes) {
  const {facts, first} = read_head(bytes), n = facts.width * facts.height, size = n * (facts.counts ? 2 : 4);
  const page = i => bytes.slice(first + i * size, first + (i + 1) * size), end = first + facts.bands * size;
  const decode = one => facts.counts ? decode_counts(one, n) : new Float32Array(one.buffer);
  const objects = facts.has_objects ? new Uint16Array(bytes.slice(end, end + 2 * n).buffer) : new Uint16Array(n);
  return {facts, pages: Array.from({length: facts.bands}, (_, i) => decode(page(i))), unit: facts.unit, objects};
}

const stack_spectrum = pixel => Float64Array.from(stack.pages, page => page[pixel] * stack.unit);

/* A large stack is shown as means of factor x factor pixels. Places and names are those of the stack. */
const corner_of = pixel => place_of(pixel).map(value => value * stack.facts.factor);

function pixel_text(pixel) {
  const {factor} = stack.facts;
  return `pixel ${corner_of(pixel).join(", ")}` + (factor > 1 ? ` (mean of ${factor} × ${factor})` : "");
}

/* ---- regions ---- */

function region_text() {
  const {factor} = stack.facts;
  return factor > 1 ? `${region.n} means of ${factor} × ${factor} pixels` : `${region.n} pixels`;
}

/* Returns whether a pixel's middle lies in a polygon. */
function in_polygon(points, x, y) {
  let inside = false;
  points.forEach(([x1, y1], i) => {
    const [x2, y2] = points[(i + 1) % points.length];
    if (y1 > y !== y2 > y && x < x1 + (y - y1) / (y2 - y1) * (x2 - x1)) inside = !inside;
  });
  return inside;
}

/* Returns the pixels of a region: {kind: "rectangle", points: two corners} or {kind: "polygon", points}, in pixels. */
function pixels_in({kind, points}) {
  const xs = points.map(([x]) => x), ys = points.map(([, y]) => y), out = [];
  const left = clamp(Math.floor(Math.min(...xs)), 0, shape.width - 1), right = clamp(Math.floor(Math.max(...xs)), 0, shape.width - 1);
  const top = clamp(Math.floor(Math.min(...ys)), 0, shape.height - 1), bottom = clamp(Math.floor(Math.max(...ys)), 0, shape.height - 1);
  for (let y = top; y <= bottom; y++)
    for (let x = left; x <= right; x++)
      if (kind === "rectangle" || in_polygon(points, x + 0.5, y + 0.5)) out.push(y * shape.width + x);
  return out;
}

/* Returns the mean of pixels in each band, and the standard deviation, as `probe` does. */
function statistics_of(pixels) {
  const mean = [], spread = [];
  for (const page of stack.pages) {
    const first = page[pixels[0]] * stack.unit;
    let sum = 0, squares = 0;
    for (const pixel of pixels) {
      const difference = page[pixel] * stack.unit - first;
      sum += difference;
      squares += difference * difference;
    }
    mean.push(first + sum / pixels.length);
    spread.push(Math.sqrt(Math.max(0, squares / pixels.length - (sum / pixels.length) ** 2)));
  }
  return {mean: Float64Array.from(mean), spread: Float64Array.from(spread)};
}

/* ---- pictures ---- */

/* Adds factor x samples of a page to a channel. */
function add_page(out, page, factor) {
  for (let i = 0; i < n_pixels; i++) out[i] += page[i] * factor;
}

function stack_largest() {
  stack.largest ??= Math.max(...stack.pages.map(page => page.reduce((most, one) => Math.max(most, one), 0))) * stack.unit;
  return stack.largest || 1;
}

const shown_bands = () => element("stack-view").value === "band" ? Array(3).fill(Number(element("band").value))
  : ["red", "green", "blue"].map(name => Number(element("band-" + name).value));

/* Paints one band, or three, so that the largest radiance of the stack is the display's white. */
function paint_bands(display, exposure) {
  shown_bands().forEach((band, c) => add_page(linear[c], stack.pages[band], stack.unit / stack_largest() * display.largest[c]));
  const factor = exposure === null ? automatic_exposure(display) : exposure;
  return {...develop(display, factor), exposure: factor, balanced: true};
}

function paint_detector(chosen_eye, exposure) {
  const channels = chosen_eye.detector ? channel_weights(chosen_eye, white) : null;
  for (let c = 0; c < 3 && channels; c++)
    stack.pages.forEach((page, band) => add_page(linear[c], page, channels[c][band] * stack.unit));
  const factor = exposure === null ? automatic_exposure(chosen_eye.display) : exposure;
  return {...develop(chosen_eye.display, factor), exposure: factor, balanced: channels !== null};
}

/* Returns the spectral angle of each pixel to a spectrum, in radians. */
function angle_map({values}) {
  const along = new Float64Array(n_pixels), squares = new Float64Array(n_pixels), length = Math.hypot(...values);
  stack.pages.forEach((page, band) => {
    for (let i = 0; i < n_pixels; i++) {
      along[i] += page[i] * values[band];
      squares[i] += page[i] * page[i];
    }
  });
  return along.map((value, i) => squares[i] > 0 && length > 0
    ? Math.acos(clamp(value / Math.sqrt(squares[i]) / length, -1, 1)) : Math.PI / 2);
}

/* Returns CIEDE2000 of each pixel to a spectrum, for the observer and the stack's white; null without a white. */
function difference_map({values}) {
  const of_white = observer() && white_responses(observer(), white);
  if (!of_white) return null;
  const kept_lab = cielab(apply(observer().weights, values), of_white);
  return Float64Array.from(lab_of_pixels(stack, of_white), lab => ciede2000(kept_lab, lab));
}

let map = null; /* the values of the map that is shown */

function paint_map(values) {
  const data = new Uint8ClampedArray(4 * n_pixels).fill(255), largest = values.reduce((most, one) => Math.max(most, one), 0) || 1;
  map = {values, largest};
  for (let i = 0; i < n_pixels; i++) data.set(ramp(values[i] / largest), 4 * i);
  return {data, outside: 0, exposure: 1, balanced: true};
}

/* ---- two stacks ---- */

let beside = null; /* a second stack of the same size */

const white_of_stack = ({facts}) => facts.white ? {radiance: facts.white, intensity: facts.illumination || 1} : null;
const description_of = ({facts}) => ({...facts, scene: facts.stack, objects: facts.objects.map(name => ({name, shape: ""})),
  wavelengths: facts.components ? Array.from({length: facts.bands}, (_, i) => i + 1) : facts.wavelengths});

/* Does something as if the other stack were the page's. */
function as_stack(other, act) {
  const own = stack, picked_eye = eye;
  const take = (one, seen) => { stack = one; set_scene(description_of(one)); white = white_of_stack(one); eye = seen; };
  take(other, eye);
  const detector = picked_eye.detector && scene.detectors.find(({name}) => name === picked_eye.detector.name);
  eye = {...picked_eye, detector};
  try {
    return act();
  } finally {
    take(own, picked_eye);
  }
}

/* Returns the largest difference of radiance in all bands, of each pixel. */
function radiance_differences() {
  const out = new Float64Array(n_pixels);
  stack.pages.forEach((page, band) => {
    for (let i = 0; i < n_pixels; i++)
      out[i] = Math.max(out[i], Math.abs(page[i] * stack.unit - beside.pages[band][i] * beside.unit));
  });
  return out;
}

/* Returns L*, a*, b* of all pixels of a stack, as the first stack is seen. */
function lab_of_pixels(of, of_white) {
  const xyz = observer().weights.map(row => {
    const out = new Float64Array(n_pixels);
    of.pages.forEach((page, band) => add_page(out, page, row[band] * of.unit));
    return out;
  });
  return Array.from({length: n_pixels}, (_, i) => cielab(xyz.map(row => row[i]), of_white));
}

/* Returns CIEDE2000 between the stacks, both under the white of the first one, as `compare` does; null without one. */
function colour_differences() {
  const of_white = observer() && white_responses(observer(), white);
  if (!of_white) return null;
  const own = lab_of_pixels(stack, of_white), other = lab_of_pixels(beside, of_white);
  return Float64Array.from(own, (lab, i) => ciede2000(lab, other[i]));
}

function open_beside(opened) {
  const {facts} = opened;
  if (facts.width !== shape.width || facts.height !== shape.height || facts.bands !== stack.facts.bands)
    return show_message(`${facts.stack} has ${facts.width} × ${facts.height} pixels and ${facts.bands} bands; expected ` +
      `${shape.width} × ${shape.height} and ${stack.facts.bands}, as ${stack.facts.stack} has.`);
  beside = opened;
  show_beside();
}

function show_beside() {
  element("frame-2").hidden = element("close-beside").hidden = !beside;
  for (const option of document.querySelectorAll(".of-two")) option.disabled = !beside;
  element("opens-beside").checked = false;
  document.body.classList.toggle("beside", Boolean(beside));
  set_text("caption", stack.facts.stack);
  set_text("caption-2", beside ? beside.facts.stack : "");
  if (!beside && element("stack-view").value.startsWith("beside")) element("stack-view").value = "detector";
  redraw_stack();
}

function paint_beside() {
  if (!beside) return;
  const view = element("stack-view"), kept_view = view.value, second = element("picture-2");
  if (kept_view.startsWith("beside")) view.value = "detector";
  const painted = as_stack(beside, paint_stack);
  view.value = kept_view;
  Object.assign(second, {width: shape.width, height: shape.height});
  if (painted) second.getContext("2d").putImageData(new ImageData(painted.data, shape.width, shape.height), 0, 0);
}

const MAPS = {angle: angle_map, difference: difference_map};
const MAP_UNITS = {angle: "radians", difference: "CIEDE2000", "beside-radiance": "of radiance", "beside-colour": "CIEDE2000"};
const MAPS_OF_TWO = {"beside-radiance": radiance_differences, "beside-colour": colour_differences};

const no_picture = lacks => ({data: new Uint8ClampedArray(4 * n_pixels), outside: 0, exposure: 1, balanced: true, lacks});

function paint_stack() {
  const view = element("stack-view").value, against = kept_spectra[Number(element("against").value)];
  map = null;
  make_channels();
  for (const channel of linear) channel.fill(0);
  if (MAPS_OF_TWO[view]) {
    const values = MAPS_OF_TWO[view]();
    return values ? paint_map(values) : no_picture("A stack records no white, so that there are no colour differences.");
  }
  if (MAPS[view]) {
    const values = against && MAPS[view](against);
    if (values) return paint_map(values);
    return no_picture(against ? "This stack records no white, so that it has no colour differences."
      : "Keep a spectrum first: maps are against it.");
  }
  return view === "detector" ? paint_detector(eye, wanted_exposure()) : paint_bands(eye.display, wanted_exposure());
}

/* ---- the page ---- */

const nm_text = band => stack.facts.components ? `component ${band + 1}` : `${+stack.facts.wavelengths[band].toPrecision(7)} nm`;

function redraw_stack() {
  eye = eye_of(read_choice());
  paint_beside();
  const painted = {...paint_stack(), width: shape.width, height: shape.height};
  const view = element("stack-view").value;
  show_picture(painted);
  exposure = painted.exposure;
  show_message(painted.lacks || (painted.balanced ? "" : "The detector has no white to adapt to here. The picture stays black."));
  show_map_legend(map && map.largest, MAP_UNITS[view]);
  element("band-row").hidden = view !== "band";
  element("bands-row").hidden = view !== "bands";
  element("against-row").hidden = !MAPS[view];
  set_text("band-nm", nm_text(Number(element("band").value)));
  show_stack_facts(painted);
  show_stack_pixel();
}

function show_stack_facts({outside}) {
  if (!eye.detector) return set_text("lost", "No built-in detector sees these wavelengths.");
  const names = eye.detector.observer ? ["x", "y", "z"] : ["r", "g", "b"], detecting = element("stack-view").value === "detector";
  set_text("gamut", `Out of gamut: ${outside} of ${n_pixels} pixels (${percent(outside / n_pixels)}).`);
  set_text("lost", detecting ? "The detector's sensitivity outside the stack's wavelengths: " +
    names.map((name, i) => `${name} ${percent(eye.detector.lost[i])}`).join(", ") + "." : "");
  set_text("white", white ? "White: the light that the stack records." : "The stack records no white.");
  show_controls();
  const words = ["spectral develop", quoted(stack.facts.stack), "--detector", quoted(eye.detector.name),
    "--display", quoted(eye.display.name), ...(eye.detector.observer ? ["--adaptation", eye.adaptation.name] : []),
    "--exposure", element("auto").checked ? "auto" : exposure];
  set_text("commands", words.join(" "));
}

/* ---- spectra ---- */

const kept_spectra = []; /* {name, values, spread} */
let region = null;  /* {kind, points, statistics, n} */

function stack_curves() {
  const curves = [];
  if (region) {
    const {mean, spread} = region.statistics;
    curves.push({name: `mean of ${region_text()}`, style: "radiance", values: mean},
      {name: "mean + spread", style: "specular", values: mean.map((value, i) => value + spread[i])},
      {name: "mean − spread", style: "specular", values: mean.map((value, i) => Math.max(0, value - spread[i]))});
  } else curves.push({name: pixel_text(pixel), style: "radiance", values: stack_spectrum(pixel)});
  if (is_hovered()) curves.push({name: "under the pointer", style: "hovered", values: stack_spectrum(hovered)});
  if (beside) curves.push({name: `${beside.facts.stack}, ${pixel_text(pixel)}`, style: "fluorescence",
    values: Float64Array.from(beside.pages, page => page[pixel] * beside.unit)});
  kept_spectra.forEach(({name, values}, i) => curves.push({name, style: "numbered", look: look_of(i), values}));
  return eye.detector ? curves.concat(detector_curves()) : curves;
}

function stack_rows(values) {
  if (!observer()) return [];
  const of_white = white_responses(observer(), white), xyz = apply(observer().weights, values);
  const rows = [["XYZ", figures(xyz, 4)], ["x, y", figures(chromaticity(xyz), 5)]];
  if (of_white) rows.push(["L*a*b*", figures(cielab(xyz, of_white), 3)]);
  kept_spectra.forEach(({name, values: other}) => {
    const angle = Math.acos(clamp(dot(values, other) / (Math.hypot(...values) * Math.hypot(...other) || 1), -1, 1));
    const lab = of_white && [xyz, apply(observer().weights, other)].map(one => cielab(one, of_white));
    rows.push([`to ${name}: angle, ΔE00`, [...figures([angle], 4), ...(lab ? figures([ciede2000(...lab)], 3) : [])]]);
  });
  return rows;
}

function stack_pixel_words(pixel) {
  const name = stack.facts.objects[shown[pixel] - 1];
  return pixel_text(pixel) + (name ? `: ${shown[pixel]}. ${name}` : "") + (map ? `: ${with_digits(4).format(map.values[pixel])}` : "");
}

function show_stack_pixel() {
  if (pixel === null || pixel >= n_pixels) return;
  const curves = stack_curves();
  set_text("picked", sentence(region ? `region of ${region_text()}` : pixel_words(pixel)));
  show_numbers(stack_rows(curves[0].values));
  show_plot(curves);
  show_legend(curves);
  show_values(curves);
}

function keep_spectrum() {
  const [{name, values}] = stack_curves();
  kept_spectra.push({name: `${name} (${kept_spectra.length + 1})`, values});
  refresh_kept();
}

function refresh_kept() {
  const list = element("kept-list"), before = Number(element("against").value) || 0;
  list.replaceChildren(...kept_spectra.map(({name}, i) => {
    const item = document.createElement("li"), button = document.createElement("button");
    Object.assign(button, {type: "button", textContent: "Forget"});
    button.setAttribute("aria-label", `Forget ${name}`);
    button.addEventListener("click", () => { kept_spectra.splice(i, 1); refresh_kept(); });
    item.append(name + " ", button);
    return item;
  }));
  element("against").replaceChildren(...kept_spectra.map(({name}, i) => new Option(name, i)));
  element("against").value = Math.min(before, Math.max(0, kept_spectra.length - 1));
  redraw_stack();
}

/* ---- pointing ---- */

let drawn_region = []; /* the corners of the region that is being drawn, in pixels of the stack */

const pointing = () => document.querySelector("#pointing :checked").value;

function end_region(kind, points) {
  const pixels = pixels_in({kind, points});
  region = pixels.length > 0 ? {kind, points, n: pixels.length, statistics: statistics_of(pixels)} : null;
  drawn_region = [];
  if (region && kind === "rectangle") show_rectangle(points);
  show_region();
  show_stack_pixel();
}

/* The fields of a rectangle: left, top, width and height in pixels of the stack. */
const RECTANGLE = ["region-x", "region-y", "region-w", "region-h"];

function show_rectangle(points) {
  const [left, right] = points.map(([x]) => clamp(Math.floor(x), 0, shape.width - 1)).sort((a, b) => a - b);
  const [top, bottom] = points.map(([, y]) => clamp(Math.floor(y), 0, shape.height - 1)).sort((a, b) => a - b);
  [left, top, right - left + 1, bottom - top + 1].forEach((value, i) => { element(RECTANGLE[i]).value = value * stack.facts.factor; });
}

function take_rectangle() {
  const [x, y, width, height] = RECTANGLE.map(id => element(id).valueAsNumber / stack.facts.factor);
  if (x >= 0 && y >= 0 && width > 0 && height > 0) end_region("rectangle", [[x, y], [x + width - 0.01, y + height - 0.01]]);
}

function show_region() {
  const svg = element("handles"), points = drawn_region.length > 0 ? drawn_region : region ? region.points : [];
  const kind = drawn_region.length > 0 ? pointing() : region && region.kind;
  svg.setAttribute("viewBox", `0 0 ${shape.width} ${shape.height}`);
  svg.replaceChildren();
  if (points.length < 2) return;
  const [[x1, y1], [x2, y2]] = points;
  const outline = kind === "rectangle" ? `M${x1} ${y1}H${x2}V${y2}H${x1}Z` : "M" + points.map(point => point.join(" ")).join("L") + "Z";
  draw(svg, "path", {d: outline, class: "region"});
  draw(svg, "path", {d: outline, class: "region front"});
}

function press_stack(event) {
  if (pointing() === "pick") return;
  if (pointing() === "rectangle") drawn_region = [place_under(event), place_under(event)];
  else drawn_region.push(place_under(event));
  canvas.setPointerCapture(event.pointerId);
  show_region();
}

function move_stack(event) {
  if (pointing() !== "rectangle" || drawn_region.length === 0) return;
  drawn_region[1] = place_under(event);
  show_region();
}

function release_stack() {
  if (pointing() === "rectangle" && drawn_region.length > 0) end_region("rectangle", drawn_region);
}

function pick_stack(x, y) {
  region = null;
  show_region();
  pick(x, y);
}

/* ---- start ---- */

function stack_menus() {
  const {bands} = stack.facts, names = Array.from({length: bands}, (_, band) => nm_text(band));
  element("band").max = bands - 1;
  element("band").value = bands >> 1;
  const nearest = nm => stack.facts.components ? 0 : stack.facts.wavelengths.reduce((best, one, i, all) =>
    Math.abs(one - nm) < Math.abs(all[best] - nm) ? i : best, 0);
  for (const [name, nm] of [["red", 640], ["green", 550], ["blue", 460]]) {
    element("band-" + name).replaceChildren();
    fill_select(element("band-" + name), names, nearest(nm));
  }
  fill_eye_menus();
  element("stack-view").options[0].disabled = scene.detectors.length === 0;
  element("stack-view").value = scene.detectors.length > 0 ? "detector" : "band";
}

/* Shows a stack in place of what the page has shown. */
function open_stack(opened) {
  const {facts} = stack = opened;
  set_scene(description_of(stack));
  beside = null;
  set_shape({width: facts.width, height: facts.height, positions: 1});
  shown = opened.objects;
  white = white_of_stack(stack);
  kept_spectra.length = 0;
  region = hovered = null;
  if (!element("frame-2").hidden) keep_picture(); /* that of a scene goes away */
  document.body.classList.add("stack");
  document.body.classList.remove("live");
  show_names();
  set_text("about", `${facts.full_width} × ${facts.full_height} pixels, ${facts.bands} bands` +
    (facts.components ? " (components)" : ` from ${nm_text(0)} to ${nm_text(facts.bands - 1)}`) +
    (facts.factor > 1 ? `; shown are means of ${facts.factor} × ${facts.factor} pixels` : "") +
    (facts.factor > 1 && element("module") ? ": drop the stack onto the page to see all" : ""));
  cursor = null;
  fit_frame();
  stack_menus();
  pixel = null;
  show_beside();
  refresh_kept();
  choose_scaling();
  pick_stack(cursor.x, cursor.y);
}

function listen_to_stack() {
  const changes = event => { if (stack && !event.target.closest("#pointing")) redraw_stack(); };
  element("controls").addEventListener("input", changes);
  element("stack-group").addEventListener("input", changes);
  canvas.addEventListener("pointerdown", event => { if (stack) press_stack(event); });
  canvas.addEventListener("pointermove", event => { if (stack) move_stack(event); });
  canvas.addEventListener("pointerup", () => { if (stack) release_stack(); });
  canvas.addEventListener("dblclick", () => { if (stack && drawn_region.length > 2) end_region("polygon", drawn_region); });
  for (const id of RECTANGLE) element(id).addEventListener("change", take_rectangle);
  element("close-beside").addEventListener("click", () => { beside = null; show_beside(); });
  element("end-polygon").addEventListener("click", () => { if (drawn_region.length > 2) end_region("polygon", drawn_region); });
  for (const input of document.querySelectorAll("#pointing input"))
    input.addEventListener("change", () => {
      drawn_region = [];
      show_region();
      element("end-polygon").hidden = pointing() !== "polygon";
    });
}

async function start_stack() {
  element("second-stack").hidden = !element("module"); /* the program in the page reads other stacks */
  listen_to_stack();
  listen();
  open_stack(read_stack(await unpack(element("stack").textContent, "deflate")));
  document.body.dataset.ready = "true";
}
