# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2094,SC2100,SC2154
# Text files (and textures) as C, so that the program runs alone; build.sh reads this. The program finds
# a file by its name relative to data/builtin. The parts of live pages are for the program that also holds
# their module (data/wasi/wasm.sh), which lies in a folder like data/builtin.
builtin_folders=data/builtin
left_out='/viewer/live[^/]*$' # a pattern of files that are not compiled in
builtin=builtin.c             # the name below $BUILD

# bytes prints standard input as numbers with commas.
bytes() { od -An -v -tu1 | sed 's/  */,/g; s/^,//; s/$/,/'; }

# builtin_source LIST
builtin_source() {
    echo '#include "data/files/files.h"'
    [ "$TIER" = full ] && raw_files "$1" || packed_files "$1"
    echo '};'
    echo 'const struct builtin_file *const builtin_files = files;'
    echo "const size_t builtin_file_count = $(grep -c '' "$1");"
}

raw_files() {
    number=0
    while read -r _ file; do
        number=$((number + 1))
        echo "static const unsigned char file_${number}[] = {"
        bytes <"$file"
        echo '0};'
    done <"$1"
    echo 'const unsigned char *const builtin_packed = NULL;'
    echo 'const size_t builtin_packed_length = 0;'
    echo 'unsigned char *const builtin_unpacked = NULL;'
    echo 'const size_t builtin_unpacked_length = 0;'
    echo 'static const struct builtin_file files[] = {'
    number=0
    while read -r name _; do
        number=$((number + 1))
        echo "{\"$name\", file_$number, sizeof file_$number - 1},"
    done <"$1"
}

# The minimal program has its files in one piece that gzip has packed (RFC 1952), each with a NUL behind it.
packed_files() {
    echo 'static const unsigned char packed[] = {'
    in_one_piece <"$1" | gzip -9n | bytes
    echo '};'
    echo "static unsigned char unpacked[$(in_one_piece <"$1" | wc -c)];"
    echo 'const unsigned char *const builtin_packed = packed;'
    echo 'const size_t builtin_packed_length = sizeof packed;'
    echo 'unsigned char *const builtin_unpacked = unpacked;'
    echo 'const size_t builtin_unpacked_length = sizeof unpacked;'
    echo 'static const struct builtin_file files[] = {'
    start=0
    while read -r name file; do
        length=$(($(wc -c <"$file")))
        echo "{\"$name\", unpacked + $start, $length},"
        start=$((start + length + 1))
    done <"$1"
}

in_one_piece() { while read -r _ file; do cat "$file" && printf '\0'; done; }

# list_builtin prints the name of each file, and its path, sorted by name.
list_builtin() {
    for folder in $builtin_folders; do
        find "$folder" -type f | grep -Ev "${left_out:-^$}" | while read -r file; do
            echo "${file#"$folder/"} $file"
        done
    done | sort
}

# The minimal program has tables, materials, and the scenes that need no texture and no mesh.
minimal_builtin() {
    builtin=builtin-minimal.c
    left_out='/(hard|viewer|textures|reliefs)/|/models/[^/]*[.](obj|map)$'
    left_out="$left_out|/($(cd data/builtin/scenes && grep -lE 'texture |mesh |displace ' ./* | sed 's,^./,,' | tr '\n' '|')NONE)\$"
}

# Makes $BUILD/$builtin anew if a file, or a folder of them, has changed since the list was begun.
make_builtin() {
    list=$BUILD/$builtin.list
    if [ ! -f "$list" ] || [ ! -f "$BUILD/$builtin" ] || [ -n "$(find $builtin_folders data/builtin.sh -newer "$list")" ]; then
        list_builtin >"$list.new"
        builtin_source "$list.new" >"$BUILD/$builtin.new"
        cmp -s "$BUILD/$builtin.new" "$BUILD/$builtin" || mv "$BUILD/$builtin.new" "$BUILD/$builtin"
        mv "$list.new" "$list"
    fi
}
