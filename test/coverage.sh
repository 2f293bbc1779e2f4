# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2046,SC2086,SC2154
# The lines of the program that the tests run, counted by gcc's --coverage in all processes: those that a
# test starts, and those that the program forks; build.sh reads this for `coverage`. Prints the share of
# each file, and each line that no test runs. test/coverage.reasons says why some lines are not run; it ends
# with status 1 if another line is not run, or if less than 95 % are.
least_coverage=95
# These build programs of their own, or none; the last two let calls fail and end programs while these write
# their counters, which spoils all that was counted before.
uncounted='mutants walk portable compilers static dist alone house english attack kills'

# The counters are written at the end of a process; here also where a child ends by _exit, and where a
# test limits the size of files (by a soft limit, which can be raised again): a file of counters that is cut
# loses all that was counted before.
coverage_exit() {
    cat >"$BUILD/exit.c" <<'END'
#include <sys/resource.h>
void __gcov_dump(void);
void __real__exit(int status) __attribute__((noreturn));
void __wrap__exit(int status) __attribute__((noreturn));
static void allow_files(void) __attribute__((destructor));
static void allow_files(void)
{
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_FSIZE, &limit);
}
void __wrap__exit(int status)
{
    allow_files();
    __gcov_dump();
    __real__exit(status);
}
END
    gcc -c -O1 "$BUILD/exit.c" -o "$BUILD/exit.o"
}

# count_lines FOLDER prints "FILE<tab>LINE<tab>RUN<tab>TEXT" for each line with code; RUN is 0 or 1.
count_lines() {
    find "$1" -name '*.gcno' | sort | xargs gcov -t 2>/dev/null | awk -F: -v OFS='\t' '
        $2 + 0 == 0 { if ($3 == "Source") file = $4; next }
        { run = $1; gsub(/[ *]/, "", run); if (run == "-") next
          text = $0; sub(/^[^:]*:[^:]*:/, "", text); sub(/^[ \t]*/, "", text)
          if (file ~ /^(data|raster)\/|^spectral[.]c$/) print file, $2 + 0, run !~ /^[#=]/, text }' | sort -u
}

# report_coverage FOLDER
report_coverage() {
    count_lines "$1" >"$BUILD/lines"
    awk -F '\t' -v least="$least_coverage" '
        FILENAME == ARGV[1] { if ($0 !~ /^#/ && NF == 2) { pattern[++n] = $1; reason[n] = $2 }; next }
        { key = $1 ":" $2; if (!(key in known)) { known[key] = 1; order[++m] = key; file[key] = $1; text[key] = $4 }
          if ($3) run[key] = 1 }
        END {
            for (i = 1; i <= m; i++) {
                key = order[i]; all[file[key]]++; total++
                if (key in run) { hit[file[key]]++; hits++; continue }
                for (j = 1; j <= n; j++) if (file[key] ": " text[key] ~ pattern[j]) break
                if (j <= n) explained[j]++; else missed[++unexplained] = key ": " text[key]
            }
            for (name in all) printf "%6.2f %%  %4d of %4d  %s\n", 100 * hit[name] / all[name], hit[name], all[name], name | "sort -n"
            close("sort -n")
            print "\nnot run, with a reason:"
            for (j = 1; j <= n; j++) if (explained[j]) printf "%4d  %s\n", explained[j], reason[j]
            print "\nnot run:"
            for (i = 1; i <= unexplained; i++) print missed[i]
            printf "\n%.2f %% of %d lines are run; %d of the others have a reason, %d have none\n", 100 * hits / total, total,
                total - hits - unexplained, unexplained
            exit 100 * hits / total < least || unexplained > 0
        }' test/coverage.reasons "$BUILD/lines"
}

coverage() (
    BUILD=$BUILD/coverage
    prepare
    find "$BUILD" -name '*.gcda' -delete
    coverage_exit
    export BUILD CC=gcc CFLAGS='-O1 -g --coverage' LDFLAGS="-Wl,--wrap=_exit $PWD/$BUILD/exit.o"
    ./build.sh test $(find test/*/ -name 'test_*.c' -o -type f -perm -u+x | sed 's:.*/::; s:[.][a-z]*$::' |
        grep -Ev "^($(echo $uncounted | tr ' ' '|'))$") ||
        echo "some tests fail in this build; the lines that they ran count nevertheless"
    report_coverage "$BUILD/obj"
)
