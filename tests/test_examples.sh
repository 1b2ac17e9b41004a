#!/bin/bash
# The examples agree with closed forms; make builds them. Three of them ask for the same probes and
# must find the same hits: they print the same digits. Run from the top of the repository.
# SPDX-License-Identifier: MIT
set -u
house="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror"
. tests/check.sh

also_compiles() { $2 $house -fsyntax-only -I. -Iexamples "examples/$1.c"; }
runs() {
    "$build/examples/$1" >"$work/$1.out" && cat "$work/$1.out" || return 1
    [ "$(grep -c truth "$work/$1.out")" = "$2" ]
}

# Each line "NAME: MEAN +- ERROR, truth T" up to one that says "with a fault each:". An error of 0
# means that every sample is the truth. All examples together have 32 independent z-scores: the
# limit of 5 fails correct ones with a chance of 1e-5.
agrees() {
    sed '/^with a fault each:/,$d; s/.*: //' "$work/$1.out" |
        awk '{ z = $3 > 0 ? ($1 - $5) / $3 : $1 == $5 ? 0 : 99; print "z", z, "error", $3 / $5
            if (!(z <= 5 && z >= -5 && $3 < limit * $5)) bad = 1; n++ }
            END { exit bad || n == 0 }' FS='[ ,]+' limit="${2:-0.01}"
}
same() { cmp "$work/$1.out" "$work/all_hits.out"; }

# faults_show NAME COUNT: a z-score of 8 and more each.
faults_show() {
    sed '1,/^with a fault each:/d; s/.*: //' "$work/$1.out" |
        awk '{ z = ($1 - $5) / $3; print "z", z; if (!(z > 8 || z < -8)) bad = 1; n++ }
            END { exit bad || n != count }' FS='[ ,]+' count="$2"
}

# Sharing must at least halve the standard error: it has 16 exits a tile in place of one.
sharing_pays() {
    sed 's/.*: //' "$work/tile.out" |
        awk '{ e[NR] = $3 } END { print e[2] / e[1]; exit !(e[2] < 0.5 * e[1]) }' FS='[ ,]+'
}

# A hint whose floor is the light that it leaves out halves the variance, at least.
hint_pays() {
    sed 's/.*: //' "$work/hint.out" |
        awk '{ v[NR] = $3 * $3 } END { print v[4] / v[1]; exit !(v[4] < 0.5 * v[1]) }' FS='[ ,]+'
}

# On its way a walk has more than one segment.
walk_walks() { awk '/segments, the walk/ { print; exit !($1 > 2) }' "$work/furnace.out"; }

# The two tables of examples/README.md are what the programs print: the furnace's means over the
# truth, and the variances of hints over that without. Both have two or three digits there.
tables_are_printed() {
    {
        sed -n '/segments/d; /truth/s/.*: //p' "$work/furnace.out" |
            awk -F '[ ,]+' '{ print $1 / $5 }'
        sed 's/.*: //' "$work/hint.out" |
            awk -F '[ ,]+' 'NR == 1 { none = $3 } { print ($3 / none) ^ 2 }'
    } >"$work/printed"
    {
        awk -F '|' '/^\| none /, /^$/ { if (NF) print $3 }' examples/README.md
        sed -n '/^| no hint /,/^$/{ /^| 1 /p }' examples/README.md | tr -s '|* ' '\n' | sed '/^$/d'
    } >"$work/shown"
    paste "$work/printed" "$work/shown"
    paste "$work/printed" "$work/shown" |
        awk '{ off = $1 / $2 - 1; if (!(off < 0.02 && off > -0.02)) bad = 1; n++ }
            END { exit bad || n != 14 }'
}

# example NAME LINES [LIMIT]: how many lines it prints, and the largest relative standard error,
# 0.01 where nothing is said.
example() {
    needs "$build/examples/$1"
    check "$1 runs" runs $1 $2
    check "$1 agrees with the truth" agrees $1 ${3:-}
    if have clang; then check "$1 compiles, clang" also_compiles $1 "clang -std=c99"
    else skip "$1 compiles, clang" "there is no clang"; fi
    check "$1 compiles as C++" also_compiles $1 "g++ -std=c++11 -x c++"
}

example all_hits 3
example closest_hit 3
example wavefront 3
check "closest_hit has the digits of all_hits" same closest_hit
check "wavefront has the digits of all_hits" same wavefront
example walk 3
example plan 3
example tile 2 0.05
check "sharing pays" sharing_pays
example texture 3
example any_profile 6
example fresnel 2
example hint 6
check "the hint pays" hint_pays
example furnace 9
check "the furnace shows the faults" faults_show furnace 7
check "examples/README.md shows what they print" tables_are_printed
check "the furnace's walk goes through the volume" walk_walks
example ball 5
check "the ball shows the faults" faults_show ball 2
finish
