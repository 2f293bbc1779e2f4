#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first
# test/one.sh judges what a test prints: only a whole, good TAP passes. Each test has a head that test/run.sh understands.
. test/shared/tap.sh

# judges VERDICT WORDS SCRIPT: the runner gives the script this verdict, and its line says these words
judges() {
    printf '#!/bin/sh\n%s\n' "$3" >"$tmp/planted.sh"
    chmod +x "$tmp/planted.sh"
    : >"$tmp/results"
    run env TEST_TMP="$tmp" RESULTS="$tmp/results" sh test/one.sh "$tmp/planted.sh"
    [ "$(cat "$tmp/results")" = "$1 planted" ] && grep -q "$2" "$tmp/out"
    ok $? "$1: $2"
}
judges passed 'passed .* s of processors)  planted$' 'echo "ok 1 - a"; echo 1..1'
judges passed '1 parts skipped' 'echo "ok 1 - a"; echo "ok 2 # SKIP b"; echo 1..2'
judges skipped 'skipped .* planted: no b$' 'echo "1..0 # SKIP no b"'
judges failed '1 of 2 truths fail' 'echo "not ok 1 - a"; echo "# why"; echo "ok 2 - b"; echo 1..2; exit 1'
grep -q '^    not ok 1 - a$' "$tmp/out" && grep -q '^    # why$' "$tmp/out" && ! grep -q 'ok 2' "$tmp/out"
ok $? "the truth that failed is printed with its remarks, and no other"
judges failed '1 of 1 truths' 'echo "not ok 1 - a"; echo 1..1'
judges failed 'ended after 1 truths with status 0' 'echo "ok 1 - a"'
judges failed 'ended after 1 truths with status 3' 'echo "ok 1 - a"; echo 1..1; exit 3'
judges failed 'ended after 1 truths' 'echo "ok 1 - a"; echo 1..2'
judges failed 'ended after 1 truths' 'echo "ok 1 - a"; echo broken >&2; kill -9 $$'
grep -q '^    broken$' "$tmp/out"
ok $? "what a test said before it ended is printed"
judges failed 'ended after 0 truths' 'exit 0'
grep -qE '^    again: ./build.sh test (full )?planted$' "$tmp/out"
ok $? "a test that failed says how to repeat it alone"
cat >"$tmp/planted.py" <<'END'
from tap import cases, check, done, parts
def one():
    check(True, "one")
def two():
    for number in cases((7, 8)):
        check(number == 7, f"two {number}")
parts(one, two)
done()
END
planted() { run env PYTHONPATH=test/shared FULL=1 "$@" /usr/bin/python3 -B "$tmp/planted.py"; }
planted ONLY=
prints '^# again: ONLY=two/8 ./build.sh test full planted$' "a truth of a Python test that failed says how to repeat its case alone"
planted ONLY=two/8
! grep -q one "$tmp/out" && grep -q '^not ok 1 - two 8$' "$tmp/out" && ! grep -q 'two 7' "$tmp/out"
ok $? "ONLY repeats the case, and no other"
planted ONLY=two/9x
grep -q '^not ok 1 - a case has the name two/9x$' "$tmp/out"
ok $? "ONLY that names no case fails"

head='# level: (first|full|release|(first|full) release)(; packages:( [a-z0-9.+-]+)+)?(; makes:( [a-z_]+)+)?'
find test/*/ -type f -perm -u+x >"$tmp/scripts"
xargs -n 1 sed -n 3p <"$tmp/scripts" | grep -Evx "$head" >"$tmp/bad"
[ -s "$tmp/scripts" ] && [ ! -s "$tmp/bad" ]
ok $? "the third line of each script says when it runs and what it needs"
for word in $(xargs sed -n '3s/.*makes://p' <"$tmp/scripts"); do
    case $word in static | library | test_*) ;; *) grep -q "^make_$word()" test/run.sh || echo "$word" ;; esac
done >"$tmp/unknown"
[ ! -s "$tmp/unknown" ]
ok $? "test/run.sh can make all that they need"

# The parts of `./build.sh check`, in a small tree: it finds planted faults, and nothing else.
. test/check.sh
find_format
if [ -n "$(lacking $format x; lacking shellcheck x)" ]; then
    skip 'no clang-format or no shellcheck'
else
    mkdir -p "$tmp/tree/.ci" "$tmp/tree/data" "$tmp/tree/raster" "$tmp/tree/test"
    cp .clang-format spectral.[ch] build.sh "$tmp/tree"
    checks() { (cd "$tmp/tree" && check_layout && check_scripts) >"$tmp/out" 2>&1; }
    checks
    ok $? "a tree without faults passes the check of layout and scripts"
    echo 'int  planted ;' >"$tmp/tree/data/planted.c"
    ! checks && grep -q 'data/planted.c:1:' "$tmp/out"
    ok $? "the check names a line that is laid out otherwise"
    rm "$tmp/tree/data/planted.c"
    printf '#!/bin/sh\ncd $1\nrm ${HOME}x[1]\n' >"$tmp/tree/test/planted"
    ! checks && grep -q 'test/planted line 2' "$tmp/out"
    ok $? "the check names a line of a script"
fi
done_testing
