#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first
# The program's stacks of the reference have the bytes of test/cases/golden.sha256 (golden_stacks.sh); with FULL=1 also those
# of the scenes' own size.
#     test/builds/golden.sh renew      writes test/cases/golden.sha256 anew, by $SPECTRAL
. test/shared/tap.sh
. test/builds/golden_stacks.sh

if [ "${1:-}" = renew ]; then
    { hashes $small 1 "$SPECTRAL" && hashes '' 1 "$SPECTRAL"; } >"$tmp/golden"
    exec mv "$tmp/golden" "$golden"
fi

for size in $small ''; do
    grep -q " $(golden_hashes "$size" | sha256sum | cut -c 1-16) " data/doc/reproducibility.md
    ok $? "reproducibility.md prints the digest of all stacks, ${size:-own size}"
done
[ -n "$scenes" ] && [ "$(wc -l <"$golden")" = "$({ stacks $small; stacks ''; } | wc -l)" ]
ok $? "$golden has each built-in scene small and at its own size"

as_golden 'unchecked' $small 2 "$SPECTRAL"
[ "${FULL:-0}" = 0 ] || as_golden 'unchecked' '' 2 "$SPECTRAL"
done_testing
