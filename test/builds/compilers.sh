#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: clang
# The program draws the bytes of test/cases/golden.sha256 with one thread, too, and checked; programs of clang and of gcc with
# other optimisations draw the same (golden_stacks.sh), and are made without a warning. Without OpenGL a program refuses what
# only OpenGL can do.
. test/shared/tap.sh
. test/builds/golden_stacks.sh

as_golden 'unchecked' $small 1 "$SPECTRAL"
check=
[ "${FULL:-0}" != 0 ] || left_out='-32f\|^metals-phong\|^fluorescence-[^0-9]'
as_golden 'checked' $small 2 "$SPECTRAL"
check=--no-check
left_out='^$'

# compiler, option, OpenGL; -freciprocal-math would change pictures, so the program turns it off
plain=$builds/gcc-O2/spectral
more=
[ "${FULL:-0}" = 0 ] || more='gcc -O0 none gcc -O3 none gcc -freciprocal-math none'
# shellcheck disable=SC2086 # lists are words
built_programs clang -O2 osmesa gcc -O2 none $more

# shellcheck disable=SC2086  # $small is a list of words
small="--size 30x20 --wavelengths 400:700:50"
{
    exits 0 "a program without OpenGL prints its version" "$plain" --version
    prints '^without OpenGL$' "its version says so"
    exits 2 "a program without OpenGL refuses OpenGL's pixels" "$plain" render patches $small --renderer gl -o "$tmp/none.tif"
    says 'built without OpenGL; add --renderer raster' "the message asks for --renderer raster"
    absent "$tmp/none.tif" "OpenGL's pixels"
    exits 2 "a program without OpenGL refuses a strict check" "$plain" render patches $small --renderer raster --strict
    exits 0 "a program without OpenGL makes the reference's pixels" "$plain" render patches $small -o "$tmp/plain.tif"
    prints '^verdict +not checked: .* without OpenGL' "the table says that they are unchecked"
    exits 0 "a program with OpenGL makes the same stack again" \
        "$SPECTRAL" render --again "$tmp/plain.tif" -o "$tmp/again.tif"
    exits 0 "a program with OpenGL makes a checked stack" \
        "$SPECTRAL" render patches $small --renderer raster -o "$tmp/checked.tif"
    exits 0 "the program without OpenGL makes the checked stack again" "$plain" render --again "$tmp/checked.tif" -o "$tmp/again.tif"
    refuses '-Ofast changes pictures' "arithmetic that changes pictures is refused" env CFLAGS=-Ofast BUILD="$tmp/fast" ./build.sh
    refuses 'GL is osmesa or none' "an unknown OpenGL is refused" env GL=vulkan BUILD="$tmp/vulkan" ./build.sh
}
done_testing
