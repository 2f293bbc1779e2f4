#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; makes: static
# The content of a release archive is complete, runs, and includes its licences. FULL=1 makes the archive twice
# more, in other folders and from the start, OSMesa included: it has the same bytes in any folder and by any user.
. test/shared/tap.sh

# made_in FOLDER BUILD MASK: another path, another umask, another time zone
tmp=$(realpath "$tmp")
made_in() (
    mkdir -p "$tmp/$1"
    cp -R build.sh spectral.c spectral.h spectral.1 spectral.5 README.md LICENSE CHANGELOG.md SECURITY.md CITATION.cff data raster "$tmp/$1"
    umask "$3"
    export XDG_CACHE_HOME="$tmp/$1/cache"
    BUILD=$2 TZ=Asia/Kathmandu "$tmp/$1/build.sh" dist >"$tmp/$1/log" 2>&1 || cat "$tmp/$1/log" >&2
)
version=$("$SPECTRAL" --version | sed -n 's/^spectral //p')
archive=spectral-$version-linux-$(uname -m).tar.gz
made=$(realpath "${BUILD:-build}")
exits 0 "the archive is made" ./build.sh dist
[ -z "$(find . -name 'spectral-*' -maxdepth 1)" ] && [ -s "$made/$archive" ]
ok $? "$archive lies in the folder for all that is made"
if [ "${FULL:-0}" != 0 ]; then
    made_in one build 022 &
    made_in another/folder/of/a/longer/name elsewhere 077
    wait $!
    cmp "$made/$archive" "$tmp/one/build/$archive" &&
        cmp "$made/$archive" "$tmp/another/folder/of/a/longer/name/elsewhere/$archive"
    ok $? "$archive is the same bytes, made elsewhere"
fi

tar -C "$tmp" -xzf "$made/$archive"
release=$tmp/${archive%.tar.gz}
(cd "$release" && sha256sum --quiet --check SHA256SUMS && [ "$(find . -type f | wc -l)" = $(($(wc -l <SHA256SUMS) + 1)) ])
ok $? "SHA256SUMS lists each file with its SHA-256"
for file in spectral gpu.html spectral.1 spectral.5 README.md LICENSE CHANGELOG.md data/builtin/scenes/room.scene data/gallery/room.png \
    data/completion/spectral.bash data/completion/_spectral data/samples/my.scene data/doc/recipes.md; do
    [ -s "$release/$file" ]
    ok $? "the archive holds $file"
done
# Each library that the program is linked with, Mesa, and the compiler's own libraries, which are GNU's.
for library in mesa libtiff libwebp libzstd liblzma liblerc libjpeg libdeflate zlib libc6 libgcc 'libstdc[+][+]'; do
    grep -q "^$library.*[[:space:]][0-9]" "$release/licences/VERSIONS" &&
        find "$release/licences" -type f -size +0 | grep -Eq "/${library}[^/]*$"
    ok $? "the archive has licence and version of $library"
done
! grep -rlE 'GPL-?[0-9]' "$release/licences" | grep -vE '/(libgcc.*|libstdc.*|libc6-dev|liblzma-dev|libzstd-dev)$'
ok $? "no part is under the GPL alone: GNU libraries have exceptions, two others offer a choice"
tar -tvzf "$made/$archive" >"$tmp/listing"
! grep -vE '^[-d]rwxr-xr-x 0/0 |^-rw-r--r-- 0/0 ' "$tmp/listing"
ok $? "everybody can read its files, and their owner is no user of this machine"
tar -tzf "$made/$archive" | sed 's:/$::; s:/: :g' | LC_ALL=C sort -c
ok $? "its files are sorted"
sed 's/^[^ ]*  //' "$release/SHA256SUMS" | LC_ALL=C sort -c
ok $? "the files in SHA256SUMS are sorted"
! grep -v " $(date -u -d "$(sed -n 's/^[.]Dd //p' spectral.1)" +%Y-%m-%d) " "$tmp/listing"
ok $? "its files have the date of the manual page"
exits 0 "its program renders its scene" "$release/spectral" render "$release/data/builtin/scenes/room.scene" \
    --size 60x40 -o "$tmp/room.tif"
"$SPECTRAL" render "$release/data/builtin/scenes/room.scene" --size 60x40 --renderer raster --quiet -o "$tmp/a.tif" &&
    "$release/spectral" render --again "$tmp/a.tif" --quiet -o "$tmp/b.tif"
ok $? "its program makes a stack of $SPECTRAL again"
done_testing
