#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: binutils clang lld wasi-libc libclang-rt-dev-wasm32 wabt
# The trusted core stands alone: raster/reference and raster/visibility compile with data/maths and nothing else of the
# program, by gcc, by clang, and for WebAssembly. test/raster/reference/alone.c draws a picture with it; all builds
# draw the same bits. The core calls only memory functions of the C library, and functions that round as
# IEC 60559 says.
# Debian's packages: clang, lld, wasi-libc, libclang-rt-dev-wasm32, and wabt for wasm-interp.
# Lists are split into words on purpose.
# shellcheck disable=SC2086
. test/shared/tap.sh
sources='raster/reference/*.c raster/visibility/*.c data/maths/*.c'
language='-std=c99 -O2 -I. -ffp-contract=off -fno-trapping-math -fno-math-errno -pedantic -Werror
  -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes
  -Wundef -Wvla -Wcast-qual -Wwrite-strings'
webassembly='--target=wasm32-wasi --sysroot=/usr -nostartfiles -Wl,--no-entry,--export=digest,--strip-all'
may_call='malloc calloc realloc free memcpy memset memmove memcmp
  fabs fma fmax fmin floor ceil trunc rint sqrt frexp ldexp copysign fmod'
# gcc adds these to loops that it compiles for AVX2, too: they choose the loop for the processor.
may_call="$may_call __cpu_indicator_init __cpu_model _GLOBAL_OFFSET_TABLE_"

# The folder $tmp holds the three rooms only: no other header can be found.
mkdir -p "$tmp/raster" "$tmp/data"
cp -R raster/reference raster/visibility "$tmp/raster"
cp -R data/maths "$tmp/data"
cp test/raster/reference/alone.c "$tmp"
tmp=$(cd "$tmp" && pwd)
cd "$tmp" || exit

# compiles OUTPUT COMPILER OPTION...
compiles() {
    output=$1
    shift
    run "$@" $language -o "$output" $sources $library
    ok $status "$output: compiles alone, without warnings"
}

# draws NAME COMMAND...: the command prints the digest of its picture. All digests must be equal.
draws() {
    name=$1
    shift
    run "$@"
    digest=$(sed 's/.*i64://' "$tmp/out")
    [ "$status" = 0 ] && [ "${digest:-0}" != 0 ]
    ok $? "$name: draws a picture"
    [ -n "$digest" ] && [ "$digest" = "${first:=$digest}" ]
    ok $? "$name: the same bits as the first (digest ${digest:-none})"
    echo "# $name: $(wc -c <"$name") bytes"
}

library=-lm
compiles alone-gcc gcc alone.c
draws alone-gcc ./alone-gcc
compiles alone-clang clang alone.c
draws alone-clang ./alone-clang
compiles alone.wasm clang $webassembly alone.c
draws alone.wasm wasm-interp alone.wasm --run-all-exports

# Prints the functions that core.o must not call.
must_not_be_called() {
    nm -u core.o | awk '{ print $2 }' | sort >called
    echo $may_call | tr ' ' '\n' | sort | comm -13 - called
}

library=
compiles core.o gcc -r -nostdlib
must_not_be_called >"$tmp/out"
[ -s called ] && [ ! -s "$tmp/out" ]
ok $? "the core calls memory functions and exact functions only"

# Faults planted in the copy
echo 'double planted(double x); double planted(double x) { return sin(x); }' >>raster/reference/light.c
compiles core.o gcc -r -nostdlib
[ "$(must_not_be_called)" = sin ]
ok $? "a call of sin is found"
echo '#include "spectral.h"' >>raster/reference/light.c
exits 1 "a header of another room is not found" gcc $language -c raster/reference/light.c
done_testing
