# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2154
# Installs the program with all that belongs to it below a folder, and removes it again; build.sh reads this.
# A list of what was written, share/spectral/installed, has a path a line: relative to PREFIX, or a folder
# from / on where install made PREFIX or folders above it. The paths of folders end in a slash.

# shipped prints each file that is installed beside the program, and its place below PREFIX.
shipped() {
    echo spectral.1 share/man/man1/spectral.1
    echo spectral.5 share/man/man5/spectral.5
    echo data/completion/spectral.bash share/bash-completion/completions/spectral
    echo data/completion/_spectral share/zsh/site-functions/_spectral
    echo data/completion/spectral.fish share/fish/vendor_completions.d/spectral.fish
    for file in README.md LICENSE CHANGELOG.md SECURITY.md CITATION.cff data/doc/*.md data/gallery/*.png; do
        echo "$file share/doc/spectral/$file" # links between them lead on
    done
    for file in data/builtin/scenes/*.scene data/builtin/displays/monitor.csv data/samples/*; do
        echo "$file share/spectral/samples/${file##*/}"
    done
}

# Sets $root, the folder that stands for / (DESTDIR, or none), and $prefix, a path from there on. A relative
# DESTDIR, or PREFIX without one, is below the folder that build.sh was called from.
find_target() {
    root=${DESTDIR:-}
    prefix=$1
    case $root in '' | /*) ;; *) root=$called_from/$root ;; esac
    case $prefix in /*) ;; *) prefix=$([ -n "$root" ] || echo "$called_from")/$prefix ;; esac
    root=${root%/}
    prefix=${prefix%/}
    installed=$root$prefix/share/spectral/installed
}

# make_folder PATH makes the folder PATH below $root, and those above it, and prints each that is new.
make_folder() {
    [ ! -d "$root$1/" ] || return 0
    make_folder "${1%/*}"
    mkdir -m 755 "$root$1"
    case $1/ in "$prefix"/?*) echo "${1#"$prefix/"}/" ;; *) echo "$1/" ;; esac
}

# put MODE FILE PLACE copies a file, and prints what is new below PREFIX.
put() {
    make_folder "$prefix/${3%/*}"
    install -m "$1" "$2" "$root$prefix/$3"
    echo "$3"
}

install_program() {
    find_target "$1"
    mkdir -p "$root/"
    {
        put 755 "$BUILD/spectral$kind" bin/spectral
        shipped | while read -r file place; do put 644 "$file" "$place"; done
        make_folder "$prefix/share/spectral"
        echo share/spectral/installed
        [ ! -f "$installed" ] || cat "$installed"
    } >"$BUILD/installed"
    sort -u "$BUILD/installed" >"$BUILD/installed.sorted"
    install -m 644 "$BUILD/installed.sorted" "$installed"
}

# In reverse order a folder comes behind all that is in it. Folders that hold something else stay.
uninstall_program() {
    find_target "$1"
    [ -f "$installed" ] || refuse "build.sh: nothing is installed below $root$prefix: $installed is missing"
    sort -r "$installed" | while read -r path; do
        case $path in
        */../* | ../*) refuse "build.sh: $installed names '$path', which install does not write" ;;
        /*/) rmdir "$root$path" 2>/dev/null || : ;;
        */) rmdir "$root$prefix/$path" 2>/dev/null || : ;;
        *) rm -f "$root$prefix/$path" ;;
        esac
    done
}
