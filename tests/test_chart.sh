#!/bin/bash
# chart --quick does what the long one does: all rows, sane numbers, unbiased methods with the mean of brute force; it
# goes on where it was interrupted; the charts are drawn. Its timings say nothing and are not looked at. Run from the
# top of the repository, with BUILD naming where the programs are. SPDX-License-Identifier: MIT
set -u
. tests/check.sh
chart=$build/chart
model=$build/model
needs "$chart" "$model"
csv=$work/chart.csv

whole_run() { "$chart" --quick --csv "$csv"; }

leaves_another_machine() {
    echo "# chart full, CPU time on another machine" >"$work/other" && cp "$work/other" "$work/other_before"
    refuses 2 "$chart" --quick --csv other && cmp "$work/other" "$work/other_before"
}
refuses_another_kind() {
    echo "this is no chart" >"$work/text"
    refuses 2 "$chart" --quick --csv text && refuses 2 "$model" --quick text x
}

# ---- Rows. Interrupted after about a third, with a row torn in the middle.

rows() { tail -n +3 "$1" | wc -l; }

interrupted_run() {
    "$chart" --quick --csv "$csv" 2>"$work/error" &
    local pid=$! i
    for ((i = 0; i < 600; i++)); do
        [ -f "$csv" ] && [ "$(rows "$csv")" -gt 150 ] && break
        sleep 0.05
    done
    kill -INT $pid
    wait $pid
    local code=$?
    cat "$work/error"
    echo "exit code $code, $(rows "$csv") rows"
    cp "$csv" "$work/part"
    [ $code -eq 130 ] && [ "$(rows "$csv")" -gt 150 ] && grep -q "interrupted; $(rows "$csv") of" "$work/error"
}

resumed_run() {
    tail -n 1 "$work/part" | head -c 40 >>"$csv"
    "$chart" --quick --csv "$csv" || return 1
    head -n "$(wc -l <"$work/part")" "$csv" | cmp - "$work/part"
}

nothing_left_to_do() {
    cp "$csv" "$work/whole"
    "$chart" --quick --csv "$csv" && cmp "$csv" "$work/whole"
}

# Every scene, every cost of shading, every method with all its settings, once; every field a number.
rows_are_complete() {
    awk -F, '
        NR == 1 { if ($0 !~ /^# chart quick, program [0-9a-f]+, CPU time on /) bad = "head"; next }
        NR == 2 { for (i = 1; i <= NF; i++) column[$i] = i; columns = NF; next }
        {
            key = $1 "," $2 "," $3 "," $4 "," $5 "," $6
            if (key in seen) bad = "twice: " key
            seen[key]
            if (NF != columns) bad = "fields: " $0
            for (i = 1; i <= NF; i++)
                if (i != column["scene"] && i != column["method"] && $i !~ /^-?[0-9.]+(e[-+]?[0-9]+)?$/) bad = $0
            if (!($column["seconds"] > 0 && $column["error_1"] > 0 && $column["reference_error"] > 0)) bad = "zero: " $0
            if ($column["variance"] < 0 || $column["shading_over_probe"] <= 0) bad = "negative: " $0
            n[$1 " " $2 " " $3]++
        }
        END {
            split("sphere slab corner needles bear", scene, " ")
            split("0 64 512 4096", cost, " ")
            for (s = 1; s <= 5; s++) {
                for (c = 1; c <= 4; c++)
                    if (n[scene[s] " 1 " cost[c]] != 29) bad = scene[s] " at " cost[c] ": rows missing"
                if (n[scene[s] " 0.0625 64"] != 12) bad = scene[s] " at its smaller dmfp: rows missing"
            }
            if (bad) print bad
            exit bad != ""
        }' "$csv"
}

# The mean of each exact method is that of brute force: each row by itself at |z| < 5, with 540 rows a false alarm in
# 3e-4 of all choices of seeds; and the mean of a method over all its rows, as if the rows of a scene told the same
# (they share the reference), with 8 methods 5e-6. The seeds are fixed. A bias of 5 % in ours and of 11 % in chords is
# seen by the latter.
means_agree() {
    awk -F, '
        NR == 2 { for (i = 1; i <= NF; i++) column[$i] = i }
        NR > 2 && $column["exact"] == 1 {
            bias = $column["bias"]
            error = $column["bias_error"]
            if (!(bias < 5 * error && -bias < 5 * error)) { print; bad = 1 }
            n[$4]++
            sum[$4] += bias
            squares[$4] += error * error
        }
        END {
            for (m in n) {
                limit = 5 * sqrt(squares[m] / n[m] / 5)
                printf "%s: bias %+.4f, limit %.4f, %d rows\n", m, sum[m] / n[m], limit, n[m]
                if (!(sum[m] / n[m] < limit && -sum[m] / n[m] < limit && limit < 0.12)) bad = 1
                methods++
            }
            exit bad || methods != 8
        }' "$csv"
}

# ---- Pictures

charts_are_drawn() {
    "$model" --quick tests/data/mc_searchlight.csv "$work/chart" || return 1
    awk -v out="$work/chart" -f demos/study/chart.awk "$csv" || return 1
    gnuplot -e "out='$work/chart'" demos/study/chart.gp || return 1
    local name
    for name in when error-0 error-64 error-512 error-4096 best size model plan seam; do
        [ "$(head -c 4 "$work/chart-$name.png" | tail -c 3)" = PNG ] || { echo "no chart-$name.png" && return 1; }
        [ "$(wc -c <"$work/chart-$name.png")" -gt 10000 ] || { echo "chart-$name.png is empty" && return 1; }
        grep -q '</svg>' "$work/chart-$name.svg" || { echo "no chart-$name.svg" && return 1; }
    done
    ! grep -iE 'nan|inf' "$work"/chart-*.dat "$work/chart-titles.gp"
}

check "chart --help" sh -c "'$chart' --help | grep -q '^usage: '"
check "model --help" sh -c "'$model' --help | grep -q '^usage: '"
check "model_error --help" sh -c "'${model}_error' --help | grep -q '^usage: '"
check "all rows are measured" whole_run
check "rows are complete and finite" rows_are_complete
check "unbiased methods agree with brute force" means_agree
figures
if have gnuplot; then
    check "the charts are drawn" charts_are_drawn
else
    skip "the charts are drawn" "gnuplot is not here: make setup"
fi

only_long_from_here
check "another machine's rows are refused, and stay as they were" leaves_another_machine
check "another kind of file is refused" refuses_another_kind
rm "$csv"
check "interrupted: exit code 130, the finished rows are kept" interrupted_run
check "resumed: a torn row is cut off, the others stay" resumed_run
check "a third run has nothing to do" nothing_left_to_do
check "rows are complete and finite again" rows_are_complete
finish
