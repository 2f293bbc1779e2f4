# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC1091,SC2034,SC2086,SC2154
# The static program, which has an OSMesa of its own (osmesa.sh), and the release archive around it;
# build.sh reads this.
static_packages='g++ libc6-dev libtiff-dev zlib1g-dev libzstd-dev libdeflate-dev liblzma-dev libjpeg-dev libwebp-dev
  liblerc-dev'
. raster/gl/osmesa.sh

# Sets $sources, $CFLAGS and $libraries. Mesa calls the pthread functions only if another object brings
# them, and crashes without. libjbig
# would put the program under the GPL: its functions are left out and never called, since data/images/image.c
# refuses its pictures.
find_static_libraries() {
    [ "$GL" = osmesa ] || refuse "build.sh: the static program has an OSMesa of its own; GL=$GL is for the plain build"
    need $static_packages
    find_osmesa
    find_sources
    CFLAGS="$CFLAGS $hardening -ffunction-sections -fdata-sections -isystem $osmesa/include
        -DOSMESA_VERSION=\"${osmesa_version%%-*}\""
    static=-static-pie
    case $($CC -dumpmachine) in i?86-*) static='-static -no-pie' ;; esac # its libc.a is for one place in memory
    libraries="$static -Wl,--gc-sections,-z,relro,-z,now,-z,noexecstack
        -Wl,-u,pthread_mutexattr_init,-u,pthread_mutexattr_settype,-u,pthread_mutexattr_destroy
        $(printf ' -Wl,--defsym=jbg_%s=abort' dec_free dec_getimage dec_getsize dec_in dec_init enc_free \
            enc_init enc_out newlen strerror)
        -L$osmesa -lOSMesa -ltiff -lwebp -lzstd -llzma -lLerc -ljpeg -ldeflate -lz -lstdc++ -lm"
}

# In a shell of its own, which keeps $CFLAGS and $libraries. The file .symbols is for debuggers. Another
# version of a package that becomes part of the program makes all of it anew.
static_program() (
    prepare
    find_static_libraries
    parts=$(versions $static_packages)
    compile "obj-static${small:+-minimal}" "$CFLAGS" $sources "$BUILD/$builtin"
    link "spectral-static$kind.symbols" $objects
    strip -o "$BUILD/spectral-static.new" "$BUILD/spectral-static$kind.symbols"
    mv "$BUILD/spectral-static.new" "$BUILD/spectral-static$kind"
)

# licences FOLDER writes the versions and copyrights of all that the static program holds beside this
# project's own code.
licences() {
    folder=$1
    mkdir "$folder"
    cp "$osmesa/copyright" "$folder/mesa"
    gcc=$(gcc -dumpversion)
    set -- libtiff-dev libwebp-dev libzstd-dev liblzma-dev liblerc-dev libjpeg62-turbo-dev libdeflate-dev \
        zlib1g-dev libc6-dev "libgcc-$gcc-dev" "libstdc++-$gcc-dev"
    { echo "mesa $osmesa_version"; versions "$@"; } >"$folder/VERSIONS"
    for package; do
        cp -L "/usr/share/doc/$package/copyright" "$folder/$package"
    done
}

# The archive is the same bytes wherever it is made of the same versions: its date is the manual page's.
# It has live pages.
dist() {
    kind=-live
    static_program
    find_osmesa
    version=$(sed -n 's/^#define SPECTRAL_VERSION "\(.*\)"/\1/p' spectral.h)
    name=spectral-$version-linux-$(uname -m)
    rm -rf "${BUILD:?}/$name"
    mkdir "$BUILD/$name" "$BUILD/$name/data"
    cp "$BUILD/spectral-static-live" "$BUILD/$name/spectral"
    cp README.md LICENSE CHANGELOG.md SECURITY.md CITATION.cff spectral.1 spectral.5 "$BUILD/$name"
    for folder in data/builtin data/gallery data/completion data/samples data/doc; do
        [ ! -d "$folder" ] || cp -R "$folder" "$BUILD/$name/data"
    done
    licences "$BUILD/$name/licences"
    "$BUILD/$name/spectral" verify --page "$BUILD/$name/gpu.html" >/dev/null
    (cd "$BUILD/$name" && find . -type f | sort | xargs sha256sum >../SHA256SUMS && mv ../SHA256SUMS .)
    tar -C "$BUILD" -c --sort=name --mtime="$(sed -n 's/^[.]Dd //p' spectral.1) UTC" --owner=0 --group=0 \
        --numeric-owner --mode=u=rwX,go=rX "$name" | gzip -9n >"$BUILD/$name.tar.gz.new"
    mv "$BUILD/$name.tar.gz.new" "$BUILD/$name.tar.gz"
    rm -rf "${BUILD:?}/$name"
    (cd "$BUILD" && sha256sum "$name.tar.gz")
}
