/* SPDX-License-Identifier: MIT */
/* A page that verifies the GPU that opens it: for each scene the program exports, WebGL draws, and the program judges. */

const start = JSON.parse(element("start").textContent);
const SIZES = {short: ["--size=150x100", "--wavelengths=400:700:50"], long: ["--size=300x200", "--wavelengths=400:700:10"]};
const AGREED = "agreed", DIFFERS = "differs", NOT_VERIFIED = "not verified", FAILED = "failed", NOT_TRIED = "not tried";

let module;            /* the compiled program */
let results = [];      /* of this run: {scene, verdict, message, seconds, check, bounds, picture, archive} */
let targets, measured; /* as they were drawn; numbers of the driver that the program found by them */
let run_number = 0, seconds = 0;
const programs = new Set(); /* those that work */

/* Lets the page show what has changed, and answer; a GPU that works long is left alone for some ms. */
const channel = new MessageChannel(), FEW_WAITS = 8;
const pause = waits => new Promise(then => {
  if (waits > FEW_WAITS) setTimeout(then, 5);
  else {
    channel.port1.onmessage = then;
    channel.port2.postMessage(null);
  }
});

class Stopped extends Error {}

/* ---- a scene ---- */

const is_judged_by = word => /^--(strict|unchecked)\b/.test(word);

/* Returns the words by which the program exports a scene. A hard case keeps its size. */
function export_words({scene, kind, options}) {
  const own = options.filter(word => !is_judged_by(word) && !(kind === "hard" && word.startsWith("--size=")));
  return ["export", scene, ...(kind === "built-in" ? SIZES[element("length").value] : []), ...own, "-o", "/case"];
}

/* Exports a scene in a worker of its own. Returns {program, exported, error}; exported: a Map from names to bytes. */
async function export_scene(of) {
  const program = new Program(module);
  programs.add(program);
  program.send_files(of.files);
  const {status, errors, error} = await program.ask({task: "run", words: export_words(of)});
  const taken = status === 0 ? await program.ask({task: "take", below: "/case/"}) : {error: error || errors};
  return {program, exported: taken.files, error: taken.error};
}

/* Draws a scene of the exported ones by WebGL in steps; check() throws where the run has stopped. */
async function draw_in_steps(exported, prefix, check) {
  const drawn = new Map(), gl = open_webgl();
  try {
    for (const waits of draw_scene(gl, exported, prefix, drawn)) {
      if (gl.isContextLost()) break;
      await pause(waits);
      check();
    }
    if (gl.isContextLost()) throw Error("lost");
  } catch (error) {
    if (!gl.isContextLost() || error instanceof Stopped) throw error;
    throw Error("the browser lost the GPU while it drew: it was reset, or given to another page");
  } finally {
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
  return drawn;
}

/* Judges what was drawn: by the targets, or, once these are measured, by what they have shown. Returns the verdict, what its
 * JSON says of the check, and the driver's bounds. */
async function judge_case(program, drawn, options) {
  const files = Object.fromEntries([...drawn, ...(measured ? [] : targets)].map(([name, bytes]) => [`case/${name}`, bytes]));
  if (measured) files["case/drawn.txt"] = new TextDecoder().decode(files["case/drawn.txt"]) + `driver ${measured}\n`;
  program.ask({task: "files", files});
  const {output, errors, error} = await program.ask({task: "run", words: ["judge", "/case", ...options.filter(is_judged_by), "-v", "--json", "-"]});
  const said = pattern => pattern.exec(errors || "")?.[1];
  const message = error || said(/^(?:error|warning): ([^]*)/m) || errors;
  if (!output) return {verdict: FAILED, message};
  const {verdict, check} = JSON.parse(output);
  measured ??= said(/^driver +(-?[\d. e+-]+)$/m);
  return {verdict, check, bounds: said(/^bounds +(.*)$/m), message: verdict === AGREED ? "" : message};
}

function end_program(program) {
  program.end();
  programs.delete(program);
}

/* Exports, draws and judges a scene; the export has begun. */
async function verify_scene(of, exporting, check) {
  const since = performance.now(), result = {scene: of.name, verdict: FAILED, message: ""}, {program, exported, error} = await exporting;
  try {
    check();
    if (error) throw Error(error);
    targets ??= await draw_in_steps(exported, "targets-", check);
    const drawn = await draw_in_steps(exported, "", check), judging = judge_case(program, drawn, of.options);
    Object.assign(result, {picture: picture_of(exported, drawn)}, await judging);
    check();
    const all = [exported, targets, drawn];
    if (result.verdict === DIFFERS) result.archive = () => tar(all.flatMap(files => [...files]));
  } catch (error) {
    if (error instanceof Stopped) throw error;
    Object.assign(result, {verdict: error instanceof NotTried ? NOT_TRIED : FAILED, message: error.message});
  } finally {
    end_program(program);
  }
  result.seconds = (performance.now() - since) / 1000;
  return result;
}

/* ---- all scenes ---- */

/* The next scene is exported while one is drawn and judged. */
async function verify_all() {
  const mine = ++run_number, since = performance.now(), check = () => { if (mine !== run_number) throw new Stopped(); };
  results = [];
  targets = measured = undefined;
  show_start();
  let next = export_scene(start.scenes[0]);
  try {
    for (const [i, of] of start.scenes.entries()) {
      const exporting = next;
      await exporting;
      check();
      if (i + 1 < start.scenes.length) next = export_scene(start.scenes[i + 1]);
      set_text("progress", `${i + 1} of ${start.scenes.length}: ${of.name}`);
      results.push(await verify_scene(of, exporting, check));
      show_result(results.at(-1));
    }
  } catch (error) {
    if (!(error instanceof Stopped)) throw error;
  }
  if (mine === run_number) run_number++;
  seconds = (performance.now() - since) / 1000;
  show_end();
}

/* ---- what the page shows ---- */

const bands_of = (scene, part) => scene.bands.map((_, i) => i).filter(i => Math.floor(3 * i / scene.bands.length) === part);

/* Returns the drawn picture: red, green and blue are means of thirds of the bands, as bright as 99 % of the samples allow. */
function picture_of(exported, drawn) {
  const scene = read_exported(exported, ""), n = scene.width * scene.height, means = new Float32Array(3 * n);
  for (const c of [0, 1, 2]) {
    const bands = scene.bands.length < 3 ? scene.bands.map((_, i) => i) : bands_of(scene, 2 - c);
    for (const band of bands) {
      const colours = numbers_in(Float32Array, drawn.get(`colours-${band - band % 3}.bin`));
      for (let i = 0; i < n; i++) means[3 * i + c] += colours[4 * i + band % 3] / bands.length;
    }
  }
  const white = means.toSorted()[Math.floor(0.99 * 3 * n)] || 1, image = new ImageData(scene.width, scene.height);
  image.data.fill(255);
  means.forEach((value, i) => image.data[4 * Math.floor(i / 3) + i % 3] = 255 * Math.min(1, Math.max(0, value / white)) ** (1 / 2.2));
  return image;
}

/* Returns a canvas of a picture, with a ring around the first wrong pixel. */
function canvas_of({picture, check, scene}) {
  const canvas = document.createElement("canvas"), wrong = check?.first_unexplained;
  Object.assign(canvas, {width: picture.width, height: picture.height});
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `What the GPU has drawn of ${scene}`);
  const to = canvas.getContext("2d");
  to.putImageData(picture, 0, 0);
  if (wrong) {
    Object.assign(to, {strokeStyle: "#ff3030", lineWidth: Math.max(1, picture.width / 60)});
    to.beginPath();
    to.arc(wrong.x + 0.5, wrong.y + 0.5, picture.width / 20, 0, 7);
    to.stroke();
  }
  return canvas;
}

function add_row(body, cells, kind = "td") {
  const row = body.insertRow();
  for (const cell of cells) row.append(Object.assign(document.createElement(kind), {textContent: cell}));
  return row;
}

const three_digits = new Intl.NumberFormat("en", {maximumSignificantDigits: 3, useGrouping: false});
const short = number => typeof number !== "number" ? "–" : number > 0 && number < 0.001 ? "< 0.001" : three_digits.format(number);
const count_of = verdict => results.filter(one => one.verdict === verdict).length;
const share_of = ({unchecked_pixels, object_pixels}) => object_pixels > 0 ? 100 * unchecked_pixels / object_pixels : 0;

function show_result(result) {
  const {scene, verdict, message, check, archive, picture} = result, body = element("results").tBodies[0];
  const row = add_row(body, ["", verdict, short(check?.floor_median_counts), check ? `${short(share_of(check))} %` : "–", result.seconds.toFixed(1)]);
  const name = Object.assign(document.createElement("div"), {className: "scene"});
  if (picture) name.append(canvas_of(result));
  name.append(scene);
  row.cells[0].append(name);
  row.cells[1].className = verdict === AGREED ? "agreed" : "wrong";
  if (message) {
    const why = add_row(body, [message]);
    why.className = "why";
    why.cells[0].colSpan = 5;
    if (archive) {
      const button = Object.assign(document.createElement("button"), {type: "button", textContent: "Save the case (tar)"});
      button.addEventListener("click", () => save_as(archive(), scene.replaceAll("/", "-") + ".tar"));
      why.cells[0].append(" ", button);
    }
  }
  if (result.bounds) show_bounds(result.bounds);
  show_sentence();
  element("bar").value = results.length / start.scenes.length;
}

function show_sentence() {
  const n = results.length, all = start.scenes.length, wrong = results.find(({verdict}) => verdict === DIFFERS);
  const found = wrong ? `This GPU draws wrong pixels in ${count_of(DIFFERS)} of ${n} scenes, first in ${wrong.scene}.`
    : count_of(AGREED) > 0 ? "No wrong pixel was found." : "Nothing could be verified.";
  const parts = [found, `${count_of(AGREED)} agreed${n < all ? ` so far, of ${all}` : ""}.`];
  if (count_of(NOT_VERIFIED) > 0) parts.push(`${count_of(NOT_VERIFIED)} not verified: too few of their pixels can be checked on this GPU.`);
  if (count_of(NOT_TRIED) > 0) parts.push(`${count_of(NOT_TRIED)} not tried.`);
  if (count_of(FAILED) > 0) parts.push(`${count_of(FAILED)} failed.`);
  set_text("sentence", parts.join(" "));
}

/* What the program says of a driver in a line, and what it means. */
const MEASURED = [
  [/edges to (\S+) pixel/, "edges of triangles", "off by at most $ pixel"],
  [/values to ([^ ,]+)/, "values within triangles", "as if corners were off by at most $ pixel"],
  [/depth to (\S+) step/, "depth", "off by at most $ steps of 24 bits"],
  [/filters to ([^ ,]+)/, "weights of texels", "as for a place that is off by at most $ texel"],
  [/levels of detail to ([^ ,]+)/, "levels of detail", "off by at most $"],
  [/levels of detail (as specified)/, "levels of detail", "anything that OpenGL allows"],
  [/light to (\S+) x Mesa/, "lighting", "errors at most $ times those of Mesa"],
  [/, ([^,]+) where triangles meet/, "where triangles meet", "$"],
];

function show_bounds(bounds) {
  const body = element("gpu").tBodies[0];
  if (body.dataset.bounds) return;
  body.dataset.bounds = bounds;
  for (const [pattern, name, words] of MEASURED) {
    const found = pattern.exec(bounds);
    if (found) add_row(body, [name, words.replace("$", found[1])]);
  }
}

function show_start() {
  const body = element("gpu").tBodies[0];
  element("results").tBodies[0].replaceChildren();
  body.replaceChildren();
  delete body.dataset.bounds;
  set_text("sentence", "It draws …");
  element("bar").value = 0;
  element("message").hidden = true;
  set_running(true);
  try {
    const gl = open_webgl(), facts = webgl_facts(gl);
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    for (const row of [["GPU", facts.renderer], ["browser", navigator.userAgent], ["WebGL", facts.version], ["grid of corners", `1/${2 ** facts.subpixel_bits} pixel, as WebGL says`]]) add_row(body, row);
    start.facts = facts;
  } catch (error) {
    add_row(body, ["GPU", error.message]);
  }
}

function show_end() {
  set_running(false);
  const stopped = results.length < start.scenes.length ? `Stopped after ${results.length} of ${start.scenes.length} scenes. ` : "";
  set_text("progress", `${stopped}${seconds.toFixed(0)} seconds.`);
  element("save-report").disabled = results.length === 0;
  document.body.dataset.ready = "true";
}

function set_running(running) {
  element("stop").disabled = !running;
  element("again").disabled = element("length").disabled = running;
  element("save-report").disabled = running;
  if (running) delete document.body.dataset.ready;
}

/* ---- the report ---- */

/* As `spectral verify --json` writes it. */
function report() {
  const {renderer = null, version = null} = start.facts || {};
  const part = (check, n) => check.object_pixels > 0 ? 100 * n / check.object_pixels : null;
  const scenes = results.map(({scene, verdict, message, seconds, check}) => ({scene, verdict: verdict === NOT_TRIED ? NOT_VERIFIED : verdict,
    message: verdict === NOT_TRIED ? `not tried: ${message}` : message || null, seconds, ...(check && {
      ...Object.fromEntries(["pixels", "object_pixels", "samples", "ambiguous_pixels", "unexplained_pixels", "unchecked_pixels", "max_counts", "worst_error_over_bound"]
        .map(key => [key, check[key]])),
      floor_median: check.floor_median_counts, floor_99_9: check.floor_999_counts, checked_within_1: part(check, check.floor_within_1),
      checked_within_8: part(check, check.floor_within_8), checked_within_256: part(check, check.floor_within_256)})}));
  return {drivers: [{gl: "webgl", renderer: null, program: start.program, processor: navigator.userAgent, gl_library: "WebGL", gl_renderer: renderer,
    gl_version: version, driver_profile: "measured", agreed: count_of(AGREED), scenes}], seconds};
}

/* Returns an archive as tar reads it: a head of 512 bytes for each file. */
function tar(files) {
  const parts = [];
  for (const [name, data] of files) {
    const head = new Uint8Array(512), put = (at, text) => head.set(new TextEncoder().encode(text), at);
    const fields = [[0, `case/${name}`], [100, "0000644"], [124, data.byteLength.toString(8).padStart(11, "0")], [136, "00000000000"], [148, "        0"],
                    [257, "ustar"], [263, "00"]];
    for (const [at, text] of fields) put(at, text);
    put(148, head.reduce((a, b) => a + b).toString(8).padStart(6, "0"));
    head[154] = 0;
    parts.push(head, data, new Uint8Array((512 - data.byteLength % 512) % 512));
  }
  return new Blob([...parts, new Uint8Array(1024)]);
}

/* ---- start ---- */

async function start_page() {
  set_text("program", start.program);
  element("stop").addEventListener("click", () => {
    run_number++;
    programs.forEach(end_program);
  });
  element("again").addEventListener("click", verify_all);
  element("save-report").addEventListener("click", () => save_as(new Blob([JSON.stringify(report(), null, 1) + "\n"]), "gpu.json"));
  document.addEventListener("visibilitychange", () => {
    if (document.hidden && !element("stop").disabled) element("message").hidden = false;
  });
  module = await WebAssembly.compile(await unpack(element("module").textContent, "gzip"));
  const reader = {bytes: await unpack(element("files").textContent, "deflate"), at: 0};
  for (const scene of start.scenes) scene.files = read_files(scene.files, reader);
  await verify_all();
}

start_page().catch(error => {
  set_text("sentence", `This browser cannot verify its GPU (${error.message}). Browsers of 2023 and later can.`);
  throw error;
});
