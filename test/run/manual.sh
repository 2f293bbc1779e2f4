#!/bin/sh
# SPDX-License-Identifier: MIT
# The manual page is well formed, and describes the program as it is: each option, command and list.
. test/run/tap.sh

exits 0 "the manual page has no fault" mandoc -Tlint spectral.1
mandoc -Tascii spectral.1 | col -bx >"$tmp/page"
exits 0 "--help explains" "$SPECTRAL" --help
options() { grep -Eo -- '(^|[ ,=])--?[a-z][a-z-]*' "$1" | tr -d ' ,=' | LC_ALL=C sort -u; }
options "$tmp/out" >"$tmp/told"
options "$tmp/page" >"$tmp/documented"
[ "$(wc -l <"$tmp/told")" -gt 15 ]
ok $? "many options"
diff "$tmp/told" "$tmp/documented" >"$tmp/err"
ok $? "each has its place in the manual, and no other has"
for command in $(sed -n 's/^  \([a-z]*\)  *\[*[A-Z].*/\1/p' "$tmp/out"); do
    grep -Eq "^ {5}spectral $command" "$tmp/page"
    ok $? "so has the command $command"
done
for kind in $("$SPECTRAL" list | grep '^[a-z]'); do
    grep -Eqw "$kind" "$tmp/page"
    ok $? "and the list of $kind"
done
done_testing
