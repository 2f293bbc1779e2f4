# SPDX-License-Identifier: MIT
# shellcheck shell=sh
# For test scripts: one TAP line for each truth. $SPECTRAL is the program, $TEST_TMP a folder to write to.
SPECTRAL=${SPECTRAL:-build/spectral}
TEST_TMP=${TEST_TMP:-build/tmp}
tap_count=0
tap_failures=0
tap_name=$(basename "$0" .sh)
tmp=$TEST_TMP/$tap_name
rm -rf "$tmp"
mkdir -p "$tmp"

ok() { # STATUS NAME: 0 holds
    tap_count=$((tap_count + 1))
    if [ "$1" = 0 ]; then
        echo "ok $tap_count - $2"
    else
        tap_failures=$((tap_failures + 1))
        echo "not ok $tap_count - $2"
        [ ! -f "$tmp/out" ] || sed 's/^/# /' "$tmp/out" "$tmp/err" | head -n 20
    fi
}

# Runs a command; its output lands in $tmp/out and $tmp/err, its status in $status.
run() {
    status=0
    "$@" >"$tmp/out" 2>"$tmp/err" </dev/null || status=$?
}

# exits STATUS NAME COMMAND...
exits() {
    expected=$1
    name=$2
    shift 2
    run "$@"
    [ "$status" = "$expected" ]
    ok $? "$name (exit $expected)"
}

# says PATTERN NAME: the last command printed a line on standard error that matches
says() {
    grep -Eq -- "$1" "$tmp/err"
    ok $? "$2"
}

prints() { # PATTERN NAME: the last command printed a line on standard output that matches
    grep -Eq -- "$1" "$tmp/out"
    ok $? "$2"
}

one_line() {
    [ "$(wc -l <"$tmp/err")" = 1 ]
    ok $? "$1: one line says so"
}

refuses() { # PATTERN NAME COMMAND...: the command ends with status 2 and one line that matches
    pattern=$1
    shift
    exits 2 "$@"
    says "$pattern" "the message: $pattern"
    one_line "the message: $pattern"
}

absent() {
    [ ! -e "$1" ]
    ok $? "$2: no output file"
}

skip() {
    tap_count=$((tap_count + 1))
    echo "ok $tap_count # SKIP $1"
}

# Ends a script, whose exit status is then 1 if a truth failed.
done_testing() {
    echo "1..$tap_count"
    [ $tap_failures = 0 ]
}

# Ends a script that cannot run here.
skip_all() { # REASON
    echo "1..0 # SKIP $1"
    exit
}
