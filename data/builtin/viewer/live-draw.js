/* SPDX-License-Identifier: MIT */
/* A live page: the state of the scene with its history, and the workers that draw it. */

/* ---- the state ---- */

/* A state is never changed, so that undo can go back to it: {scene: its name, words: options of the program,
 * files: {name: text or bytes}}. A built-in scene has no file. */
let state = null;
const past = [], future = [];
const keys = {geometry: 0, spectra: 0}; /* other numbers after each change of geometry, and of all else */

const is_text = state => state.scene in state.files;
const text_of = state => state.files[state.scene];

/* What a change concerns. A light's colour changes no geometry; a moved object changes no spectrum. */
const GEOMETRY = 1, SPECTRA = 2;

function set_state(next, concerns) {
  state = next;
  if (concerns & GEOMETRY) keys.geometry++;
  if (concerns & SPECTRA) keys.spectra++;
}

/* Makes a change that undo takes back. Changes of one group are taken back together. */
function record(next, concerns, group) {
  if (!group.recorded) {
    past.push(state);
    future.length = 0;
    group.recorded = true;
  }
  set_state(next, concerns);
}

/* The same, and draws it. Where a whole picture takes long, a coarse one comes first. */
function commit(next, concerns, group = {recorded: false}) {
  record(next, concerns, group);
  if (concerns & GEOMETRY && coarseness === COARSEST) want(true);
  want(group.moving === true);
}

function go_back(from, to) {
  if (from.length === 0) return;
  to.push(state);
  set_state(from.pop(), GEOMETRY | SPECTRA);
  want(false);
}

/* ---- workers ---- */

class Drawer extends Program {
  since = null; /* when it began to draw; null: it is idle */
}

let compiled = null; /* the module */
let drawers = [];
const MOST_DRAWERS = 4;

function start_drawers() {
  const n = clamp((navigator.hardwareConcurrency || 2), 1, MOST_DRAWERS);
  drawers = Array.from({length: n}, () => new Drawer(compiled));
}

/* Asks a worker that is idle, or one more: a picture may take long. */
function ask_program(message, files = state.files) {
  const drawer = drawers.find(one => one.since === null);
  if (!drawer) return ask_apart(message, files);
  drawer.send_files(files);
  return drawer.ask(message);
}

/* Does a long task on a worker of its own, so that pictures go on. */
async function ask_apart(message, files = state.files) {
  const drawer = new Drawer(compiled);
  drawer.send_files(files);
  const answer = await drawer.ask(message);
  drawer.end();
  return answer;
}

const run_program = words => ask_program({task: "run", words});

/* ---- drawing ---- */

let wanted = null;      /* {moving}: the latest wish that no worker has */
let asked = 0;          /* numbers of the pictures that workers were asked for, and of the latest one that is shown */
let latest_shown = 0;
let coarseness = 1;     /* how much coarser a moving picture is */
const FRAME_MS = 33, COARSEST = 8, PATIENCE_MS = 2000, SHORT_MS = 300;

/* Asks for a picture: a whole one, or while something moves one that may be coarser. */
function want(moving) {
  wanted = {moving};
  pump();
}

/* Begins with a picture that moves at once, by the time of a whole one. */
function guess_coarseness(ms) {
  while (coarseness < COARSEST && ms / drawers.length / coarseness ** 2 > FRAME_MS) coarseness *= 2;
}

const pace_at = new Map(); /* by coarseness: milliseconds of a moving picture, for all workers together */

/* Learns from the time of a moving picture. A finer one is tried again some time after it was too slow. */
function adapt_coarseness(factor, ms) {
  for (const [other, pace] of pace_at) pace_at.set(other, 0.97 * pace);
  pace_at.set(factor, ms / drawers.length);
  if (factor !== coarseness) return;
  if (pace_at.get(factor) > FRAME_MS) coarseness = Math.min(2 * factor, COARSEST);
  else if (factor > 1 && (pace_at.get(factor / 2) || 0) < FRAME_MS) coarseness = factor / 2;
}

/* The options that make a picture coarser than the scene says. */
function coarse_words(factor) {
  const size = part => Math.max(1, Math.round(part / factor));
  return factor === 1 || !shape ? [] : [`--size=${size(shape.width)}x${size(shape.height)}`, "--samples=1"];
}

/* Ends workers that have drawn a picture older than this one for so long: patience_ms(drawer). */
function end_late(newest, patience_ms) {
  drawers.forEach((drawer, i) => {
    if (drawer.since === null || drawer.picture >= newest || performance.now() - drawer.since < patience_ms(drawer)) return;
    drawer.end();
    drawers[i] = new Drawer(compiled);
  });
}

/* Returns whether the newest picture that was asked for is a whole one: a coarser one comes without its description. */
const whole_is_coming = () => wanted ? !wanted.moving
  : drawers.some(one => one.since !== null && one.picture === asked && one.whole);

/* Readers of the screen, and tests, see whether the picture is the one that was asked for. A wait that a person feels is shown in words. */
let pending_edits = 0, waiting = null; /* the timer of a wait */
const FELT_MS = 300, DRAWING = "Drawing …";
function show_busy() {
  const busy = wanted !== null || pending_edits > 0 || drawers.some(one => one.since !== null);
  element("shown").setAttribute("aria-busy", busy);
  if (busy && waiting === null) waiting = setTimeout(() => set_text("progress", DRAWING), FELT_MS);
  if (!busy) end_wait();
  if (!busy && element("progress").textContent === DRAWING) set_text("progress", "");
}

/* A picture has come, or none is waited for. */
function end_wait() {
  clearTimeout(waiting);
  waiting = null;
}

async function pump() {
  if (wanted) end_late(asked + 1, ({whole}) => whole && wanted.moving ? SHORT_MS : PATIENCE_MS); /* a whole one would come too late */
  const drawer = drawers.find(one => one.since === null);
  show_busy();
  if (!wanted || !drawer) return;
  const {moving} = wanted, number = ++asked, factor = moving ? coarseness : 1, of = state;
  wanted = null;
  drawer.since = performance.now();
  drawer.picture = number;
  drawer.whole = !moving;
  drawer.send_files(of.files);
  const answer = await drawer.ask({task: "draw", words: [of.scene, ...of.words], size: coarse_words(factor),
    keys: {...keys}, eye: eye_names(), exposure: moving ? exposure : wanted_exposure(), whole: !moving}); /* no flicker */
  drawer.since = null;
  if (moving && answer.ms) adapt_coarseness(factor, answer.ms);
  if (number > latest_shown && answer.error !== "stopped") {
    latest_shown = number;
    end_wait();
    if (answer.error) refuse(answer.error, of);
    else if (moving) show_moving(answer);
    else if (!wanted) {
      show_whole(answer, of);
      end_late(number, () => SHORT_MS);
    }
  }
  pump();
}
