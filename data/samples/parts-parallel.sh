#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: sh parts-parallel.sh N STACK [SCENE] [OPTIONS of spectral render]
# Draws a picture in N parts by GNU parallel, and joins them to STACK. If it is stopped, the same command goes on.
#   JOBS      parts at a time (default: one per processor)
#   PARALLEL  more options of GNU parallel, such as --sshloginfile hosts --workdir . where all hosts share this folder
#   SPECTRAL  the program (default: spectral)
set -eu
[ $# -ge 2 ] || { sed -n '3,/^set/s/^# //p' "$0" >&2; exit 2; }
n=$1
stack=$2
shift 2
: "${SPECTRAL:=spectral}"
# A part that is complete draws nothing again, so that retries cost nothing.
seq "$n" | parallel --quote --jobs "${JOBS:-100%}" --retries 3 \
    "$SPECTRAL" render "$@" -o "$stack" --part "{}/$n" --threads 1 --quiet
exec "$SPECTRAL" join "$stack"
