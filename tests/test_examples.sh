#!/bin/bash
# The three examples compile, agree with a closed form, and, since they ask for the same probes and must find the same
# hits, print the same digits. Run from the top of the repository. SPDX-License-Identifier: MIT
set -u
house="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror"
exact="-ffp-contract=off -fno-math-errno -fno-trapping-math"
. tests/check.sh

compiles() { gcc -std=c99 $house $exact -O1 -I. -Iexamples "examples/$1.c" -o "$work/$1" -lm; }
also_compiles() { $2 $house -fsyntax-only -I. -Iexamples "examples/$1.c"; }
runs() { "$work/$1" >"$work/$1.out" && cat "$work/$1.out" && [ "$(wc -l <"$work/$1.out")" = 3 ]; }

# Three z-scores an example, all of the same numbers: the limit of 5 fails a correct one with a chance of 2e-6.
agrees() {
    awk '{ z = ($1 - $5) / $3; print "z", z; if (!(z <= 5 && z >= -5 && $3 > 0 && $3 < 0.01 * $5)) bad = 1; n++ }
        END { exit bad || n != 3 }' FS='[ ,]+' "$work/$1.out"
}
same() { cmp "$work/$1.out" "$work/all_hits.out"; }

for example in all_hits closest_hit wavefront; do
    check "$example compiles" compiles $example
    check "$example runs" runs $example
    check "$example has the slab's integral" agrees $example
    check "$example has the digits of all_hits" same $example
    if have clang; then check "$example compiles, clang" also_compiles $example "clang -std=c99"
    else skip "$example compiles, clang" "there is no clang"; fi
    check "$example compiles as C++" also_compiles $example "g++ -std=c++11 -x c++"
done
finish
