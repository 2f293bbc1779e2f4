/* SPDX-License-Identifier: MIT */
/* Draws an exported scene by WebGL2; the manual's page of exchange explains each file. Written for judges: every number that
 * it draws comes from those files. */

const LIGHTS = 8; /* of a group */
const LARGEST = 8192;  /* side of a picture that is judged in one piece */
const MOST_CAPS = 255; /* of shadow volumes that the stencil counts */
const COLOURS = 0, NUMBERS = 1, DEPTHS = 2, FRAGMENTS = 3, BLACK = 4; /* what a fragment shows */

/* What this browser or its GPU cannot draw, and so did not. */
class NotTried extends Error {}

const vertex_shader = `#version 300 es
precision highp float;
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 place;
layout(location = 3) in vec2 number;
uniform mat4 projection, matrix;
uniform mat3 normals;
uniform vec3 constant, diffuse[${LIGHTS}], specular[${LIGHTS}], attenuation[${LIGHTS}], axis[${LIGHTS}];
uniform vec4 source[${LIGHTS}];              // w 0: directional
uniform vec2 spot[${LIGHTS}];                // cosine of the cutoff, exponent
uniform float gloss, instance;               // gloss -1: no highlight
uniform bool lit[${LIGHTS}], local;
out vec3 front, back;
flat out vec3 flat_front, flat_back, its;
out vec2 at;
invariant gl_Position;
vec3 shade(vec3 eye, vec3 n) {
    vec3 sum = constant;
    for (int i = 0; i < ${LIGHTS}; i++) {
        if (!lit[i]) continue;
        vec3 to = source[i].w == 0.0 ? source[i].xyz : source[i].xyz - eye;
        float d = length(to), part = source[i].w == 0.0 ? 1.0 : 1.0 / (attenuation[i].x + d * (attenuation[i].y + d * attenuation[i].z));
        vec3 l = to / d;
        if (spot[i].x > -1.0) {
            float along = dot(-l, normalize(axis[i]));
            part *= along < spot[i].x ? 0.0 : spot[i].y == 0.0 ? 1.0 : pow(along, spot[i].y);
        }
        float cosine = dot(n, l);
        if (cosine <= 0.0) continue;
        sum += part * cosine * diffuse[i];
        float highlight = dot(n, normalize(l + (local ? normalize(-eye) : vec3(0, 0, 1))));
        if (gloss >= 0.0 && (highlight > 0.0 || gloss == 0.0)) sum += part * (gloss == 0.0 ? 1.0 : pow(highlight, gloss)) * specular[i];
    }
    return sum;
}
void main() {
    vec4 eye = matrix * vec4(position, 1);
    vec3 n = normalize(normals * normal);
    flat_front = front = shade(eye.xyz, n);
    flat_back = back = shade(eye.xyz, -n);
    its = vec3(number, instance);
    at = place;
    gl_Position = projection * eye;
}`;
const fragment_shader = `#version 300 es
precision highp float;
precision highp sampler2D;
in vec3 front, back;
flat in vec3 flat_front, flat_back, its;
in vec2 at;
uniform bool two_sided, is_flat, textured;
uniform int what;
uniform sampler2D image, depths;
out vec4 colour;
void main() {
    bool is_back = two_sided && !gl_FrontFacing;
    vec3 light = is_flat ? (is_back ? flat_back : flat_front) : is_back ? back : front;
    colour = vec4(0);
    if (what == ${COLOURS}) colour = vec4(textured ? light * texture(image, at).rgb : light, 1);
    if (what == ${NUMBERS}) colour = vec4(its, 1);
    if (what == ${DEPTHS}) colour = vec4(texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r, 0, 0, 1);
    if (what == ${FRAGMENTS}) colour = vec4(1);
}`;

const transposed = rows => rows.map((_, i) => rows[4 * (i % 4) + (i >> 2)]);
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
/* The cofactors of the upper 3x3, which turn normals. */
const cofactors = m => [0, 1, 2].flatMap(c => [0, 1, 2].map(r => {
  const at = (i, k) => m[4 * ((r + i) % 3) + (c + k) % 3];
  return at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1);
}));

/* ---- the files ---- */

const numbers_in = (Kind, bytes) => new Kind(bytes.buffer, bytes.byteOffset, bytes.byteLength / Kind.BYTES_PER_ELEMENT);

function read_source(words) {
  const n = words.map(Number), spot = words.indexOf("spot");
  return {source: [...n.slice(2, 5), words[1] === "positional" ? 1 : 0], attenuation: n.slice(6, 9),
          axis: spot < 0 ? [0, 0, -1] : n.slice(spot + 1, spot + 4),
          spot: spot < 0 ? [-1, 0] : [Math.cos(n[spot + 4] * Math.PI / 180), n[spot + 5]]};
}

/* Reads scene.txt and passes.txt of `files`, a Map from names to bytes. */
function read_exported(files, prefix) {
  const lines = name => new TextDecoder().decode(files.get(prefix + name)).trim().split("\n").map(line => line.split(" "));
  const scene = {meshes: [], textures: [], instances: [], sources: [], first: [], volumes: [], bands: [], passes: lines("passes.txt")};
  for (const [word, ...words] of lines("scene.txt")) {
    const n = words.map(Number), of = Kind => numbers_in(Kind, files.get(`${prefix}${Kind === Int32Array ? "triangles" : "vertices"}-${n[0]}.bin`));
    if (word === "id") scene.id = words[0];
    if (word === "size") [scene.width, scene.height] = n;
    if (word === "shading") scene.flat = words[0] === "flat";
    if (word === "viewer") scene.local = words[0] === "local";
    if (word === "projection") scene.projection = n;
    if (word === "band") scene.bands.push(words.slice(1).join(" "));
    if (word === "mesh") scene.meshes[n[0]] = {vertices: of(Float32Array), triangles: of(Int32Array)};
    if (word === "texture") scene.textures[n[0]] = {width: n[1], height: n[2], linear: words[3] !== "nearest", mipmaps: words[3] === "mipmaps", spectral: words[4] === "spectral"};
    if (word === "group") scene.first[n[0]] = n[2];
    if (word === "source") scene.sources[n[0]] = read_source(words);
    if (word === "instance") scene.instances.push({number: n[0], mesh: n[2], material: n[4], texture: n[6], two_sided: words[7] === "two-sided",
                                                   clockwise: words[8] === "clockwise", matrix: n.slice(10)});
    if (word === "volume") scene.volumes.push({group: n[2], n: n[4], n_outward: n[6], n_caps: n[8], clockwise: words[9] === "clockwise", matrix: n.slice(11),
                                               corners: numbers_in(Float32Array, files.get(`${prefix}volume-${n[0]}.bin`))});
  }
  return scene;
}

/* Returns the materials, with their lights, under each group of lights in a pass. */
function materials_of(scene, band) {
  const groups = new Map();
  for (const words of scene.passes) {
    const [first, group, material, ...n] = words.slice(1).map(Number);
    if (first !== band || words[0] === "end") continue;
    if (!groups.has(group)) groups.set(group, []);
    if (words[0] === "material") groups.get(group)[material] = {constant: n.slice(0, 3), gloss: n[3], lights: []};
    else groups.get(group)[material].lights[n[0] - scene.first[group]] = n.slice(1);
  }
  return groups;
}

/* ---- WebGL ---- */

/* Opens a context of its own. */
function open_webgl() {
  const gl = document.createElement("canvas").getContext("webgl2", {antialias: false});
  if (!gl) throw new NotTried("this browser has no WebGL2");
  return gl;
}

/* Returns the GPU's facts, as WebGL names them. */
function webgl_facts(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return {renderer: gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER), version: gl.getParameter(gl.VERSION),
          subpixel_bits: gl.getParameter(gl.SUBPIXEL_BITS)};
}

function require_extensions(gl, scene) {
  const largest = Math.min(LARGEST, gl.getParameter(gl.MAX_TEXTURE_SIZE)), sides = [scene, ...scene.textures.filter(Boolean)].flatMap(({width, height}) => [width, height]);
  if (!gl.getExtension("EXT_color_buffer_float")) throw new NotTried("this GPU draws no floats of 32 bits (EXT_color_buffer_float)");
  if (!gl.getExtension("OES_texture_float_linear") && scene.textures.some(({linear}) => linear))
    throw new NotTried("this GPU filters no floats of 32 bits (OES_texture_float_linear)");
  if (Math.max(...sides) > largest) throw new NotTried(`pictures and textures have at most ${largest} pixels a side here`);
  gl.depth_clamp = gl.getExtension("EXT_depth_clamp")?.DEPTH_CLAMP_EXT;
  if (!gl.depth_clamp && scene.volumes.length > 0) throw new NotTried("this GPU clamps no depths, which shadows need (EXT_depth_clamp)");
}

function use_program(gl) {
  const program = gl.createProgram(), places = {};
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex_shader], [gl.FRAGMENT_SHADER, fragment_shader]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.place = name => places[name] ??= gl.getUniformLocation(program, name);
}

function make_target(gl, scene, format) {
  const name = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, name);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, scene.width, scene.height);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
  return name;
}

/* Draws into floats from here on, and into depths and stencil if there are any. */
function use_targets(gl, colours, depths) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colours, 0);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_STENCIL_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
  if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE) throw new NotTried("this GPU has no target of floats with 24 bits of depth");
}

/* Each triangle has corners of its own, which have its number. */
function load_mesh(gl, mesh) {
  const corners = new Float32Array(mesh.triangles.length * 10);
  mesh.triangles.forEach((vertex, i) => {
    corners.set(mesh.vertices.subarray(8 * vertex, 8 * vertex + 8), 10 * i);
    corners.set([Math.floor(i / 3) % 65536, Math.floor(i / 3 / 65536)], 10 * i + 8);
  });
  mesh.array = load_corners(gl, corners, [3, 3, 2, 2]);
}

/* Loads corners with attributes of these sizes, and returns their vertex array. */
function load_corners(gl, corners, sizes) {
  const array = gl.createVertexArray(), stride = sizes.reduce((sum, size) => sum + size);
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  sizes.reduce((offset, size, at) => {
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, gl.FLOAT, false, 4 * stride, 4 * offset);
    return offset + size;
  }, 0);
  return array;
}

/* Loads the textures of all passes (band -1), or those of a pass. */
function load_textures(gl, scene, files, prefix, band) {
  scene.textures.forEach((texture, i) => {
    if (texture.spectral !== band >= 0) return;
    const texels = numbers_in(Float32Array, files.get(band < 0 ? `${prefix}texture-${i}.bin` : `${prefix}texture-${i}-${band}.bin`));
    const grey = texture.spectral ? texels : new Float32Array(3 * texels.length).map((_, k) => texels[Math.floor(k / 3)]);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture.name ??= gl.createTexture());
    let {width, height} = texture;
    for (let level = 0, first = 0; first < grey.length; level++) {
      const end = first + 3 * width * height;
      gl.texImage2D(gl.TEXTURE_2D, level, gl.RGB32F, width, height, 0, gl.RGB, gl.FLOAT, grey.subarray(first, end));
      [first, width, height] = [end, Math.max(1, width >> 1), Math.max(1, height >> 1)];
    }
    const filter = texture.linear ? gl.LINEAR : gl.NEAREST;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, texture.mipmaps ? gl.LINEAR_MIPMAP_LINEAR : filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  });
}

/* ---- drawing ---- */

function set_lights(gl, scene, material, group) {
  for (let i = 0; i < LIGHTS; i++) {
    const light = material.lights[i], source = scene.sources[scene.first[group] + i];
    gl.uniform1i(gl.place(`lit[${i}]`), Boolean(light && source));
    if (!light || !source) continue;
    gl.uniform3fv(gl.place(`diffuse[${i}]`), light.slice(0, 3));
    gl.uniform3fv(gl.place(`specular[${i}]`), light.slice(3));
    gl.uniform4fv(gl.place(`source[${i}]`), source.source);
    gl.uniform3fv(gl.place(`attenuation[${i}]`), source.attenuation);
    gl.uniform3fv(gl.place(`axis[${i}]`), source.axis);
    gl.uniform2fv(gl.place(`spot[${i}]`), source.spot);
  }
  gl.uniform3fv(gl.place("constant"), material.constant);
  gl.uniform1f(gl.place("gloss"), material.gloss);
}

function draw_instance(gl, scene, instance) {
  const mesh = scene.meshes[instance.mesh], texture = scene.textures[instance.texture], mirrored = instance.clockwise ? -1 : 1;
  gl.uniform1i(gl.place("textured"), Boolean(texture));
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D, texture?.name ?? null);
  gl.uniform1i(gl.place("two_sided"), instance.two_sided);
  gl.frontFace(instance.clockwise ? gl.CW : gl.CCW);
  gl.uniformMatrix4fv(gl.place("matrix"), false, transposed(instance.matrix));
  gl.uniformMatrix3fv(gl.place("normals"), false, cofactors(instance.matrix).map(value => value * mirrored));
  gl.uniform1f(gl.place("instance"), instance.number);
  gl.bindVertexArray(mesh.array);
  gl.drawArrays(gl.TRIANGLES, 0, mesh.triangles.length);
}

/* Draws all instances; COLOURS: with these materials, under a group of lights. */
function draw_all(gl, scene, what, materials, group) {
  const counts = what === FRAGMENTS;
  gl.uniform1i(gl.place("what"), what);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl[counts ? "disable" : "enable"](gl.DEPTH_TEST);
  gl[counts ? "enable" : "disable"](gl.BLEND);
  for (const instance of scene.instances) {
    if (materials?.[instance.material]) set_lights(gl, scene, materials[instance.material], group);
    draw_instance(gl, scene, instance);
  }
}

/* Draws all pixels. */
function fill(gl, scene, what) {
  gl.uniform1i(gl.place("what"), what);
  gl.uniformMatrix4fv(gl.place("projection"), false, IDENTITY);
  gl.uniformMatrix4fv(gl.place("matrix"), false, IDENTITY);
  gl.bindVertexArray(gl.whole ??= load_corners(gl, new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), [3]));
  gl.disable(gl.DEPTH_TEST);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.uniformMatrix4fv(gl.place("projection"), false, transposed(scene.projection));
}

/* ---- shadows ---- */

function count_triangles(gl, first, n, outward) {
  gl.stencilOpSeparate(outward ? gl.BACK : gl.FRONT, gl.KEEP, gl.INCR_WRAP, gl.KEEP);
  gl.stencilOpSeparate(outward ? gl.FRONT : gl.BACK, gl.KEEP, gl.DECR_WRAP, gl.KEEP);
  gl.drawArrays(gl.TRIANGLES, 3 * first, 3 * n);
}

/* Depths are clamped but for the caps, which are cut as surfaces are. */
function count_volume(gl, volume) {
  gl.frontFace(volume.clockwise ? gl.CW : gl.CCW);
  gl.uniformMatrix4fv(gl.place("matrix"), false, transposed(volume.matrix));
  gl.bindVertexArray(volume.array ??= load_corners(gl, volume.corners, [3]));
  gl.enable(gl.depth_clamp);
  count_triangles(gl, volume.n_caps, volume.n_outward - volume.n_caps, true);
  gl.disable(gl.depth_clamp);
  count_triangles(gl, 0, volume.n_caps, true);
  count_triangles(gl, volume.n_outward, volume.n - volume.n_outward, false);
}

/* Makes black what lies in some volume, and clears the counts. */
function darken(gl, scene) {
  gl.colorMask(true, true, true, true);
  gl.stencilFunc(gl.NOTEQUAL, 0, 255);
  gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
  fill(gl, scene, BLACK);
  gl.clear(gl.STENCIL_BUFFER_BIT);
}

/* Takes the light of a group from where its volumes lie on the surfaces that are drawn. */
function shadow_group(gl, scene, group) {
  const volumes = scene.volumes.filter(volume => volume.group === group);
  gl.enable(gl.STENCIL_TEST);
  gl.depthMask(false);
  for (let i = 0; i < volumes.length;) {
    gl.colorMask(false, false, false, false);
    gl.enable(gl.DEPTH_TEST);
    gl.stencilFunc(gl.ALWAYS, 0, 255);
    for (let caps = 0; i < volumes.length; i++) {
      const {n_caps, n, n_outward} = volumes[i], more = n_caps + n - n_outward;
      if (caps > 0 && caps + more > MOST_CAPS) break;
      caps += more;
      count_volume(gl, volumes[i]);
    }
    darken(gl, scene);
  }
  gl.depthMask(true);
  gl.disable(gl.STENCIL_TEST);
}

/* ---- reading ---- */

/* Waits until the GPU has drawn, so that a read does not stop the page. Yields how often it has waited. */
function* finish(gl) {
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  let waits = 0;
  do yield waits++; while (fence && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED);
  gl.deleteSync(fence);
}

/* Returns four floats a pixel; the first row is the top one. */
function* read_pixels(gl, {width, height}) {
  yield* finish(gl);
  const rows = new Float32Array(4 * width * height), out = new Float32Array(rows.length), n = 4 * width;
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, rows);
  for (let y = 0; y < height; y++) out.set(rows.subarray(n * y, n * (y + 1)), n * (height - 1 - y));
  return out;
}

/* The depth that is left when all is drawn, as 24 bits above the number of fragments. Half floats count exactly to 2048, and
 * every GPU adds them. */
function* read_depths(gl, scene) {
  use_targets(gl, gl.colours, null);
  gl.activeTexture(gl.TEXTURE1);
  gl.bindTexture(gl.TEXTURE_2D, gl.depths);
  fill(gl, scene, DEPTHS);
  const depths = yield* read_pixels(gl, scene);
  gl.activeTexture(gl.TEXTURE0);
  use_targets(gl, make_target(gl, scene, gl.RGBA16F), null);
  draw_all(gl, scene, FRAGMENTS);
  const fragments = yield* read_pixels(gl, scene);
  return new Uint32Array(depths.length / 4).map((_, i) => Math.round(depths[4 * i] * 0xffffff) * 256 + fragments[4 * i] % 256);
}

/* ---- a scene ---- */

function prepare(gl, scene, files, prefix) {
  require_extensions(gl, scene);
  use_program(gl);
  gl.colours = make_target(gl, scene, gl.RGBA32F);
  gl.depths = make_target(gl, scene, gl.DEPTH24_STENCIL8);
  use_targets(gl, gl.colours, gl.depths);
  gl.viewport(0, 0, scene.width, scene.height);
  gl.disable(gl.DITHER);
  gl.depthFunc(gl.LESS);
  gl.blendFunc(gl.ONE, gl.ONE);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.STENCIL_BUFFER_BIT);
  gl.uniformMatrix4fv(gl.place("projection"), false, transposed(scene.projection));
  gl.uniform1i(gl.place("local"), scene.local);
  gl.uniform1i(gl.place("is_flat"), scene.flat);
  gl.uniform1i(gl.place("depths"), 1);
  scene.meshes.forEach(mesh => load_mesh(gl, mesh));
  load_textures(gl, scene, files, prefix, -1);
}

/* Draws a scene of `files`, and adds what `spectral judge` reads to `out`, both Maps from names to bytes. Yields between its
 * steps, so that the page stays alive. Throws NotTried, or the browser's errors. */
function* draw_scene(gl, files, prefix, out) {
  const scene = read_exported(files, prefix), {renderer, version, subpixel_bits} = webgl_facts(gl);
  const put = (name, numbers) => out.set(prefix + name, new Uint8Array(numbers.buffer));
  prepare(gl, scene, files, prefix);
  for (let band = 0; band < scene.bands.length; band += 3) {
    const sum = new Float32Array(4 * scene.width * scene.height);
    load_textures(gl, scene, files, prefix, band);
    for (const [group, materials] of materials_of(scene, band)) {
      draw_all(gl, scene, COLOURS, materials, group);
      shadow_group(gl, scene, group);
      const colours = yield* read_pixels(gl, scene);
      colours.forEach((value, i) => sum[i] += value);
    }
    put(`colours-${band}.bin`, sum);
  }
  draw_all(gl, scene, NUMBERS);
  put("numbers.bin", yield* read_pixels(gl, scene));
  put("depths.bin", yield* read_depths(gl, scene));
  const facts = `id ${scene.id}\nrenderer WebGL by ${renderer}\nversion ${version}\nsize ${scene.width} ${scene.height}\nsubpixel-bits ${subpixel_bits}\ndepth-bits 24\n`;
  out.set(prefix + "drawn.txt", new TextEncoder().encode(facts));
  const error = gl.getError();
  if (error !== gl.NO_ERROR) throw Error(`WebGL reports the error ${error}`);
}
