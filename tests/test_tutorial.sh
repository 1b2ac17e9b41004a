#!/bin/bash
# The tutorial holds what it says: every printed command runs, every figure, listing and quoted
# number is what comes out. Make has run the commands that compile. Run from the top of the
# repository. SPDX-License-Identifier: MIT
set -u
. tests/check.sh
. tutorial/chapters.sh
pixels=$build/tools/pixels
needs "$pixels"
mkdir -p build/tutorial
slugs=$(chapters)
strict="-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror"

# ---- The programs. Two at a time; what they print is kept in $work/SLUG.output, how they ended in
# $work/SLUG.status.

# run_chapter SLUG EDIT: the commands of the chapter, in a folder of its own, edited by sed for
# other compilers and options.
run_chapter() {
    rm -f "build/tutorial/$1.png"
    block 1 "tutorial/$1/README.md" | sed "s|build/|build/tutorial/|g; $2" >"$work/$1.commands"
    bash -eu "$work/$1.commands" >"$work/$1.output" 2>"$work/$1.error"
    echo $? >"$work/$1.status"
}
run_all() {
    local slug
    for slug in $slugs; do
        while [ "$(jobs -r | wc -l)" -ge 2 ]; do wait -n; done
        run_chapter "$slug" "$1" &
    done
    wait
}

ran() { cat "$work/$1.commands" "$work/$1.error" && [ "$(cat "$work/$1.status")" = 0 ]; }

# All decisions that random numbers make are in double precision, where another libm's last bit
# turns one in 1e16 of them, or are the header's, which has its own functions: chapters make some
# 1e8. What is left is the curve of the screen: another libm's pow moves a byte by 1, and fewer than
# 255 times 1e-6 of them.
same_figure() {
    local differ worst
    read -r differ worst < <("$pixels" bytes "build/tutorial/$1.png" "tutorial/$1/figure.png") ||
        return 1
    echo "$differ of a million bytes differ, by $worst at most; 255 may, by 1. make tutorial draws the figures anew"
    [ "$differ" -le 255 ] && [ "$worst" -le 1 ]
}
same_text() {
    weave "$1" "$work/$1.output" >"$work/text.md" || return 1
    diff "tutorial/$1/README.md" "$work/text.md" || { echo "make tutorial writes the text anew" &&
        return 1; }
}

check_chapter() {
    local slug=$1
    if [ "$slug" = opencl ] && [ "$(cat "$work/$slug.status")" = 3 ]; then
        skip "$2$slug: its commands run" "there is no OpenCL device: make setup"
        return
    fi
    check "$2$slug: its commands run" ran "$slug"
    check "$2$slug: the committed figure" same_figure "$slug"
    check "$2$slug: the committed listings, output and numbers" same_text "$slug"
}

# The commands of exercises; the first block of all is the chapter's own.
exercises_run() {
    local slug n commands
    for slug in $slugs; do
        [ "$(cat "$work/$slug.status")" = 0 ] || continue
        for ((n = 2; ; n++)); do
            commands=$(block $n "tutorial/$slug/README.md")
            [ -n "$commands" ] || break
            echo "$slug: $commands"
            bash -euc "${commands//build\//build/tutorial/}" || return 1
        done
    done
}

warning_free() {
    local compiler slug
    for compiler in gcc clang; do
        for slug in $slugs; do $compiler $strict -fsyntax-only -I. "tutorial/$slug/main.c" ||
            return 1; done
    done
}

# ---- The text

folders_are_listed() {
    diff <(echo "$slugs" | sort) <(ls tutorial/*/main.c | sed 's|tutorial/\(.*\)/main\.c|\1|' |
        sort)
}
short_programs() {
    wc -l tutorial/*/main.c | awk '$2 != "total" && $1 > 150 { print; bad = 1 } END { exit bad }'
}

# Title, figure and links of a chapter follow the table of contents.
in_order() {
    local slug i=0 before="" title
    for slug in $slugs; do
        i=$((i + 1))
        [ "$slug" != opencl ] || i=A # the appendix, which is the last
        title=$(sed -n "s|^$i\. \[\(.*\)\]($slug/README\.md).*|\1|p" tutorial/README.md)
        [ "$(head -n 1 "tutorial/$slug/README.md")" = "# $i. $title" ] ||
            { echo "title of $slug" && return 1; }
        grep -q "^_Figure $i\. " "tutorial/$slug/README.md" || { echo "no caption in $slug" &&
            return 1; }
        [ -z "$before" ] ||
            grep -q "^Next:.*(\.\./$slug/\| Next:.*(\.\./$slug/" "tutorial/$before/README.md" ||
            { echo "$before does not lead to $slug" && return 1; }
        before=$slug
    done
}
# Equations are numbered through all chapters, in order of appearance, and a text refers to none
# that comes later.
equations_in_order() {
    local slug
    for slug in $slugs; do cat "tutorial/$slug/README.md"; done | awk '
        /\\qquad \([0-9]+\)$/ { match($0, /[0-9]+\)$/); n = substr($0, RSTART, RLENGTH - 1) + 0
            if (n != ++last) { print "(" n ") comes after (" last - 1 ")"; bad = 1 } }
        { for (line = $0; match(line, /\([0-9][0-9]?\)/); line = substr(line, RSTART + RLENGTH))
            if (substr(line, RSTART + 1, RLENGTH - 2) + 0 > last) { print NR ": " $0; bad = 1 } }
        END { exit bad || last == 0 }'
}
listings_are_shown() {
    local slug name names
    names=$(sed -n 's|^// \[\([a-z]*\)\]$|\1|p' tutorial/*.h)
    [ -z "$(echo "$names" | sort | uniq -d)" ] ||
        { echo "two headers have a listing of one name" && return 1; }
    for name in $names; do
        grep -q "^<!-- code $name -->$" tutorial/*/README.md || { echo "$name is not shown" &&
            return 1; }
    done
    for slug in $slugs; do
        for name in $(sed -n 's|^// \[\([a-z]*\)\]$|\1|p' "tutorial/$slug/main.c"); do
            grep -q "^<!-- code $name -->$" "tutorial/$slug/README.md" ||
                { echo "$slug: $name is not shown" && return 1; }
        done
    done
}
links_lead_somewhere() {
    local file link bad=0
    for file in tutorial/README.md tutorial/*/README.md README.md CONTRIBUTING.md; do
        for link in $(grep -o '](\([^)#:]*\))' "$file" | sed 's/](\(.*\))/\1/'); do
            [ -e "$(dirname "$file")/$link" ] || { echo "$file: $link" && bad=1; }
        done
    done
    return $bad
}
# Markdown takes the backslash away from a sign that follows it, so formulas within a line must do
# without.
plain_formulas() { ! grep -n '\$[^$`]*\\[^a-zA-Z $][^$]*\$' tutorial/*/README.md; }

check "the folders are those of the table of contents" folders_are_listed
check "programs have at most 150 lines" short_programs
check "titles, captions and links follow the table of contents" in_order
check "equations are numbered in order" equations_in_order
check "every marked listing is shown" listings_are_shown
check "links lead somewhere" links_lead_somewhere
check "formulas within a line survive Markdown" plain_formulas
run_all "s/^cc /: /"
for slug in $slugs; do check_chapter "$slug" ""; done

only_long_from_here
check "commands of exercises run" exercises_run
check "no warnings" warning_free
check "refused: no file" refuses 2 "$build/tutorial/lambert"
check "refused: two files" refuses 2 "$build/tutorial/area" a.png b.png
check "refused: a file in no folder" refuses 2 "$build/tutorial/plan" no/such/folder/x.png
# Another compiler, no optimisation, and what libm does on a processor without fused operations.
run_all "s/^cc /clang /"
for slug in $slugs; do check_chapter "$slug" "clang, "; done
run_all "s/^cc /gcc /; s/ -O[0-9] / -O0 /"
for slug in $slugs; do check_chapter "$slug" "gcc -O0, "; done
run_all "s|^build/|GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4 build/|"
for slug in $slugs; do check_chapter "$slug" "another libm, "; done
finish
