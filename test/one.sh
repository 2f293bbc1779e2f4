#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: test/one.sh PROGRAM
# Runs one test and judges the TAP that it prints, which stays in $TEST_TMP/NAME.tap. Prints one line, with the seconds that passed and
# those of the processors, the truths that failed in words, and the command that repeats the test alone. A test that ends early, or too
# late, fails by itself. test/run.sh counts the words in $RESULTS.
name=${1##*/}
name=${name%.*}
tap=$TEST_TMP/$name.tap
begun=$(date +%s)
status=0
timeout --foreground 7200 "$1" >"$tap" 2>"$tap.errors" </dev/null || status=$?
passed=$(($(date +%s) - begun))
times >"$tap.times" # the second line is of the test: minutes and seconds of its own, and of the system
awk -v name="$name" -v status=$status -v seconds=$passed -v results="$RESULTS" -v full="${FULL:+full }" '
    FILENAME == ARGV[1] { if (FNR == 2) { split($1 "m" $2, of, /[ms]/); processor = 60 * (of[1] + of[4]) + of[2] + of[5] } next }
    FILENAME == ARGV[3] { last[n_last++ % 5] = $0; next }
    /^(not )?ok / { n++; failed = /^not /; n_failed += failed; n_skipped += /# SKIP/ }
    /^1[.][.][0-9]+/ { planned = 1; plan = substr($1, 4) + 0; reason = $0; sub(/^[^#]*# SKIP/, ":", reason) }
    (/^not ok / || /^#/) && failed { if (++n_words <= 40) words = words "    " $0 "\n" }
    END {
        verdict = "passed"
        if (planned && plan == 0) verdict = "skipped"
        else if (n_failed || status || !planned || plan != n) verdict = "failed"
        says = verdict == "skipped" ? reason : n_failed ? ": " n_failed " of " n " truths fail" : \
            verdict == "failed" ? ": it ended after " n + 0 " truths with status " status : ""
        if (verdict == "failed" && !n_failed)
            for (i = n_last > 5 ? n_last - 5 : 0; i < n_last; i++) words = words "    " last[i % 5] "\n"
        if (verdict == "failed") words = words "    again: ./build.sh test " full name "\n"
        if (n_skipped) says = says ", " n_skipped " parts skipped"
        printf "%7s %5d s (%d s of processors)  %s%s\n%s", verdict == "failed" ? "FAILED" : verdict, seconds, processor, name, says, words
        print verdict, name >>results
    }' "$tap.times" "$tap" "$tap.errors"
