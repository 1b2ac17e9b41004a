#!/bin/bash
# A picture in parts, as demos/hosts.md says, small and on this machine alone: the merged parts are
# the picture of one run. Run from the top of the repository after `make all`.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
. tutorial/chapters.sh
pfm=$build/tools/pfm
needs "$build/render" "$pfm"

# The page's commands with eight parts of 4 samples of a small picture, in a folder that has nothing
# but the program.
small() {
    sed 's/640x360/24x20/; s/--spp 64/--spp 4/; s/seq 0 64 448/seq 0 4 28/; s/64 \*/4 */' "$1"
}
at_once() {
    mkdir -p "$work/build" && cp "$build/render" "$work/build/" && (cd "$work" &&
        build/render --scene bear --size 24x20 --spp 32 --pfm one.pfm)
}
note() { tail -c 80 "$1" | LC_ALL=C grep -a -o 'samples .*'; }
is_whole() { # the parts are merged, whoever rendered them
    [ "$(ls "$work"/build/part-*.pfm | wc -l)" = 8 ] &&
        "$pfm" same "$work/one.pfm" "$work/build/whole.pfm" &&
        [ "$(note "$work/one.pfm")" = "$(note "$work/build/whole.pfm")" ]
}
by_parallel() {
    block 1 demos/hosts.md >"$work/page.sh"
    small "$work/page.sh" >"$work/parallel.sh"
    (cd "$work" && bash -eu parallel.sh) && is_whole
}

# What Slurm does with the file, where there is no Slurm: one run for each number of its #SBATCH
# --array.
by_array() {
    rm -f "$work"/build/*.pfm
    small demos/slurm.sh >"$work/array.sh"
    local last task
    last=$(sed -n 's/^#SBATCH --array=0-//p' demos/slurm.sh)
    for ((task = 0; task <= last; task++)); do
        (cd "$work" && SLURM_ARRAY_TASK_ID=$task sh array.sh) || return 1
    done
    (cd "$work" && build/render --merge build/part-*.pfm --pfm build/whole.pfm) && is_whole
}

check "one run" at_once
if have parallel; then check "GNU parallel" by_parallel
else skip "GNU parallel" "it is not here: make setup-long"; fi
check "the tasks of a Slurm array, one by one" by_array
finish
