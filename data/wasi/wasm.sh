# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC1007,SC2034,SC2086,SC2154,SC3013
# The program as WebAssembly, for live pages; build.sh reads this for `live`. It is the program without
# OpenGL, without processes and without threads; headers and no_process.c beside this file stand for what its C library
# lacks. Equal sources make equal bytes wherever Debian's clang has the same version: the link takes no -O,
# by which clang would call another optimizer where one is installed.
wasm_packages='clang lld llvm wasi-libc libclang-rt-dev-wasm32'
wasm_emulated='-D_WASI_EMULATED_SIGNAL -D_WASI_EMULATED_GETPID -D_WASI_EMULATED_PROCESS_CLOCKS'
# 4 MiB of stack below all data, so that an overflow is a trap; at most 2 GiB of memory.
wasm_link='-Wl,--strip-all,--stack-first,-z,stack-size=4194304,--max-memory=2147483648
  -lwasi-emulated-signal -lwasi-emulated-getpid -lwasi-emulated-process-clocks'

# In a shell of its own, which keeps the settings. The module is $BUILD/wasm/spectral.wasm.
wasm_build() (
    need $wasm_packages
    CC='clang --target=wasm32-wasi --sysroot=/usr' CFLAGS='' LDFLAGS='' GL=none BUILD=$BUILD/wasm threads= kind=
    CPPFLAGS="$wasm_emulated -isystem data/wasi -include data/wasi/missing.h"
    left_out='/viewer/'
    prepare
    find_sources
    sources="$(printf '%s\n' $sources | grep -Ev '^data/(base/(guard|process)|files/unpack)[.]c') $(echo data/wasi/no_*.c)"
    find_libraries
    libraries="$libraries $wasm_link"
    compile obj '-O2 -ffunction-sections -fdata-sections -Wno-missing-braces' $sources "$BUILD/$builtin"
    link spectral.wasm $objects
)

# Lets the program that is built next hold the parts of live pages and the module, compressed.
add_module() {
    wasm_build
    module=$BUILD/live/viewer/spectral.wasm.gz
    if [ ! -f "$module" ] || [ "$BUILD/wasm/spectral.wasm" -nt "$module" ]; then
        mkdir -p "${module%/*}"
        gzip -9nc "$BUILD/wasm/spectral.wasm" >"$module.new"
        mv "$module.new" "$module"
    fi
    builtin_folders="data/builtin $BUILD/live" left_out='' builtin=builtin-live.c
}
