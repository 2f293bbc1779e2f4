#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: libosmesa6-dev; makes: faults mutant
# Each fault planted in OpenGL must end with exit 1 and one line that names a pixel, an object and
# what differs; the scene drawn without it must pass. faults.md has the table of faults. $FAULTS is the library
# made of test/raster/check/fault.c, $MUTANT the program with all bounds a thousand times too wide. Scenes lie in
# test/cases/faults/. FULL=1 plants all faults; without it some of each kind, on llvmpipe.
. test/shared/tap.sh
FAULTS=${FAULTS:-build/test/fault.so}
MUTANT=${MUTANT:-${BUILD:-build}/test/spectral-mutant}
FAULT_PASSES=$tmp/passes
export FAULT_PASSES
few=' 1 3 6 10 13 14 21 25 34 43 45 46 49 59 65 69 70 71 '

# Number, fault and scene. Any implementation may have faults 1 to 46.
sed -n '/^| number | fault | scene |$/,/^$/p' test/raster/check/faults.md | grep '^| [0-9]' >"$tmp/table"
[ "$(cut -d ' ' -f 2 "$tmp/table" | uniq)" = "$(seq 72)" ] && [ "$(wc -l <"$tmp/table")" = 77 ]
ok $? "the table in faults.md has the faults 1 to 72, some of them in several scenes"

render() { # FAULT SCENE [OPTION...]
    fault=$1
    scene=$2
    shift 2
    [ "$scene" != bright ] || set -- --full-scale 0.5 "$@"
    env FAULT="$fault" LD_PRELOAD="$FAULTS" "$SPECTRAL" render "test/cases/faults/$scene.scene" \
        -o "$tmp/out.tif" "$@"
}

# Prints the smallest error, in counts, that the check surely finds everywhere inside surfaces.
smooth_floor() { # PROGRAM SCENE
    "$1" render "test/cases/faults/$2.scene" -o /dev/null --quiet --json - |
        sed -n 's/.*"smooth_floor_worst_counts": *\([^,}]*\).*/\1/p'
}

is_above() { # LIMIT VALUE
    awk -v limit="$1" -v value="$2" 'BEGIN { exit !(value != "" && value + 0 > limit) }'
}

# The program finds errors of 2 counts; the mutant must report that it does not.
finds_mutant() { # SCENE
    floor=$(smooth_floor "$SPECTRAL" "$1")
    is_above 0.01 "$floor" && ! is_above 2 "$floor" && is_above 2 "$(smooth_floor "$MUTANT" "$1")"
}

finds() { # FAULT SCENE
    run render "$1" "$2"
    [ "$status" = 1 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && [ ! -e "$tmp/out.tif" ] &&
        grep -Eq \
            'first at [0-9]+,[0-9]+ on [0-9a-z-]+ \(test/cases/faults/[a-z-]+\.scene:[0-9]+\): (at [0-9]+ nm )?OpenGL' \
            "$tmp/err"
}

# is_chosen NUMBER
is_chosen() {
    [ "${FULL:-}" = 1 ] || case $few in *" $1 "*) ;; *) return 1 ;; esac
}

for scene in test/cases/faults/*.scene; do
    scene=$(basename "$scene" .scene)
    [ "${FULL:-}" = 1 ] || case $scene in patches | lights | floor | seam) ;; *) continue ;; esac
    for GALLIUM_DRIVER in softpipe llvmpipe; do
        export GALLIUM_DRIVER
        exits 0 "without a fault the pictures agree: $scene on $GALLIUM_DRIVER" render 0 "$scene"
        prints '^verdict +agreed: every pixel is' "without a fault no pixel is unexplained: $scene on $GALLIUM_DRIVER"
        rm -f "$tmp/out.tif"
    done
done
for scene in sheared grazing near; do
    exits 0 "the shader for planted faults passes without a fault: $scene" render -1 "$scene"
    rm -f "$tmp/out.tif"
done

while IFS='|' read -r _ number name scene _; do
    number=$((number))
    is_chosen $number || continue
    scene=${scene# }
    scene=${scene% }
    [ $number != 4 ] || run render 0 "$scene" # keeps the passes that fault 4 swaps
    rm -f "$tmp/out.tif"
    if [ $number = 46 ]; then finds_mutant "$scene"; else finds "$number" "$scene"; fi
    missed=$?
    ok $missed "planted fault $number is found:$name"
    echo "$number $missed" >>"$tmp/verdicts"
    echo "| $number |$name| $scene | $([ $missed = 0 ] && echo found || echo MISSED) |" >&2
done <"$tmp/table"

[ "${FULL:-}" = 1 ] || { done_testing; exit; }
count=$(awk '{ missed[$1] += $2 }
    END { for (i = 1; i <= 46; i++) n += i in missed && !missed[i]; print n + 0 }' "$tmp/verdicts")
echo "$count of 46 planted faults found" >&2
[ "$count" = 46 ]
ok $? "46 of 46 planted faults are found, each by its number"

GALLIUM_DRIVER=softpipe
for number in 1 6 14 23 37 41 44 45; do
    finds "$number" "$(sed -n "s/^| $number |.*| \(.*\) |$/\1/p" "$tmp/table")"
    ok $? "planted fault $number is found on softpipe, too"
done
GALLIUM_DRIVER=llvmpipe

exits 1 "one wrong sample fails the whole picture" render 43 patches
says 'differ at 1 of 3072 pixels, first at ' "only the pixel of the wrong sample is unexplained"
exits 1 "a picture of components is checked, too" render 34 patches --sampling basis:3
grep -q 'at component [1-3] OpenGL' "$tmp/err"
ok $? "the message names the component: $(cat "$tmp/err")"
exits 1 "--keep stores a stack that failed" render 43 patches --keep
grep -aq 'differs; ' "$tmp/out.tif"
ok $? "the kept stack records the verdict"
rm -f "$tmp/out.tif"

lacks() { # FAULT MESSAGE [OPTION...]
    fault=$1
    message=$2
    shift 2
    exits 3 "an OpenGL that cannot draw the scene is no difference: $message" render "$fault" patches "$@"
    grep -q "$message" "$tmp/err"
    ok $? "the message says what it lacks: $(cat "$tmp/err")"
    absent "$tmp/out.tif" "fault $fault"
}
lacks 81 'OSMesa gives 32 bits of colour, 16 of depth and 8 of stencil; 32, 24 and 8 are needed'
lacks 82 'OSMesa draws at most 16 x [0-9]* pixels at once'
lacks 83 'this OSMesa draws with another driver, not with softpipe' --renderer softpipe

for depth in 16 32f; do
    for fault in 48 68; do
        exits 3 "NaN is refused even unchecked, at depth $depth: $fault" \
            render "$fault" patches --no-check --depth "$depth"
        absent "$tmp/out.tif" "depth $depth"
    done
done
done_testing
