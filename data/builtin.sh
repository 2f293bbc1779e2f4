# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2094,SC2154
# Text files (and textures) as C, so that the program runs alone; build.sh reads this. The program finds
# a file by its name relative to data/builtin. The parts of live pages are for the program that also holds
# their module (data/wasi/wasm.sh), which lies in a folder like data/builtin.
builtin_folders=data/builtin
left_out='/viewer/live[^/]*$' # a pattern of files that are not compiled in
builtin=builtin.c             # the name below $BUILD

builtin_source() {
    echo '#include "data/files/files.h"'
    number=0
    while read -r _ file; do
        number=$((number + 1))
        echo "static const unsigned char file_${number}[] = {"
        od -An -v -tu1 "$file" | sed 's/  */,/g; s/^,//; s/$/,/'
        echo '0};'
    done <"$1"
    echo 'const struct builtin_file builtin_files[] = {'
    number=0
    while read -r name _; do
        number=$((number + 1))
        echo "{\"$name\", file_$number, sizeof file_$number - 1},"
    done <"$1"
    echo '};'
    echo "const size_t builtin_file_count = $number;"
}

# list_builtin prints the name of each file, and its path, sorted by name.
list_builtin() {
    for folder in $builtin_folders; do
        find "$folder" -type f | grep -Ev "${left_out:-^$}" | while read -r file; do
            echo "${file#"$folder/"} $file"
        done
    done | sort
}

# Makes $BUILD/$builtin anew if a file, or a folder of them, has changed since the list was begun.
make_builtin() {
    list=$BUILD/$builtin.list
    if [ ! -f "$list" ] || [ ! -f "$BUILD/$builtin" ] || [ -n "$(find $builtin_folders -newer "$list")" ]; then
        list_builtin >"$list.new"
        builtin_source "$list.new" >"$BUILD/$builtin.new"
        cmp -s "$BUILD/$builtin.new" "$BUILD/$builtin" || mv "$BUILD/$builtin.new" "$BUILD/$builtin"
        mv "$list.new" "$list"
    fi
}
