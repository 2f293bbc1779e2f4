# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2154,SC2164
# Static libtiff and zlib by $CC, from Debian's source packages; build.sh reads this. What is left out
# of libtiff holds pictures that the program refuses, of 1, 2 or 4 bits or of logarithms, or needs
# more libraries.
tiff_packages='dpkg-dev make autoconf automake libtool'
tiff_options='--disable-jpeg --disable-jbig
  --disable-lerc --disable-lzma --disable-zstd --disable-webp --disable-libdeflate --disable-ccitt
  --disable-thunder --disable-next --disable-logluv --disable-mdi'
tiff_flags='-Os -ffunction-sections -fdata-sections -fno-asynchronous-unwind-tables'

# tool NAME prints the name of the compiler's ar or ranlib.
tool() {
    case $CC in *wasm32*) echo "llvm-$1" ;; *) $CC -print-prog-name="$1" ;; esac
}

make_zlib() {
    cd source
    CC=$CC AR=$(tool ar) RANLIB=$(tool ranlib) CFLAGS=$tiff_flags ./configure --static
    make libz.a
    mkdir -p ../library/include
    cp libz.a ../library
    cp zlib.h zconf.h ../library/include
}

make_tiff() {
    configure_tiff $tiff_options --host="$($CC -dumpmachine)" CC="$CC" AR="$(tool ar)" RANLIB="$(tool ranlib)" CFLAGS="$tiff_flags" \
        CPPFLAGS="-I$zlib/include" LDFLAGS="-L$zlib"
}

# configure_tiff OPTION... makes a static libtiff with these options of its configure.
configure_tiff() {
    cd source
    autoreconf -i
    ./configure --disable-shared --disable-cxx --disable-dependency-tracking "$@"
    make -C port
    make -C libtiff libtiff.la
    mkdir -p ../library/include
    cp libtiff/.libs/libtiff.a ../library
    cp libtiff/tiff.h libtiff/tiffio.h libtiff/tiffvers.h libtiff/tiffconf.h ../library/include
}

# Sets $zlib and $tiff to the libraries' folders.
find_tiff() {
    need $tiff_packages
    key="$(cat data/images/libtiff.sh) $($CC -v 2>&1)"
    version=$(debian_version zlib1g)
    cached zlib zlib "$version" "$key"
    zlib=$library
    version=$(debian_version libtiff-dev)
    cached tiff tiff "$version" "$key"
    tiff=$library
}
