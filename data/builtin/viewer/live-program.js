/* SPDX-License-Identifier: MIT */
/* The program in workers of a page. */

/* The workers run the scripts that they share with the page, and their own. */
function worker_address() {
  if (!worker_address.made) {
    const texts = [...document.querySelectorAll("script.shared"), element("worker")].map(script => script.textContent);
    worker_address.made = URL.createObjectURL(new Blob(['"use strict";\n', ...texts], {type: "text/javascript"}));
  }
  return worker_address.made;
}

/* Takes the files of a scene out of the bytes of all, which are read up to reader.at. Texts are strings. */
function read_files(list, reader) {
  const files = {};
  for (const {name, length, also} of list) {
    const bytes = reader.bytes.subarray(reader.at, reader.at += length);
    files[name] = bytes.includes(0) ? bytes.slice() : new TextDecoder().decode(bytes);
    if (also) files[also] = files[name];
  }
  return files;
}

/* A worker that runs the program, as a compiled module. */
class Program {
  constructor(module) {
    this.worker = new Worker(worker_address());
    this.waiting = new Map();
    this.files = {};
    this.number = 0;
    this.worker.onmessage = ({data}) => {
      const answer = this.waiting.get(data.id);
      this.waiting.delete(data.id);
      answer(data);
    };
    this.worker.onerror = ({message}) => this.end(`error: the worker ended: ${message}`);
    this.ask({task: "start", module});
  }

  ask(message, moved = []) {
    return new Promise(then => {
      this.waiting.set(++this.number, then);
      this.worker.postMessage({...message, id: this.number}, moved);
    });
  }

  /* Sends the files of a state that the worker has not. */
  send_files(files) {
    const changed = Object.entries(files).filter(([name, content]) => this.files[name] !== content);
    const gone = Object.keys(this.files).filter(name => !(name in files));
    if (changed.length + gone.length > 0) this.ask({task: "files", files: Object.fromEntries(changed), gone});
    this.files = files;
  }

  end(error = "stopped") {
    this.worker.terminate();
    for (const answer of this.waiting.values()) answer({error});
    this.waiting.clear();
  }
}
