# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2034,SC2086,SC2154
# A static OSMesa from Debian's Mesa source package; build.sh reads this. Softpipe alone: no LLVM, and
# nothing that loads or stores files.
osmesa_packages='dpkg-dev meson ninja-build pkgconf python3-mako bison flex g++ libexpat1-dev'
osmesa_options='--default-library=static --buildtype=plain --auto-features=disabled -Db_staticpic=true
  -Db_ndebug=true -Dosmesa=true -Dgallium-drivers=swrast -Dvulkan-drivers= -Dplatforms= -Dllvm=disabled
  -Dshared-glapi=disabled -Dglx=disabled -Degl=disabled -Dgbm=disabled -Ddri3=disabled -Dgles1=disabled
  -Dgles2=disabled -Dzlib=disabled -Dzstd=disabled -Dshader-cache=disabled -Dvalgrind=disabled
  -Dlibunwind=disabled'
osmesa_flags="-O2 -ffunction-sections -fdata-sections $hardening"
# Debian's own tools, whatever comes first on PATH: Mesa asks for Debian's python3-mako.
debian_tools='env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C'

# x86 of 32 bits has no assembler's calls: they would change code while it runs, and lack a function where nothing is shared.
make_osmesa() {
    sed -i "s/^if host_machine.cpu_family() == 'x86'$/if false/" source/meson.build
    $debian_tools CC=gcc CXX=g++ CFLAGS="$osmesa_flags" CXXFLAGS="$osmesa_flags" \
        meson setup $osmesa_options build source
    $debian_tools ninja -C build -j "$(nproc)" src/gallium/targets/osmesa/libOSMesa.so.8.0.0
    mkdir -p library/include/GL library/include/KHR
    find build -name '*.o' | sort | xargs ar qcDs library/libOSMesa.a
    cp source/include/GL/gl.h source/include/GL/glext.h source/include/GL/osmesa.h library/include/GL
    cp source/include/KHR/khrplatform.h library/include/KHR
    cp source/debian/copyright library
}

# Sets $osmesa to the library's folder, and $osmesa_version.
find_osmesa() {
    need $osmesa_packages
    osmesa_version=$(debian_version libosmesa6-dev)
    cached osmesa mesa "$osmesa_version" "$(cat raster/gl/osmesa.sh) $hardening $($debian_tools gcc -v 2>&1)"
    osmesa=$library
}
