#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: sh parts-parallel.sh N STACK [SCENE] [OPTIONS of spectral render]
# Draws a picture in N parts by GNU parallel, joins them to STACK, and removes them. If it is stopped, the same command goes on
# with the parts that are missing.
#   JOBS      parts at a time (default: one per processor)
#   PARALLEL  more options of GNU parallel, such as --sshloginfile hosts --workdir . where all hosts share this folder
#   SPECTRAL  the program (default: spectral)
set -eu
[ $# -ge 2 ] || { sed -n '3,/^set/s/^# //p' "$0" >&2; exit 2; }
n=$1 stack=$2
shift 2
: "${SPECTRAL:=spectral}"
for i in $(seq "$n"); do [ -f "$stack.$i-of-$n.tif" ] || echo "$i"; done |
    parallel --quote --jobs "${JOBS:-100%}" --retries 3 \
        "$SPECTRAL" render "$@" --part "{}/$n" -o "$stack.{}-of-$n.tif" --threads 1 --quiet
"$SPECTRAL" join -o "$stack" "$stack".*-of-"$n".tif
rm "$stack".*-of-"$n".tif
