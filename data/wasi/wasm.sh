# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2154
# The program as WebAssembly, for the pages of spectral view; build.sh reads this. It is the program without
# OpenGL, without processes and without threads; headers beside this file stand for those that its C library
# lacks. Equal sources make equal bytes wherever Debian's clang has the same version: the link takes no -O,
# by which clang would call another optimizer where one is installed.
wasm_file=data/builtin/viewer/spectral.wasm
wasm_packages='clang lld llvm wasi-libc libclang-rt-dev-wasm32'
wasm_emulated='-D_WASI_EMULATED_SIGNAL -D_WASI_EMULATED_GETPID -D_WASI_EMULATED_PROCESS_CLOCKS'
# 4 MiB of stack below all data, so that an overflow is a trap; at most 2 GiB of memory.
wasm_link='-Wl,--strip-all,--stack-first,-z,stack-size=4194304,--max-memory=2147483648
  -lwasi-emulated-signal -lwasi-emulated-getpid -lwasi-emulated-process-clocks'

# wasm_build FILE, in a shell of its own, which keeps the settings
wasm_build() (
    need $wasm_packages
    CC='clang --target=wasm32-wasi --sysroot=/usr' CFLAGS='' LDFLAGS='' GL=none BUILD=$BUILD/wasm threads=
    CPPFLAGS="$wasm_emulated -isystem data/wasi -include data/wasi/missing.h"
    left_out='^data/builtin/(hard|viewer)/'
    prepare
    find_sources
    sources="$(printf '%s\n' $sources | grep -Ev '^data/(process|threads)/') $(echo data/process/no_*.c data/threads/no_*.c)"
    find_libraries
    libraries="$libraries $wasm_link"
    compile obj '-O2 -ffunction-sections -fdata-sections -Wno-missing-braces' $sources "$BUILD/builtin.c"
    link spectral.wasm $objects
    cp "$BUILD/spectral.wasm" "$1"
)

# wasm_module [FILE] makes the module of the repository, or a copy for a test.
wasm_module() {
    set -- "${1:-$wasm_file}"
    prepare
    wasm_build "$1"
    echo "$1: $(wc -c <"$1") bytes, $(gzip -9nc "$1" | wc -c) compressed"
}
