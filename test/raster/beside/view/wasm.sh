#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: clang lld wasi-libc libclang-rt-dev-wasm32 llvm wabt; makes: live
# ./build.sh live puts the program, as WebAssembly, into the pages of view; the usual program is smaller, says how to get the other,
# and refuses what only the other can do.
# shellcheck disable=SC1091,SC2154
. test/shared/tap.sh
: "${LIVE:=build/spectral-live}"
module=${LIVE%/*}/wasm/spectral.wasm

! strings -n 4 "$module" | grep -F -e "$PWD" -e "$HOME/"
ok $? "no path of this machine is in the module"
wasm-objdump -x -j Import "$module" >"$tmp/out" 2>"$tmp/err"
imported=$(sed -n 's/.*<- wasi_snapshot_preview1[.]//p' "$tmp/out" | sort)
lacking=
for name in $imported; do
    grep -q "^  $name(" data/builtin/viewer/live-system.js || lacking="$lacking $name"
done
[ -n "$imported" ] && [ -z "$lacking" ]
ok $? "the page has all functions that the module imports:${lacking:- all of them}"
[ -z "$(git ls-files '*.wasm' '*.wasm.gz' 2>/dev/null)" ]
ok $? "no module is among the sources"

# page PROGRAM [OPTION...] writes $tmp/page.html, and what the program says to $tmp/out.
page() {
    program=$1
    shift
    run "$program" view patches --size 30x20 -o "$tmp/page.html" "$@"
}
page "$LIVE"
! grep -q 'build.sh live' "$tmp/out" && grep -q 'id="module"' "$tmp/page.html" && grep -q 'async function start_live' "$tmp/page.html"
ok $? "the live program writes a live page"
page "$LIVE" --still
! grep -q 'build.sh live' "$tmp/out" && cp "$tmp/page.html" "$tmp/still.html"
ok $? "and a still one, if it is asked for one"
page "$SPECTRAL"
[ "$(grep -c 'build.sh live' "$tmp/out")" = 1 ] && cmp -s "$tmp/page.html" "$tmp/still.html"
ok $? "the usual program writes the same still page, and says in a line how to get live ones"
page "$SPECTRAL" --still
! grep -q 'build.sh live' "$tmp/out" && cmp -s "$tmp/page.html" "$tmp/still.html"
ok $? "--still asks for such a page, so that there is nothing to say"
refuses '--gallery .* ./build.sh live' "a gallery needs the live program" "$SPECTRAL" view --gallery -o "$tmp/gallery.html"
absent "$tmp/gallery.html" "a gallery"
[ $(($(wc -c <"$LIVE") - $(wc -c <"$SPECTRAL"))) -gt "$(wc -c <"${LIVE%/*}/live/viewer/spectral.wasm.gz")" ] && ! grep -q "async function start_live" "$SPECTRAL"
ok $? "the usual program holds neither module nor the scripts of live pages"
done_testing
