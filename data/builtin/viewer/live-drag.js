/* SPDX-License-Identifier: MIT */
/* A live page: the camera, and what a drag, the wheel, fingers and keys do with it and with objects and lights. */

/* ---- vectors ---- */

const add_vectors = (a, b, factor = 1) => a.map((value, i) => value + factor * b[i]);
const cross_of = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length_of = a => Math.hypot(...a);
const unit = a => a.map(value => value / length_of(a));

/* ---- the camera ---- */

let camera = null; /* that is shown, or will be: a description's camera */

function view_axes(camera) {
  const ahead = unit(add_vectors(camera.look, camera.eye, -1)), right = unit(cross_of(ahead, camera.up));
  return {ahead, right, up: cross_of(right, ahead)};
}

/* Returns the place about which the view turns: the chosen object, or what the camera looks at. An orthographic camera
 * looks at the middle of its depths. */
function pivot_of(camera) {
  const object = chosen_object(), {ahead} = view_axes(camera);
  if (object) return place_of_object(object);
  return camera.perspective ? camera.look : add_vectors(camera.eye, ahead, (camera.near + camera.far) / 2);
}

/* Returns the length in the scene of a pixel's width at a place. */
function pixel_length(camera, place) {
  const depth = Math.max(camera.near, dot(add_vectors(place, camera.eye, -1), view_axes(camera).ahead));
  return camera.perspective ? 2 * depth * Math.tan(camera.extent * Math.PI / 360) / shape.height : camera.extent / shape.width;
}

/* Returns a place as [x, y] in pixels, and its depth. The eye itself is in the middle. */
function project(camera, place) {
  const {ahead, right, up} = view_axes(camera), from = add_vectors(place, camera.eye, -1), depth = dot(from, ahead);
  const scale = camera.perspective ? shape.height / 2 / Math.tan(camera.extent * Math.PI / 360) / (depth || 1e-9) : shape.width / camera.extent;
  return {x: shape.width / 2 + dot(from, right) * scale, y: shape.height / 2 - dot(from, up) * scale, depth};
}

function set_camera(next) {
  camera = next;
  edit(GEOMETRY, text => with_camera(text, next), () => place_of_statement("camera"));
  show_handles();
}

/* Turns the view by angles to the right and upwards, in radians. It does not turn over its up direction. */
function turn_view(across, upwards) {
  const {ahead, right} = view_axes(camera), up = unit(camera.up), pivot = pivot_of(camera);
  const height = Math.asin(clamp(dot(ahead, up), -1, 1)), limit = 1.55;
  const pitch = clamp(height - upwards, -limit, limit) - height;
  const turn = v => turned(turned(v, right, pitch), up, -across);
  const about = place => add_vectors(pivot, turn(add_vectors(place, pivot, -1)));
  set_camera({...camera, eye: about(camera.eye), look: about(camera.look)});
}

/* Moves the view across the picture, by pixels. */
function pan_view(x, y) {
  const {right, up} = view_axes(camera), step = pixel_length(camera, pivot_of(camera));
  const by = add_vectors(right.map(value => -x * step * value), up, y * step);
  set_camera({...camera, eye: add_vectors(camera.eye, by), look: add_vectors(camera.look, by)});
}

/* Makes all things `factor` times as large: a perspective camera goes nearer. */
function zoom_view(factor) {
  if (!camera.perspective) return set_camera({...camera, extent: camera.extent / factor});
  const by = add_vectors(camera.eye, pivot_of(camera), -1).map(value => value * (1 / factor - 1));
  set_camera({...camera, eye: add_vectors(camera.eye, by), look: add_vectors(camera.look, by)});
}

/* ---- objects and lights ---- */

/* Returns the way in the scene of a drag by pixels, at a place. */
function way_of(x, y, place) {
  const {right, up} = view_axes(camera), step = pixel_length(camera, place);
  return add_vectors(right.map(value => x * step * value), up, -y * step);
}

const TURN_PER_PIXEL = 0.01; /* radians */

/* What a drag by some pixels does, by the tool. */
const DRAGS = {
  turn: (x, y) => turn_view(x * TURN_PER_PIXEL, y * TURN_PER_PIXEL),
  pan: pan_view,
  move(x, y) {
    const object = chosen_object();
    if (object) edit_object(GEOMETRY, parts => move_object(parts, way_of(x, y, place_of_object(object))));
  },
  rotate(x, y) {
    const {right, up} = view_axes(camera), axis = add_vectors(up.map(value => value * x), right, y), angle = length_of(axis);
    if (angle > 0) edit_object(GEOMETRY, parts => rotate_object(parts, angle * TURN_PER_PIXEL * 180 / Math.PI, unit(axis)));
  },
  scale(x, y) { edit_object(GEOMETRY, parts => scale_object(parts, Math.exp((x - y) * TURN_PER_PIXEL / 2))); },
};

/* ---- gestures ---- */

function begin_gesture() {
  gesture = {recorded: false, moving: true};
}

/* Ends a gesture, and asks for the whole picture: now, as an edit may wait for it, and when the last edit is made. */
function end_gesture() {
  const of = gesture;
  gesture = null;
  want(false);
  edits.then(() => { if (of) of.moving = false; want(false); });
}

const pointers = new Map(); /* fingers and buttons that are down: [x, y] in the window */
let dragged = false;        /* the pointer has moved so far that this is no click */
const CLICK_PX = 4;

const picture_scale = () => shape.width / canvas.getBoundingClientRect().width;
const chosen_drag = () => document.querySelector("#drags :checked").value;

function press(event) {
  if (is_stack()) return;
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  canvas.setPointerCapture(event.pointerId);
  if (pointers.size === 1) { dragged = false; press.at = [event.clientX, event.clientY]; }
}

function drag_start() {
  if (dragged) return;
  dragged = true;
  canvas.classList.add("dragged");
  begin_gesture();
}

/* Two fingers zoom and shift. */
function pinch(event, before) {
  const other = [...pointers].find(([id]) => id !== event.pointerId)[1], now = [event.clientX, event.clientY];
  const apart = place => Math.max(1, Math.hypot(place[0] - other[0], place[1] - other[1]));
  drag_start();
  pan_view((now[0] - before[0]) / 2 * picture_scale(), (now[1] - before[1]) / 2 * picture_scale());
  zoom_view(apart(now) / apart(before));
}

function move(event) {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  if (!dragged && Math.hypot(event.clientX - press.at[0], event.clientY - press.at[1]) < CLICK_PX) return;
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  if (pointers.size > 1) return pinch(event, before);
  const [x, y] = [event.clientX - before[0], event.clientY - before[1]].map(value => value * picture_scale());
  drag_start();
  DRAGS[event.shiftKey || event.buttons & 6 ? "pan" : chosen_drag()](x, y);
}

function release(event) {
  pointers.delete(event.pointerId);
  if (pointers.size > 0 || !dragged) return;
  canvas.classList.remove("dragged");
  end_gesture();
}

/* A turn of the wheel is a gesture that ends when the wheel rests. */
function roll(event) {
  if (is_stack()) return;
  event.preventDefault();
  if (!gesture) begin_gesture();
  zoom_view(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)));
  clearTimeout(roll.ends);
  roll.ends = setTimeout(end_gesture, 200);
}

const KEY_TURN = Math.PI / 36, KEY_PAN = 20, KEY_ZOOM = 1.15;
const KEYS = {
  a: () => turn_view(-KEY_TURN, 0), d: () => turn_view(KEY_TURN, 0),
  w: () => turn_view(0, -KEY_TURN), s: () => turn_view(0, KEY_TURN),
  A: () => pan_view(-KEY_PAN, 0), D: () => pan_view(KEY_PAN, 0), W: () => pan_view(0, -KEY_PAN), S: () => pan_view(0, KEY_PAN),
  "+": () => zoom_view(KEY_ZOOM), "-": () => zoom_view(1 / KEY_ZOOM),
};

function turn_by_key(event) {
  if (is_stack() || event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key]();
}

/* ---- handles of lights ---- */

/* The handle of a directional light stands off the pivot, towards the light. */
const light_place = light => light.position || add_vectors(pivot_of(camera), unit(light.direction),
  (camera.perspective ? length_of(add_vectors(camera.look, camera.eye, -1)) * 0.3 : camera.extent * 0.35));

function moved_light(light, by) {
  if (light.position) return add_vectors(light.position, by);
  const pivot = pivot_of(camera);
  return unit(add_vectors(add_vectors(light_place(light), by), pivot, -1));
}

function set_light_vector(i, vector) {
  const light = scene.lights[i];
  Object.assign(light, light.position ? {position: vector} : {direction: vector});
  edit(GEOMETRY, (text, {line}) => with_light(text, line, {vector}), () => scene.lights[i]);
  show_handles();
}

/* Drags a light. A click passes through its handle to the picture. */
function drag_handle(i, event) {
  const step = ([x, y]) => way_of(x * picture_scale(), y * picture_scale(), light_place(scene.lights[i]));
  let last = [event.clientX, event.clientY];
  event.target.setPointerCapture(event.pointerId);
  event.target.onpointermove = next => {
    if (!gesture) begin_gesture();
    set_light_vector(i, moved_light(scene.lights[i], step([next.clientX - last[0], next.clientY - last[1]])));
    last = [next.clientX, next.clientY];
  };
  event.target.onpointerup = event.target.onpointercancel = () => {
    event.target.onpointermove = null;
    gesture ? end_gesture() : pick_by_pointer(event);
  };
}

/* Returns the colour of a light on an sRGB display, as bright as it can be. */
function light_colour({illuminant}) {
  const rgb = apply(scene.displays[0].matrix, apply(standard_observer.weights, scene.illuminants[illuminant].radiance));
  const largest = Math.max(...rgb, 1e-9);
  return `rgb(${rgb.map((value, c) => encoders(scene.displays[0])[c](value / largest)).join(",")})`;
}

function show_handles() {
  const svg = element("handles"), size = 9 * picture_scale();
  if (svg.childElementCount !== scene.lights.length)
    svg.replaceChildren(...scene.lights.map((_, i) => {
      const group = draw(svg, "g", {"data-light": i});
      draw(group, "circle", {});
      draw(group, "title", {}, `Light ${i + 1}: drag it`);
      draw(group, "text", {"text-anchor": "middle"}, String(i + 1));
      group.addEventListener("pointerdown", event => drag_handle(i, event));
      return group;
    }));
  svg.setAttribute("viewBox", `0 0 ${shape.width} ${shape.height}`);
  scene.lights.forEach((light, i) => {
    const {x, y, depth} = project(camera, light_place(light)), circle = svg.children[i].firstChild;
    const inside = (!camera.perspective || depth > 0) && x > 0 && y > 0 && x < shape.width && y < shape.height;
    for (const [name, value] of Object.entries({cx: clamp(x, size, shape.width - size), cy: clamp(y, size, shape.height - size),
      r: size, fill: light_colour(light), opacity: inside ? 1 : 0.55, "stroke-dasharray": inside ? "none" : "3 2"}))
      circle.setAttribute(name, value);
    for (const [name, value] of Object.entries({x: circle.getAttribute("cx"), y: +circle.getAttribute("cy") + 0.4 * size, "font-size": 1.2 * size}))
      svg.children[i].lastChild.setAttribute(name, value);
  });
}

function listen_to_drags() {
  canvas.addEventListener("pointerdown", press);
  canvas.addEventListener("pointermove", move);
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("wheel", roll, {passive: false});
  canvas.addEventListener("keydown", turn_by_key);
  canvas.addEventListener("contextmenu", event => { if (dragged) event.preventDefault(); });
  canvas.addEventListener("click", event => { if (dragged && !is_stack()) event.stopImmediatePropagation(); }, {capture: true});
}
