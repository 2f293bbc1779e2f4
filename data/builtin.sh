# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2094,SC2154
# Text files (and textures) as C, so that the program runs alone; build.sh reads this. The program finds
# a file by its name relative to data/builtin. The program for browsers is compiled in compressed.
builtin=data/builtin
left_out= # a pattern of files that are not compiled in

# builtin_bytes FILE prints the bytes that are compiled in.
builtin_bytes() {
    case $1 in *.wasm) gzip -9nc "$1" ;; *) cat "$1" ;; esac
}

builtin_source() {
    echo '#include "data/base/base.h"'
    number=0
    while read -r file; do
        number=$((number + 1))
        echo "static const unsigned char file_${number}[] = {"
        builtin_bytes "$file" | od -An -v -tu1 | sed 's/  */,/g; s/^,//; s/$/,/'
        echo '0};'
    done <"$1"
    echo 'const struct builtin_file builtin_files[] = {'
    number=0
    while read -r file; do
        number=$((number + 1))
        case $file in *.wasm) file=$file.gz ;; esac
        echo "{\"${file#data/builtin/}\", file_$number, sizeof file_$number - 1},"
    done <"$1"
    echo '};'
    echo "const size_t builtin_file_count = $number;"
}

# Makes $BUILD/builtin.c anew if a file, or a folder of them, has changed since the list was begun.
make_builtin() {
    list=$BUILD/builtin.list
    if [ ! -f "$list" ] || [ ! -f "$BUILD/builtin.c" ] || [ -n "$(find $builtin -newer "$list")" ]; then
        find $builtin -type f | grep -Ev "${left_out:-^$}" | sort >"$list.new"
        builtin_source "$list.new" >"$BUILD/builtin.new"
        cmp -s "$BUILD/builtin.new" "$BUILD/builtin.c" || mv "$BUILD/builtin.new" "$BUILD/builtin.c"
        mv "$list.new" "$list"
    fi
}
