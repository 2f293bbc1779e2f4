#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; makes: replay
# Inputs that fuzzing has kept (test/fuzz/corpus), a few hundred for each reader: they reach nearly all of its
# code. Each is read again; whatever it is, the reader gives a result or one message. With FULL=1 the
# sanitizers watch, and libtiff's code too.
# shellcheck disable=SC1091,SC2086
. test/shared/tap.sh
. test/fuzz/fuzz.sh
: "${BUILD:=build}"
open_folder

for target in $(fuzz_targets); do
    unpack $target
    n=$(find "$BUILD/fuzz/kept" -type f | wc -l)
    run find "$BUILD/fuzz/kept" -type f -exec "$REPLAY" "$target" {} +
    [ "$status" = 0 ] && [ "$n" -gt 10 ] && [ "$(wc -l <"$tmp/out")" = "$n" ]
    ok $? "$target: each of $n inputs has a result or one message"
    [ "$status" = 0 ] || tail -n 1 "$tmp/out" | sed 's/^/# this input: /'
done
[ "$(fuzz_targets | wc -l)" -ge 15 ]
ok $? "there are fifteen targets"
run env FUZZ_FOLDER=/no/such/folder "$REPLAY" scene test/program/fuzz.sh
[ "$status" != 0 ] && grep -q '^does not hold: ' "$tmp/err"
ok $? "a rule that is broken ends the replay"
if [ "${FULL:-}" = 1 ]; then
    exits 0 "the sanitizers find nothing" ./build.sh fuzz 0
else
    skip "the same under the sanitizers: ./build.sh test full, or ./build.sh fuzz 0"
fi
done_testing
