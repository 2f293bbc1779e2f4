/* SPDX-License-Identifier: MIT */
/* What the scripts of every page use. */

const element = id => document.getElementById(id);

function set_text(id, text) {
  if (element(id).textContent !== text) element(id).textContent = text;
}

/* Decodes base64, and what it compresses; format: deflate or gzip. */
async function unpack(text, format) {
  const packed = atob(text), bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; i++) bytes[i] = packed.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function save_as(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name.replace(/^.*[/]/, "");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
