/* SPDX-License-Identifier: MIT */
/* A worker of a page: it runs the program. */

let program;              /* the compiled module */
const folder = new Map(); /* the files that the program sees, by their absolute paths */

const as_bytes = content => typeof content === "string" ? new TextEncoder().encode(content) : content;

/* Runs a command. Returns {status, output, errors}. */
function run(words) {
  const system = new System(program, folder, ["spectral", ...words]), status = system.run();
  return {status, output: system.output[1], errors: system.output[2].trim()};
}

/* Runs a command that writes a file, and returns {bytes} of the file, or {error}. */
function make(words, path) {
  const {status, errors} = run([...words, "-o", path]), file = folder.get(path);
  folder.delete(path);
  return status === 0 && file ? {bytes: file.content()} : {error: errors || `exit status ${status}`};
}

/* What a page can ask for. An answer may name buffers that it moves to the page. */
const tasks = {
  start({module}) { program = module; return {}; },
  files({files, gone}) {
    for (const name of gone || []) folder.delete("/" + name);
    for (const [name, content] of Object.entries(files)) folder.set("/" + name, new MemoryFile(as_bytes(content)));
    return {};
  },
  /* Takes the files of a folder out of memory. */
  take({below}) {
    const taken = [...folder].filter(([path, file]) => file && path.startsWith(below));
    return {files: new Map(taken.map(([path, file]) => [path.slice(below.length), file.content()]))};
  },
  run({words}) { return run(words); },
  make({words, path}) { return make(words, path); },
};

onmessage = ({data}) => {
  let answer;
  try {
    answer = tasks[data.task](data);
  } catch (error) {
    answer = {error: `error: ${error.message}`};
  }
  const {moved = [], ...rest} = answer;
  postMessage({id: data.id, ...rest}, moved);
};
