#!/bin/sh
# SPDX-License-Identifier: MIT
# level: full; packages: mandoc
# Installing puts the program, its manual, completions, documents and samples below PREFIX. They work from there.
# Uninstalling removes them, and the folders that install made, and nothing else.
. test/shared/tap.sh
tmp=$(realpath "$tmp")
files_below() { (cd "$1" && find . | sort); }

exits 0 "install succeeds with DESTDIR" env DESTDIR="$tmp/staged" ./build.sh install /usr/local
prefix=$tmp/staged/usr/local
cat >"$tmp/expected" <<'LIST'
bin/spectral
share/bash-completion/completions/spectral
share/doc/spectral/CHANGELOG.md
share/doc/spectral/LICENSE
share/doc/spectral/README.md
share/doc/spectral/data/doc/scenes.md
share/doc/spectral/data/gallery/room.png
share/doc/spectral/SECURITY.md
share/fish/vendor_completions.d/spectral.fish
share/man/man1/spectral.1
share/man/man5/spectral.5
share/spectral/installed
share/spectral/samples/house.obj
share/spectral/samples/my.scene
share/spectral/samples/paint.csv
share/spectral/samples/room.scene
share/zsh/site-functions/_spectral
LIST
bad=
while read -r file; do [ -s "$prefix/$file" ] || bad="$bad $file"; done <"$tmp/expected"
[ -z "$bad" ]
ok $? "all that belongs to the program is there$bad"
(cd "$prefix" && find . -type f | sed 's:^[.]/::' | LC_ALL=C sort) >"$tmp/out"
grep -v '/$' "$prefix/share/spectral/installed" | diff - "$tmp/out" >"$tmp/err"
ok $? "share/spectral/installed lists each file"
[ -z "$(find "$tmp/staged" -type d ! -perm 755 -o -type f ! -perm 644 ! -path '*/bin/spectral')" ] && [ -x "$prefix/bin/spectral" ]
ok $? "everybody can read them"
lost=$(cd "$prefix/share/doc/spectral" && for page in *.md data/doc/*.md; do
    sed -n 's/](\([^)#]*\)[^)]*)/\n@\1\n/gp' "$page" | sed -n 's/^@\([^:]*\)$/\1/p' | while read -r link; do
        [ -z "$link" ] || [ -e "$(dirname "$page")/$link" ] || echo "$page: $link"
    done
done)
[ -z "$lost" ]
ok $? "each link of the installed pages leads to an installed file$lost"
cmp -s "$SPECTRAL" "$prefix/bin/spectral"
ok $? "the program is the one that was built"
exits 0 "the manual pages have no fault" mandoc -Tlint "$prefix/share/man/man1/spectral.1" "$prefix/share/man/man5/spectral.5"
for scene in "$prefix"/share/spectral/samples/*.scene; do
    exits 0 "the sample ${scene##*/} renders, and agrees with OpenGL" \
        "$prefix/bin/spectral" render "$scene" --size 60x40 --wavelengths 400:700:50 -o "$tmp/sample.tif"
done
cmp -s data/completion/spectral.bash "$prefix/share/bash-completion/completions/spectral" &&
    cmp -s data/completion/_spectral "$prefix/share/zsh/site-functions/_spectral" &&
    cmp -s data/completion/spectral.fish "$prefix/share/fish/vendor_completions.d/spectral.fish"
ok $? "the completions are those that completion.py drives"

files_below "$tmp/staged" >"$tmp/before"
exits 0 "install succeeds again" env DESTDIR="$tmp/staged" ./build.sh install /usr/local
files_below "$tmp/staged" | diff "$tmp/before" - >"$tmp/err"
ok $? "it adds nothing"
exits 0 "uninstall succeeds" env DESTDIR="$tmp/staged" ./build.sh uninstall /usr/local
[ ! -e "$tmp/staged/usr" ]
ok $? "uninstall leaves nothing"
exits 2 "uninstall of nothing is refused" env DESTDIR="$tmp/staged" ./build.sh uninstall /usr/local
says "nothing is installed below $prefix" "the message names the folder"

# Other files and folders below PREFIX stay, empty ones too.
mkdir -p "$tmp/prefix/bin" "$tmp/prefix/share/man/man1" "$tmp/prefix/empty"
echo other >"$tmp/prefix/bin/other"
files_below "$tmp/prefix" >"$tmp/before"
exits 0 "install succeeds beside other files" ./build.sh install "$tmp/prefix/"
exits 0 "uninstall succeeds beside other files" ./build.sh uninstall "$tmp/prefix"
files_below "$tmp/prefix" | diff "$tmp/before" - >"$tmp/err"
ok $? "other files and folders stay"
./build.sh install "$tmp/prefix" >"$tmp/out"
echo mine >"$tmp/prefix/share/spectral/samples/mine.scene"
./build.sh uninstall "$tmp/prefix"
[ "$(find "$tmp/prefix/share" -type f)" = "$tmp/prefix/share/spectral/samples/mine.scene" ]
ok $? "a file of the user among the samples stays"
(cd "$tmp" && "$OLDPWD/build.sh" install here >"$tmp/out" && [ -x here/bin/spectral ] && "$OLDPWD/build.sh" uninstall here) && [ ! -e "$tmp/here" ]
ok $? "PREFIX may be relative to the folder of the call"
mkdir -p "$tmp/evil/share/spectral"
echo ../../precious >"$tmp/evil/share/spectral/installed"
echo precious >"$tmp/precious"
exits 2 "a list with a path that leads out of PREFIX is refused" ./build.sh uninstall "$tmp/evil"
[ -s "$tmp/precious" ]
ok $? "the file outside stays"
exits 2 "install without PREFIX is refused" ./build.sh install
exits 2 "uninstall without PREFIX is refused" ./build.sh uninstall
done_testing
