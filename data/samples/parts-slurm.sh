#!/bin/sh
# SPDX-License-Identifier: MIT
# usage: sh parts-slurm.sh N STACK [SCENE] [OPTIONS of spectral render]
# Draws a picture in N parts as an array of Slurm jobs, and joins them to STACK in a job that waits for all of them.
# Prints the numbers of both. The join says which parts are missing or not complete; the same command goes on with them.
# All nodes share the folder. Slurm takes more options from the environment, as SBATCH_PARTITION and SBATCH_TIMELIMIT.
#   SPECTRAL  the program (default: spectral)
set -eu
: "${SPECTRAL:=spectral}"

# In a job of the array. A process that was killed (3: its work was; above 128: it was itself) goes on, twice.
draw_part() {
    n=$1
    stack=$2
    shift 2
    for _ in 1 2 3; do
        status=0
        "$SPECTRAL" render "$@" -o "$stack" --part "$SLURM_ARRAY_TASK_ID/$n" --threads "${SLURM_CPUS_ON_NODE:-1}" --quiet ||
            status=$?
        [ "$status" = 3 ] || [ "$status" -gt 128 ] || break
    done
    exit "$status"
}

case ${1:-} in
--draw) shift; draw_part "$@" ;;
'' | -*) sed -n '3,/^set/s/^# //p' "$0" >&2; exit 2 ;;
esac
[ $# -ge 2 ] || { echo "parts-slurm.sh: expected N and STACK" >&2; exit 2; }
parts=$(sbatch --parsable --requeue --array="1-$1" --job-name="$2" --output="$2.%a.log" "$0" --draw "$@")
quoted=$(printf '%s\n' "$2" | sed "s/'/'\\\\''/g")
join=$(sbatch --parsable --dependency="afterany:${parts%%;*}" --job-name="$2" --output="$2.join.log" \
    --wrap "'$SPECTRAL' join '$quoted'")
echo "parts $parts, join $join"
