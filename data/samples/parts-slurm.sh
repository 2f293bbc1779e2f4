#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: sh parts-slurm.sh N STACK [SCENE] [OPTIONS of spectral render]
# Draws a picture in N parts as an array of Slurm jobs; a job that waits for all of them joins them to STACK, and removes them.
# Prints the numbers of both. If a part is missing in the end, the same command goes on with it. All nodes share the folder.
# Slurm takes more options from the environment, as SBATCH_PARTITION and SBATCH_TIMELIMIT.
#   SPECTRAL  the program (default: spectral)
set -eu
[ $# -ge 2 ] || { sed -n '3,/^set/s/^# //p' "$0" >&2; exit 2; }
: "${SPECTRAL:=spectral}"
step=$1
case $step in --draw | --join) shift ;; esac
n=$1 stack=$2
shift 2
case $step in
--draw) # A process that was killed begins again, twice.
    i=$SLURM_ARRAY_TASK_ID
    for _ in 1 2 3; do
        [ -f "$stack.$i-of-$n.tif" ] ||
            "$SPECTRAL" render "$@" --part "$i/$n" -o "$stack.$i-of-$n.tif" --threads "${SLURM_CPUS_ON_NODE:-1}" --quiet || :
    done
    [ -f "$stack.$i-of-$n.tif" ]
    ;;
--join)
    "$SPECTRAL" join -o "$stack" "$stack".*-of-"$n".tif
    rm "$stack".*-of-"$n".tif
    ;;
*)
    parts=$(sbatch --parsable --array="1-$n" --job-name="$stack" --output="$stack.%a.log" "$0" --draw "$n" "$stack" "$@")
    join=$(sbatch --parsable --dependency="afterany:${parts%%;*}" --job-name="$stack" --output="$stack.join.log" \
        "$0" --join "$n" "$stack")
    echo "parts $parts, join $join"
    ;;
esac
