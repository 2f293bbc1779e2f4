#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: clang lld wasi-libc libclang-rt-dev-wasm32 llvm
# The module in the repository is the program of these sources: made again, it has the same bytes. Another
# version of clang makes others, so that there only the size is compared.
# shellcheck disable=SC1091,SC2034,SC2154
. test/run/tap.sh
module=data/builtin/viewer/spectral.wasm
made_with='Debian clang version 14.0.6'

WASM_COPY=$tmp/spectral.wasm
run ./build.sh wasm "$WASM_COPY"
ok $status "the module is made"
if [ "$(clang --version | head -n 1)" = "$made_with" ]; then
    cmp -s "$module" "$WASM_COPY"
    ok $? "$module is not stale (./build.sh wasm makes it anew)"
else
    echo "# $(clang --version | head -n 1), not $made_with: bytes are not compared"
    [ -s "$WASM_COPY" ]
    ok $? "the module has bytes"
fi

# It holds nothing of this machine.
! strings -n 4 "$WASM_COPY" | grep -F -e "$PWD" -e "$HOME/"
ok $? "no path of this machine is in the module"
wasm-objdump -x -j Import "$WASM_COPY" >"$tmp/out" 2>"$tmp/err"
imported=$(sed -n 's/.*<- wasi_snapshot_preview1[.]//p' "$tmp/out" | sort)
lacking=
for name in $imported; do
    grep -q "^  $name(" data/builtin/viewer/system.js || lacking="$lacking $name"
done
[ -n "$imported" ] && [ -z "$lacking" ]
ok $? "the page has all functions that the module imports:${lacking:- all of them}"
done_testing
