#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: musl-tools gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user; makes: static
# The static program, and those for another C library and another processor, draw the same bytes (golden_stacks.sh).
. test/shared/tap.sh
. test/builds/golden_stacks.sh

as_golden_by 'static, OSMesa' "${STATIC:-build/spectral-static}"
built_programs musl-gcc -O2 none aarch64-linux-gnu-gcc -O2 none
done_testing
