#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: busybox-static binutils file; makes: static
# The static program ($STATIC) is one hardened file that runs in an otherwise empty system. portable.sh compares the bytes of its
# stacks.
. test/shared/tap.sh
STATIC=${STATIC:-build/spectral-static}
[ -x "$STATIC" ] || skip_all "no $STATIC: ./build.sh static"

lacks() { # PATTERN NAME: no line of the last command's output matches
    ! grep -Eq -- "$1" "$tmp/out"
    ok $? "$2"
}

# ---- the file ----

run file -b "$STATIC"
prints '^ELF .* static(ally|-pie) linked' "it is statically linked"
prints ', stripped$' "it is stripped"
run readelf -hldW "$STATIC"
prints '^ +Type: +DYN' "it runs at any address"
lacks 'INTERP|NEEDED' "it names no loader and no library"
lacks 'TEXTREL' "no relocation changes its code"
prints 'GNU_RELRO' "relocated data is read-only afterwards"
prints 'FLAGS_1.* NOW' "all relocations happen at the start"
prints 'GNU_STACK.* RW ' "it asks for a stack that holds no code"
lacks ' [RW ]WE ' "no segment is both writable and executable"
[ "$(wc -c <"$STATIC")" -le 20000000 ]
ok $? "it has at most 20 MB"
run readelf -hldsW "$SPECTRAL"
prints '^ +Type: +DYN' "the ordinary program runs at any address"
prints 'GNU_RELRO' "its relocated data is read-only afterwards"
prints 'FLAGS_1.* NOW' "all its relocations happen at the start"
prints 'GNU_STACK.* RW ' "it asks for a stack that holds no code"
prints '__stack_chk_fail' "its functions guard their stacks"
prints '__(memcpy|snprintf|vsnprintf)_chk' "its copies are checked against the size of their target"
run strings -a "$STATIC"
lacks '/(root|home|tmp|work|build)/' "it names no folder of its builder"
! grep -Fq -e "$PWD/" -e "${XDG_CACHE_HOME:-$HOME/.cache}/" "$tmp/out"
ok $? "it names neither this folder nor the cache"

# The program before stripping has the names of its functions, its own and Mesa's.
if [ -f "$STATIC.symbols" ]; then
    strip -o "$tmp/stripped" "$STATIC.symbols" && cmp -s "$STATIC" "$tmp/stripped"
    ok $? "it is $STATIC.symbols without the symbols"
    for function in contexts_open _mesa_LightModeli; do
        run objdump -d "--disassemble=$function" "$STATIC.symbols"
        prints '<__stack_chk_fail>' "$function guards its stack"
    done
    run objdump -d --disassemble=contexts_open "$STATIC.symbols"
    prints '<_+snprintf_chk>' "contexts_open checks the size of its output"
else
    skip "no $STATIC.symbols, which shows whether functions guard their stack"
fi

# ---- alone ----

if [ "$(id -u)" = 0 ]; then
    enter='chroot --userspec=65534:65534' # an ordinary user
elif unshare -r true 2>/dev/null; then
    enter='unshare -r chroot'
else
    enter=
fi
root=$tmp/root
mkdir "$root"
chmod 777 "$root"
cp "$STATIC" "$root/spectral"

draws_alone() { # WHERE COMMAND...
    where=$1
    shift
    # the shell splits $enter into words on purpose
    # shellcheck disable=SC2086
    exits 0 "$where, OpenGL and the reference agree" $enter "$root" "$@"
    prints '^drawn by +softpipe' "$where, OpenGL is its own"
    prints '^verdict +agreed: every pixel is' "$where, no pixel is unexplained"
    [ -s "$root/stack.tif" ]
    ok $? "$where, it writes the stack"
    rm -f "$root/stack.tif"
}
if [ "$enter" ]; then
    draws_alone "in an empty folder as root directory" /spectral render colorchecker -o /stack.tif
    if cp "$(command -v busybox)" "$root"; then
        draws_alone "under busybox without /proc" /busybox sh -c \
            '[ ! -e /proc ] && cd / && ./spectral render colorchecker -o stack.tif'
    else
        skip "no busybox"
    fi
else
    skip "neither root nor allowed to become it in a namespace (unshare -r)"
fi

for scene in room metals; do
    exits 0 "$scene: OpenGL and the reference agree" "$STATIC" render $scene --size 300x200 --wavelengths 300:760:46 -o "$tmp/$scene.tif"
    prints '^verdict +agreed: every pixel is' "$scene: no pixel is unexplained"
done

# ---- what it leaves out ----

exits 2 "a picture for the omitted library is refused" \
    "$STATIC" render test/cases/bad/texture-jbig.scene --size 8x8 --renderer raster --no-check -o /dev/null
says 'its compression \(34661\)' "the message names the compression"

# ---- threads and signals ----

# most_threads N prints the most threads that a render with --threads N has at once.
most_threads() {
    "$STATIC" render colorchecker --size 2000x1500 --renderer raster --no-check --threads "$1" -o /dev/null -q &
    most=0
    while kill -0 $! 2>/dev/null; do
        n=$(ls "/proc/$!/task" 2>/dev/null | wc -l)
        [ "$n" -le "$most" ] || most=$n
    done
    wait $!
    echo "$most"
}
[ "$(most_threads 1)" = 1 ] && [ "$(most_threads 3)" = 3 ]
ok $? "--threads says how many threads there are"

mkdir "$tmp/cut"
run timeout --preserve-status -s INT 1 env --default-signal=INT \
    "$STATIC" render colorchecker --size 6000x4000 -o "$tmp/cut/stack.tif"
[ "$status" = 130 ]
ok $? "Ctrl-C ends the program"
[ -z "$(ls -A "$tmp/cut")" ]
ok $? "Ctrl-C leaves no file"

start=$(date +%s%N)
for _ in 1 2 3 4 5 6 7 8 9 10; do
    "$STATIC" --version >"$tmp/out"
done
echo "# --version takes $((($(date +%s%N) - start) / 10000)) microseconds from start to exit"
grep -q '^OSMesa .*softpipe' "$tmp/out"
ok $? "--version names the OSMesa inside"
exits 3 "it has no llvmpipe" "$STATIC" render patches --renderer llvmpipe -o /dev/null
says 'softpipe.*--renderer gl|--renderer gl.*softpipe' "it says so, and what to do"
done_testing
