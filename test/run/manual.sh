#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: test/run/manual.sh [renew]
# The manual page is well-formed and describes each option, command and list of the program. Its list of options
# equals that of --help; renew writes this list into the page and keeps the page's own explanations.
. test/run/tap.sh
renewed_page() { "$SPECTRAL" --help | /usr/bin/python3 test/run/manual_options.py spectral.1; }
if [ "${1:-}" = renew ]; then
    renewed_page >"$tmp/page" && cat "$tmp/page" >spectral.1
    exit
fi

exits 0 "the manual page has no fault" mandoc -Tlint spectral.1
renewed_page | diff spectral.1 - >"$tmp/err"
ok $? "the page lists the options of --help; test/run/manual.sh renew renews the list"
mandoc -Tascii spectral.1 | col -bx >"$tmp/page"
exits 0 "--help prints the usage" "$SPECTRAL" --help
options() { grep -Eo -- '(^|[ ,=])--?[a-z][a-z-]*' "$1" | tr -d ' ,=' | LC_ALL=C sort -u; }
cp "$tmp/out" "$tmp/printed-help"
options "$tmp/out" >"$tmp/printed"
options "$tmp/page" >"$tmp/documented"
[ "$(wc -l <"$tmp/printed")" -gt 15 ]
ok $? "--help lists many options"
diff "$tmp/printed" "$tmp/documented" >"$tmp/err"
ok $? "the manual has these options and no others"
for command in $(sed -n 's/^  \([a-z]*\)  *\[*[A-Z].*/\1/p' "$tmp/printed-help"); do
    grep -Eq "^ {5}spectral $command" "$tmp/page"
    ok $? "the manual has the command $command"
done
for kind in $("$SPECTRAL" list | grep '^[a-z]'); do
    grep -Eqw "$kind" "$tmp/page"
    ok $? "the manual has the list of $kind"
done
# A terminal of 80 columns shows each help without broken lines.
too_long=
for command in '' $(sed -n 's/^  \([a-z]*\)  *\[*[A-Z].*/\1/p' "$tmp/printed-help"); do
    # shellcheck disable=SC2086  # $command may be no word
    "$SPECTRAL" $command --help | grep -E '.{81}' && too_long="$too_long spectral $command --help"
done >"$tmp/out"
"$SPECTRAL" | grep -E '.{81}' >>"$tmp/out" && too_long="$too_long spectral"
[ -z "$too_long" ]
ok $? "no line of a help is longer than 80 columns$too_long"
done_testing
