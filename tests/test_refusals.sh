#!/bin/bash
# Command lines that make no sense: each program says so in one line and ends with exit code 2. The
# table is tests/refusals.txt. Run from the top of the repository after `make all`.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
export data=$PWD/tests/data

last=
while IFS='|' read -r program words; do
    program=${program%% *}
    [ -n "$program" ] && [ "$program" != '#' ] || continue
    [ "$in_long_run" ] || [ "$program" != "$last" ] || continue
    last=$program
    if [ "${program#mesh}" != "$program" ] && [ ! -x "$build/mesh" ]; then
        skip "$program refuses:$words" "make setup installs Embree and assimp"
        continue
    fi
    eval "arguments=($words)"
    check "$program refuses:$words" refuses 2 timeout 60 "$build/$program" "${arguments[@]}"
done <tests/refusals.txt
finish
