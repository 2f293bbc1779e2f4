/* SPDX-License-Identifier: MIT */
/* The system that the program runs on: a folder in memory, and the functions of WASI (snapshot preview 1) that the
 * program imports. Each command runs in an instance of its own, which is thrown away with all its memory. */

/* Errors and kinds of files, as WASI numbers them. */
const ERRNO = {badf: 8, exist: 20, inval: 28, isdir: 31, noent: 44, notdir: 54, spipe: 70};
const FILE_TYPE = {character: 2, folder: 3, regular: 4};

const PIECE_BYTES = 4 << 20;

class Exit extends Error {
  constructor(status) { super(`exit ${status}`); this.status = status; }
}

/* A file of the folder: bytes in memory, or a Blob that is read piece by piece and cannot be changed. */
class MemoryFile {
  constructor(content = new Uint8Array(0)) {
    this.blob = content instanceof Uint8Array ? null : content;
    this.bytes = this.blob ? null : content;
    this.length = this.blob ? this.blob.size : content.length;
  }
  content() { return this.bytes.subarray(0, this.length); }
  read(into, at) {
    const n = Math.max(0, Math.min(into.length, this.length - at));
    if (n === 0) return 0;
    into.set(this.blob ? this.blob_piece(at, n) : this.bytes.subarray(at, at + n));
    return n;
  }
  /* Returns bytes of the blob. A read of the disk takes long, so that it reads a large piece. */
  blob_piece(at, n) {
    const within = () => this.piece && at >= this.piece_at && at + n <= this.piece_at + this.piece.length;
    if (!within()) {
      this.piece_at = at;
      this.piece = new Uint8Array(new FileReaderSync().readAsArrayBuffer(this.blob.slice(at, at + Math.max(n, PIECE_BYTES))));
    }
    return this.piece.subarray(at - this.piece_at, at - this.piece_at + n);
  }
  resize(length) {
    if (length > this.bytes.length) {
      const more = new Uint8Array(Math.max(length, 2 * this.bytes.length));
      more.set(this.content());
      this.bytes = more;
    } else if (length < this.length) this.bytes.fill(0, length, this.length);
    this.length = length;
  }
  write(from, at) {
    if (at + from.length > this.length) this.resize(at + from.length);
    this.bytes.set(from, at);
  }
}

/* Runs the program's functions over `files`, a Map from absolute paths to MemoryFiles; null is a folder. */
class System {
  constructor(module, files, words = []) {
    this.files = files;
    this.words = words;
    this.output = ["", "", ""]; /* what the program has written to its standard streams */
    this.inodes = new Map();
    this.open = [{kind: "stream"}, {kind: "stream"}, {kind: "stream"}, {kind: "folder", path: "/"}];
    this.text = [0, 1, 2].map(() => new TextDecoder());
    const imports = {};
    for (const {name} of WebAssembly.Module.imports(module)) imports[name] = (...values) => this[name](...values);
    this.instance = new WebAssembly.Instance(module, {wasi_snapshot_preview1: imports});
    this.exports = this.instance.exports;
  }

  get view() { return new DataView(this.exports.memory.buffer); }
  bytes(at, length) { return new Uint8Array(this.exports.memory.buffer, at, length); }
  string(at, length) { return new TextDecoder().decode(this.bytes(at, length)); }

  /* Runs the command line; returns its exit status. A trap, as of a stack that is full, is a failure of the system. */
  run() {
    try {
      this.exports._start();
      return 0;
    } catch (error) {
      if (error instanceof Exit) return error.status;
      this.output[2] += `error: the program ended: ${error.message}\n`;
      return 3;
    }
  }

  /* ---- arguments ---- */
  strings_sizes(strings, count, size) {
    this.view.setUint32(count, strings.length, true);
    this.view.setUint32(size, strings.reduce((sum, one) => sum + new TextEncoder().encode(one).length + 1, 0), true);
    return 0;
  }
  strings_get(strings, pointers, at) {
    for (const one of strings) {
      const bytes = new TextEncoder().encode(one + "\0");
      this.view.setUint32(pointers, at, true);
      this.bytes(at, bytes.length).set(bytes);
      pointers += 4;
      at += bytes.length;
    }
    return 0;
  }
  args_sizes_get(count, size) { return this.strings_sizes(this.words, count, size); }
  args_get(pointers, at) { return this.strings_get(this.words, pointers, at); }
  environ_sizes_get(count, size) { return this.strings_sizes([], count, size); }
  environ_get(pointers, at) { return this.strings_get([], pointers, at); }
  proc_exit(status) { throw new Exit(status); }
  clock_time_get(clock, precision, out) {
    this.view.setBigUint64(out, BigInt(Math.round(performance.now() * 1e6)), true);
    return 0;
  }

  /* ---- open files ---- */
  regular(fd) { const one = this.open[fd]; return one && one.kind === "file" ? one : null; }
  fd_advise() { return 0; }
  fd_sync() { return 0; }
  fd_close(fd) {
    if (!this.open[fd]) return ERRNO.badf;
    if (fd > 3) this.open[fd] = null;
    return 0;
  }
  fd_fdstat_get(fd, out) {
    const one = this.open[fd], view = this.view;
    if (!one) return ERRNO.badf;
    view.setUint8(out, {stream: FILE_TYPE.character, folder: FILE_TYPE.folder, file: FILE_TYPE.regular}[one.kind]);
    view.setUint16(out + 2, 0, true);
    for (const rights of [8, 16]) view.setBigUint64(out + rights, 0xffffffffffffffffn, true);
    return 0;
  }
  /* Writes a struct filestat: device, inode, kind, links, size, and no times. */
  status(kind, size, inode, out) {
    [1n, BigInt(inode), BigInt(kind), 1n, BigInt(size), 0n, 0n, 0n].forEach((value, i) =>
      this.view.setBigUint64(out + 8 * i, value, true));
    return 0;
  }
  inode(file) {
    if (!this.inodes.has(file)) this.inodes.set(file, this.inodes.size + 2);
    return this.inodes.get(file);
  }
  fd_filestat_get(fd, out) {
    const one = this.open[fd];
    if (!one) return ERRNO.badf;
    return one.kind === "file" ? this.status(FILE_TYPE.regular, one.file.length, this.inode(one.file), out)
      : this.status(one.kind === "folder" ? FILE_TYPE.folder : FILE_TYPE.character, 0, 1, out);
  }
  fd_filestat_set_size(fd, size) {
    const one = this.regular(fd);
    if (!one) return ERRNO.badf;
    one.file.resize(Number(size));
    return 0;
  }
  /* Calls move(bytes) for each piece of a list until one is not whole. */
  each_piece(list, n, moved, move) {
    let all = 0;
    for (let i = 0; i < n; i++) {
      const at = this.view.getUint32(list + 8 * i, true), length = this.view.getUint32(list + 8 * i + 4, true);
      const got = move(this.bytes(at, length), all);
      all += got;
      if (got < length) break;
    }
    this.view.setUint32(moved, all, true);
    return 0;
  }
  fd_pread(fd, list, n, offset, moved) {
    const one = this.regular(fd);
    return one ? this.each_piece(list, n, moved, (bytes, all) => one.file.read(bytes, Number(offset) + all)) : ERRNO.badf;
  }
  fd_pwrite(fd, list, n, offset, moved) {
    const one = this.regular(fd);
    if (!one || one.file.blob) return ERRNO.badf;
    return this.each_piece(list, n, moved, (bytes, all) => (one.file.write(bytes, Number(offset) + all), bytes.length));
  }
  fd_read(fd, list, n, moved) {
    const one = this.open[fd];
    if (!one || one.kind === "folder") return ERRNO.badf;
    return this.each_piece(list, n, moved, bytes => {
      const got = one.kind === "file" ? one.file.read(bytes, one.at) : 0;
      one.at += got;
      return got;
    });
  }
  fd_write(fd, list, n, moved) {
    const one = this.open[fd];
    if (!one || one.kind === "folder") return ERRNO.badf;
    return this.each_piece(list, n, moved, bytes => {
      if (one.kind === "stream") this.output[fd] += this.text[fd].decode(bytes, {stream: true});
      else { one.file.write(bytes, one.at); one.at += bytes.length; }
      return bytes.length;
    });
  }
  fd_seek(fd, offset, whence, out) {
    const one = this.regular(fd);
    if (!one) return this.open[fd] ? ERRNO.spipe : ERRNO.badf;
    const at = [0, one.at, one.file.length][whence] + Number(offset);
    if (!(at >= 0)) return ERRNO.inval;
    one.at = at;
    this.view.setBigUint64(out, BigInt(at), true);
    return 0;
  }
  fd_prestat_get(fd, out) {
    if (fd !== 3) return ERRNO.badf;
    this.view.setUint32(out, 0, true);
    this.view.setUint32(out + 4, 1, true);
    return 0;
  }
  fd_prestat_dir_name(fd, at) {
    this.bytes(at, 1)[0] = 47;
    return 0;
  }
  /* The program looks only for what killed processes left, and there is none. */
  fd_readdir(fd, at, length, cookie, used) {
    this.view.setUint32(used, 0, true);
    return 0;
  }

  /* ---- names ---- */
  path(fd, at, length) {
    const parts = [];
    for (const part of (this.open[fd].path + "/" + this.string(at, length)).split("/"))
      if (part === "..") parts.pop();
      else if (part !== "" && part !== ".") parts.push(part);
    return "/" + parts.join("/");
  }
  is_folder(path) {
    const prefix = path === "/" ? "/" : path + "/";
    return path === "/" || this.files.get(path) === null || [...this.files.keys()].some(one => one.startsWith(prefix));
  }
  path_open(fd, flags, at, length, how, rights, inheriting, fd_flags, out) {
    const path = this.path(fd, at, length), create = how & 1, exclusive = how & 4, truncate = how & 8;
    let file = this.files.get(path);
    if (!file && this.is_folder(path)) {
      if (create) return ERRNO.isdir;
      file = null;
    } else if (!file && !create) return ERRNO.noent;
    else if (file && create && exclusive) return ERRNO.exist;
    else if (file && (how & 2)) return ERRNO.notdir;
    else if (!file) this.files.set(path, file = new MemoryFile());
    else if (truncate) file.resize(0);
    let number = 4;
    while (this.open[number]) number++;
    this.open[number] = file ? {kind: "file", file, at: 0} : {kind: "folder", path};
    this.view.setUint32(out, number, true);
    return 0;
  }
  path_filestat_get(fd, flags, at, length, out) {
    const path = this.path(fd, at, length), file = this.files.get(path);
    if (file) return this.status(FILE_TYPE.regular, file.length, this.inode(file), out);
    return this.is_folder(path) ? this.status(FILE_TYPE.folder, 0, 1, out) : ERRNO.noent;
  }
  path_create_directory(fd, at, length) {
    const path = this.path(fd, at, length);
    if (this.files.has(path) || this.is_folder(path)) return ERRNO.exist;
    this.files.set(path, null);
    return 0;
  }
  path_remove_directory(fd, at, length) {
    return this.files.delete(this.path(fd, at, length)) ? 0 : ERRNO.noent;
  }
  /* A folder takes its files along. */
  path_rename(fd, at, length, to_fd, to_at, to_length) {
    const from = this.path(fd, at, length), to = this.path(to_fd, to_at, to_length);
    if (!this.files.has(from)) return ERRNO.noent;
    for (const [path, file] of [...this.files]) {
      if (from === to || (path !== from && !path.startsWith(from + "/"))) continue;
      this.files.delete(path);
      this.files.set(to + path.slice(from.length), file);
    }
    return 0;
  }
  path_unlink_file(fd, at, length) {
    return this.files.delete(this.path(fd, at, length)) ? 0 : ERRNO.noent;
  }
}
