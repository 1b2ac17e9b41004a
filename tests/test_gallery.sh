#!/bin/bash
# failures --quick does what the long one does: each classical way is measurably wrong, the header
# beside it is not; the page and its pictures are there. Run from the top of the repository, with
# BUILD naming where the programs are.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
program=$build/failures
needs "$program"
names="edge hits retry reach colours wall hair slab bumps floats"
out=$work/gallery

measure() { "$program" --quick "$out" >"$work/table"; }

# Of the classical ways a mean has |z| > 20 against the truth, a variance z > 20 against the
# header's, and what is exact is over its limit: the bound of the header's weights, or the error
# that the header promises. Of the header each mean has |z| < 4.5: 33 of them, a false alarm in
# 2.2e-4 of all choices of seeds, which are fixed. How large a bias would be seen is printed, and
# bounded. Every panel has rows of both sides.
claims_hold() {
    awk -F, -v names="$names" '
        NR == 1 { next }
        {
            if (NF != 8) bad = "fields: " $0
            n[$1 " " $2]++
            size = $8 < 0 ? -$8 : $8
            if ($2 == "ours" && $3 == "mean") {
                means++
                if (!(size < 4.5)) bad = $0
                if (size > worst) worst = size
                seen = 4.5 * sqrt($5 * $5 + $7 * $7) / $6
                if (seen > blunt) blunt = seen
                if (!(seen < 0.15)) bad = "not sharp: " $0
            }
            else if ($2 == "ours" && $3 == "exact") { if (!($4 > 0 && $4 <= $6)) bad = $0 }
            else if ($2 == "classical" && $3 == "exact") { if (!($4 > $6)) bad = $0 }
            else if ($2 == "classical" && ($3 == "mean" || $3 == "noise")) {
                if (!(size > 20 && ($3 == "mean" || $8 > 20))) bad = $0
                if (!least || size < least) least = size
            }
            else bad = "kind: " $0
        }
        END {
            count = split(names, name, " ")
            for (i = 1; i <= count; i++)
                if (!n[name[i] " classical"] || !n[name[i] " ours"]) bad = name[i] ": rows missing"
            printf "%d means of the header, worst z of either sign %.2f; the least sharp sees a bias of %.0f %%\n", means, worst, \
                100 * blunt
            printf "the least z of the classical ways of either sign %.0f\n", least
            if (bad) print bad
            exit bad != ""
        }' "$work/table"
}

is_picture() {
    [ "$(head -c 4 "$1" | tail -c 3)" = PNG ] && [ "$(wc -c <"$1")" -gt "$2" ] ||
        { echo "no picture $1" && return 1; }
}
page_is_whole() {
    local name count=0
    for name in $names; do
        grep -q "<img src=\"gallery-$name.png\"" "$out.html" ||
            { echo "$name is not on the page" && return 1; }
        count=$((count + 1))
    done
    ! grep -iE 'nan|[^a-z]inf[^a-z]' "$out.html" &&
        [ "$(grep -c '<figure>' "$out.html")" -eq "$count" ]
}
pictures_are_drawn() {
    local name
    gnuplot -e "out='$out'" demos/study/failures.gp || return 1
    for name in $names; do is_picture "$out-$name.png" 10000 || return 1; done
    is_picture "$out.png" 50000 && ! grep -iE 'nan|inf' "$out"-*.dat
}

check "failures --help" sh -c "'$program' --help | grep -q '^usage: '"
check "failures runs" measure
check "each classical way fails, and the header does not" claims_hold
figures
check "the page shows every panel" page_is_whole
if have gnuplot; then check "the panels are drawn" pictures_are_drawn
else skip "the panels are drawn" "gnuplot is not here: make setup"; fi
finish
