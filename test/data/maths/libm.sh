#!/bin/sh
# SPDX-License-Identifier: MIT
# level: first; packages: binutils; makes: library
# C libraries differ in the last bit of these functions, so no file in data/ or raster/ may call one. $LIBRARY
# holds the objects of both.
. test/shared/tap.sh
LIBRARY=${LIBRARY:-build/test/library.a}
inexact='a?(cos|sin|tan)h?|atan2|sincos|exp|exp2|exp10|expm1|log|log2|log10|log1p|cbrt|hypot|pow|erfc?|[lt]gamma'

nm -u "$LIBRARY" | sed -n 's/^ *U //p' >"$tmp/called"
grep -qx ldexp "$tmp/called"
ok $? "the objects list the functions that they call"
run grep -Ex "($inexact)[fl]?" "$tmp/called"
[ "$status" = 1 ]
ok $? "no object calls an inexact function of the C library"
done_testing
