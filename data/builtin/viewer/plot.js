/* SPDX-License-Identifier: MIT */
/* Plots and tables of spectra. */

/* ---- the plot ---- */

const SVG = "http://www.w3.org/2000/svg";

function draw(parent, name, attributes, text) {
  const node = document.createElementNS(SVG, name);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

/* Dash patterns: each differs from that of the curve before. */
const DASHES = ["none", "14 4", "2 3", "9 3 2 3", "5 5"];

/* Returns how a curve is drawn, by its number among those of its kind. Hues never repeat: each is a golden section of the circle
 * away from the one before. Of the first ten, those with the same dashes differ in lightness, too: a reader who sees no hues can
 * follow them. */
const look_of = i => `--hue: ${(55 + 137.508 * i) % 360}; --bright: ${Math.floor(i / DASHES.length) % 2}; stroke-dasharray: ${DASHES[i % DASHES.length]}`;

/* Draws a line as that of a curve. */
const draw_curve = (parent, {style, look}, d) => draw(parent, "path", {class: `curve ${style}`, ...(look && {style: look}), d});

/* Returns the least step of 1, 2 or 5 times a power of ten with at most `most` steps in a range. */
function tick_step(range, most) {
  const power = 10 ** Math.floor(Math.log10(range / most));
  return [1, 2, 5, 10].map(factor => factor * power).find(step => range / step <= most);
}

function ticks(first, last, most) {
  const step = tick_step(last - first, most), out = [];
  for (let i = Math.ceil(first / step - 1e-9); i * step <= last + 1e-9 * step; i++)
    out.push(+(i * step).toPrecision(12));
  return out;
}

/* Returns the largest value of an axis, a whole number of steps. */
function axis_end(curves, least) {
  const largest = Math.max(least, ...curves.map(({values}) => Math.max(...values)));
  const step = tick_step(largest, 5);
  return Math.ceil(largest / step - 1e-9) * step;
}

/* Returns the colours of single wavelengths for the CIE 1931 observer on an sRGB display. */
function visible_stops() {
  const {weights} = standard_observer, display = scene.displays[0];
  const rgb = scene.wavelengths.map((_, i) => apply(display.matrix, weights.map(row => row[i])));
  const largest = Math.max(...rgb.flat());
  return rgb.map(row => `rgb(${row.map((value, c) => encoders(display)[c](value / largest)).join(",")})`);
}

function draw_visible(svg, frame) {
  if (!standard_observer) return; /* none sees these wavelengths */
  const gradient = draw(draw(svg, "defs", {}), "linearGradient", {id: "visible"});
  const offset = nm => (nm - frame.first) / (frame.last - frame.first);
  visible_stops().forEach((colour, i) =>
    draw(gradient, "stop", {offset: offset(scene.wavelengths[i]), "stop-color": colour}));
  draw(svg, "rect", {x: frame.left, y: frame.bottom, width: frame.across, height: 7, fill: "url(#visible)"});
}

function draw_axes(svg, frame) {
  for (const nm of ticks(frame.first, frame.last, frame.right > 500 ? 12 : 6)) {
    draw(svg, "path", {class: "grid", d: `M${frame.x(nm)} ${frame.top}V${frame.bottom}`});
    draw(svg, "text", {x: frame.x(nm), y: frame.bottom + 21, "text-anchor": "middle"}, short_number.format(nm));
  }
  for (const value of ticks(0, frame.end, 5)) {
    const y = frame.y_of.radiance(value);
    draw(svg, "path", {class: "grid", d: `M${frame.left} ${y}H${frame.right}`});
    draw(svg, "text", {x: frame.left - 6, y: y + 4, "text-anchor": "end"}, short_number.format(value));
  }
  for (const {axis, place, end, title} of frame.right_axes) {
    for (const value of ticks(0, end, 5))
      draw(svg, "text", {class: `of-${axis}`, x: place, y: frame.y_of[axis](value) + 4}, short_number.format(value));
    draw(svg, "text", {class: `of-${axis}`, x: place + AXIS_WIDTH - 8, y: 12, "text-anchor": "end"}, title);
  }
  draw(svg, "rect", {class: "axis", x: frame.left, y: frame.top, width: frame.across, height: frame.down});
  draw(svg, "text", {x: frame.left + frame.across / 2, y: frame.bottom + 38, "text-anchor": "middle"},
    "wavelength (nm)");
  draw(svg, "text", {x: 2, y: 12}, `radiance (${scene.radiance_unit || "relative"})`);
}

/* The axes on the right, from the inner one: the title, and the least value at the end. A curve without one of them is radiance. */
const AXES = {relative: {title: "reflectance, excitation", least: 1}, light: {title: "light", least: 1e-3}};
const AXIS_WIDTH = 36;

/* Returns the layout of the plot, with functions from values to places. */
function plot_frame(curves) {
  const width = clamp(element("chart").clientWidth, 280, 900), height = width > 500 ? 330 : 270;
  const nm = scene.wavelengths, alone = n_bands > 1 ? 0 : 1, of = axis => curves.filter(curve => curve.axis === axis);
  const names = Object.keys(AXES).filter(axis => of(axis).length > 0), right = width - Math.max(12, AXIS_WIDTH * names.length);
  const frame = {width, height, left: 46, right, top: 22, bottom: height - 46, first: nm[0] - alone, last: nm[n_bands - 1] + alone,
    end: axis_end(of(undefined), 1e-3), y_of: {}, right_axes: names.map((axis, i) => ({axis, title: AXES[axis].title,
      end: axis_end(of(axis), AXES[axis].least), place: right + 6 + AXIS_WIDTH * i}))};
  frame.across = frame.right - frame.left;
  frame.down = frame.bottom - frame.top;
  const rounded = place => +place.toFixed(2);
  frame.x = value => rounded(frame.left + (value - frame.first) / (frame.last - frame.first) * frame.across);
  for (const {axis, end} of [{axis: "radiance", end: frame.end}, ...frame.right_axes])
    frame.y_of[axis] = value => rounded(frame.bottom - value / end * frame.down);
  return frame;
}

function curve_path({values, axis}, frame) {
  const y = frame.y_of[axis || "radiance"];
  const points = Array.from(values, (value, i) => `${frame.x(scene.wavelengths[i])} ${y(value)}`);
  return n_bands > 1 ? "M" + points.join("L") : `M${points[0]}m-9 0h18`;
}

function show_plot(curves) {
  const shown = curves.filter(curve => !is_hidden(curve)), frame = plot_frame(shown);
  const svg = draw(document.createDocumentFragment(), "svg", {viewBox: `0 0 ${frame.width} ${frame.height}`,
    role: "img", "aria-label": `Plot over wavelength of ${shown.map(({name}) => name).join(", ")}`});
  draw_visible(svg, frame);
  draw_axes(svg, frame);
  for (const curve of shown.slice().reverse()) draw_curve(svg, curve, curve_path(curve, frame));
  const marks = draw(svg, "g", {});
  svg.addEventListener("pointermove", event => show_value_at(event, marks, shown, frame));
  svg.addEventListener("pointerleave", () => { set_text("at-cursor", ""); marks.replaceChildren(); });
  element("chart").replaceChildren(svg);
}

/* Shows the value of the curve nearest to the pointer, at the nearest wavelength. */
function show_value_at(event, marks, shown, frame) {
  const box = marks.ownerSVGElement.getBoundingClientRect(), scale = frame.width / box.width, nm = scene.wavelengths;
  const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
  const nearest = (list, apart) => list.reduce((best, one, i) => apart(one, i) < apart(list[best], best) ? i : best, 0);
  const at = nearest(nm, value => Math.abs(frame.x(value) - x)), y_of = ({axis, values}) => frame.y_of[axis || "radiance"](values[at]);
  const curve = shown[nearest(shown, one => Math.abs(y_of(one) - y))];
  marks.replaceChildren();
  draw(marks, "path", {class: "cursor", d: `M${frame.x(nm[at])} ${frame.top}V${frame.bottom}`});
  if (!curve) return;
  draw_curve(marks, curve, curve_path(curve, frame)).classList.add("near");
  draw(marks, "circle", {class: "cursor", cx: frame.x(nm[at]), cy: y_of(curve), r: 4});
  set_text("at-cursor", `${short_number.format(nm[at])} nm, ${curve.name}: ${with_digits(4).format(curve.values[at])}`);
}

/* Returns whether a curve is switched off. Those that begin so are in the set when they are switched on. */
const is_hidden = ({name, off}) => hidden.has(name) !== Boolean(off);

function show_legend(curves) {
  const key = curves.map(({name, style, look}) => name + style + look).join();
  if (element("curves").dataset.shown === key) return; /* so that a checkbox keeps its focus */
  element("curves").dataset.shown = key;
  element("curves").replaceChildren(...curves.map(curve => {
    const {name, off} = curve;
    const [item, label, box] = ["li", "label", "input"].map(tag => document.createElement(tag));
    box.type = "checkbox";
    box.checked = !is_hidden({name, off});
    box.addEventListener("change", () => {
      box.checked !== Boolean(off) ? hidden.delete(name) : hidden.add(name);
      show_pixel();
    });
    label.className = "check";
    const sample = draw(label, "svg", {viewBox: "0 0 40 12", "aria-hidden": "true"});
    draw_curve(sample, curve, "M1 6H39");
    label.prepend(box);
    label.append(name);
    item.append(label);
    return item;
  }));
}

/* ---- values ---- */

const values_head = curves => ["nm", ...curves.map(({name}) => name)];

function show_values(curves) {
  if (!element("values-shown").open) return;
  const table = document.createElement("table");
  table.createTHead().append(table_row(values_head(curves), () => "col"));
  table.createTBody().append(...scene.wavelengths.map((nm, i) =>
    table_row([short_number.format(nm), ...curves.map(({values}) => with_digits(6).format(values[i]))])));
  element("values").replaceChildren(table);
}

function values_csv(curves) {
  const head = values_head(curves).map(name => `"${name.replaceAll('"', '""')}"`);
  const rows = scene.wavelengths.map((nm, i) => [nm, ...curves.map(({values}) => values[i].toPrecision(9))]);
  return [head, ...rows].map(row => row.join(",") + "\n").join("");
}

const save = (blob, ending) => save_as(blob, scene.scene.replace(/^.*[/]/, "").replace(/[.][^.]*$/, "") + ending);

