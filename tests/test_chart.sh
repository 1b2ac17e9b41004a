#!/bin/bash
# chart --quick does what the long one does: all rows, sane numbers, here of one scene and in the
# long run of all; it goes on where it was interrupted; the charts are drawn; and the figures of the
# texts are those of the rows that are kept. Its timings say nothing and are not looked at.
# tests/test_rivals.c holds the means. Run from the top of the repository.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
chart=$build/chart
model=$build/model
needs "$chart" "$model"
csv=$work/chart.csv

one_scene() { "$chart" --quick --scene slab --csv "$csv"; }
whole_run() { "$chart" --quick --csv "$csv"; }

leaves_another_machine() {
    echo "# chart full, CPU time on another machine" >"$work/other" &&
        cp "$work/other" "$work/other_before"
    refuses 2 "$chart" --quick --csv other && cmp "$work/other" "$work/other_before"
}
refuses_another_kind() {
    echo "this is no chart" >"$work/text"
    refuses 2 "$chart" --quick --csv text && refuses 2 "$model" text x
}

# ---- Rows. Interrupted after about a third, with a row torn in the middle.

rows() { tail -n +3 "$1" | wc -l; }

interrupted_run() {
    "$chart" --quick --csv "$csv" 2>"$work/error" &
    local pid=$! i
    for ((i = 0; i < 600; i++)); do
        [ -f "$csv" ] && [ "$(rows "$csv")" -gt 100 ] && break
        sleep 0.05
    done
    kill -INT $pid
    wait $pid
    local code=$?
    cat "$work/error"
    echo "exit code $code, $(rows "$csv") rows"
    cp "$csv" "$work/part"
    [ $code -eq 130 ] && [ "$(rows "$csv")" -gt 100 ] &&
        grep -q "interrupted; $(rows "$csv") of" "$work/error"
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

# rows_are_complete SCENES: each at each size, every way with all its settings, once; every field a
# number. The walk is the truth's own model: its error goes on falling, and stays below that of
# Lambert where a body is thin.
rows_are_complete() {
    awk -F, -v scenes="$1" '
        NR == 1 { if ($0 !~ /^# chart quick, program [0-9a-f]+, CPU time on /) bad = "head"; next }
        NR == 2 { for (i = 1; i <= NF; i++) column[$i] = i; columns = NF; next }
        {
            key = $1 "," $2 "," $3 "," $4 "," $5 "," $6
            if (key in seen) bad = "twice: " key
            seen[key]
            if (NF != columns) bad = "fields: " $0
            for (i = 5; i <= NF; i++) if ($i !~ /^-?[0-9.]+(e[-+]?[0-9]+)?$/) bad = "no number: " $0
            if (!($column["seconds"] > 0 && $column["error_1"] > 0)) bad = "zero: " $0
            if ($3 == "walk" && !($column["error_64"] < 0.5 * $column["error_1"])) bad = "stays: " $0
            if ($3 == "lambert") lambert[$1] = $column["error_64"]
            if ($1 == "slab" && $3 == "walk" && $2 == 1 && !($column["error_64"] < lambert[$1]))
                bad = "worse than Lambert: " $0
            n[$1 " " $2]++
        }
        END {
            count = split(scenes, scene, " ")
            if (NR != 2 + count * (131 + 77)) bad = NR - 2 " rows"
            for (s = 1; s <= count; s++) {
                if (n[scene[s] " 1"] != 131) bad = scene[s] ": " n[scene[s] " 1"] " rows"
                if (n[scene[s] " 0.125"] != 77) bad = scene[s] " small: " n[scene[s] " 0.125"] " rows"
            }
            if (bad) print bad
            exit bad != ""
        }' "$csv"
}

# ---- Pictures and words

# charts_are_drawn ROWS OUT
charts_are_drawn() {
    "$model" tests/data/mc_searchlight.csv "$work/chart" &&
        "$python" demos/study/chart.py "$1" "$work/chart-model.dat" demos/study/chart-mesh.csv "$2" || return 1
    local name
    for name in race which hints model mesh; do
        [ "$(head -c 4 "$2-$name.png" | tail -c 3)" = PNG ] || { echo "no $2-$name.png" &&
            return 1; }
        [ "$(wc -c <"$2-$name.png")" -gt 10000 ] || { echo "$2-$name.png is empty" && return 1; }
    done
    ! grep -iwE 'nan|inf' "$2.md" "$2-caption.md"
}

chart_py_refuses() {
    refuses 2 "$python" "$PWD/demos/study/chart.py" &&
        refuses 2 "$python" "$PWD/demos/study/chart.py" no/file x y z
}

# The page and the caption come from the rows, and the README quotes the caption if it shows the
# picture.
texts_are_the_figures() {
    charts_are_drawn demos/study/chart.csv "$work/kept" || return 1
    diff demos/study/chart.md "$work/kept.md" &&
        diff demos/study/chart-caption.md "$work/kept-caption.md" || return 1
    grep -q 'chart-race.png' README.md || return 0
    local line
    while IFS= read -r line; do
        grep -qF -- "$line" README.md || { echo "README.md lacks: $line" && return 1; }
    done <demos/study/chart-caption.md
}

# What programs have printed is kept, and three pages quote it.
texts_are_what_was_printed() {
    local page
    for page in README.md demos/study/README.md examples/README.md; do
        cp "$page" "$work/page.md" && demos/study/quote.sh "$work/page.md" || return 1
        diff "$page" "$work/page.md" || return 1
    done
    [ "$(grep -c '<!-- = ' README.md)" -ge 5 ]
}

check "READMEs quote what the programs printed: make measure" texts_are_what_was_printed
check "chart --help" sh -c "'$chart' --help | grep -q '^usage: '"
check "model --help" sh -c "'$model' --help | grep -q '^usage: '"
check "model_error --help" sh -c "'${model}_error' --help | grep -q '^usage: '"
check "the rows of a scene are measured" one_scene
check "they are complete and finite" rows_are_complete slab
python=${PYTHON:-/usr/bin/python3}
drawn=
if "$python" -c 'import matplotlib, pandas' 2>/dev/null; then
    drawn=1
    check "chart.py refuses what it cannot read" chart_py_refuses
    check "charts are drawn; pages and README hold the figures of the rows" texts_are_the_figures
else
    skip "the charts are drawn" "pandas and matplotlib are not here: make setup-long"
fi

only_long_from_here
scenes="sphere slab corner needles bear"
check "all other rows are measured" whole_run
check "all are complete and finite" rows_are_complete "$scenes"
[ -z "$drawn" ] || check "the charts are drawn from them" charts_are_drawn "$csv" "$work/chart"
check "another machine's rows are refused, and stay as they were" leaves_another_machine
check "another kind of file is refused" refuses_another_kind
rm "$csv"
check "interrupted: exit code 130, the finished rows are kept" interrupted_run
check "resumed: a torn row is cut off, the others stay" resumed_run
check "a third run has nothing to do" nothing_left_to_do
check "rows are complete and finite again" rows_are_complete "$scenes"
finish
