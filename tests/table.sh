#!/usr/bin/env bash
# Fills the column of figures in tests/README.md from the logs of the last `make test`, and fails if a test that the
# page names has not passed there. Run from the top of the repository; BUILD names where the logs are.
# SPDX-License-Identifier: MIT
set -u
page=tests/README.md logs=${BUILD:-build}/logs missing=0

# Tests are named `file: function function ...`, scripts `file.sh`.
while read -r file functions; do
    log=$logs/test_${file%:}.log
    for function in $functions; do
        grep -qx "\[       OK \] $function" "$log" 2>/dev/null || { echo "$file $function has not passed"; missing=1; }
    done
done < <(grep -o '`[a-z_]*: [a-z_0-9 ]*`' "$page" | tr -d '`' | sort -u)
for script in $(grep -o '`[a-z_]*\.sh`' "$page" | tr -d '`' | sort -u); do
    [ "$(cut -d' ' -f2 "$logs/test_$script.count" 2>/dev/null)" = 0 ] || { echo "$script has not passed"; missing=1; }
done
[ $missing = 0 ] || exit 1

# What the tests of one row have printed: of each function its own lines, of each file its z-scores.
figures() {
    local file functions function
    while read -r file functions; do
        file=${file%:}
        for function in $functions; do
            sed -n "/^\[ RUN      \] $function\$/,/^\[       OK \] $function\$/p" "$logs/test_$file.log" | sed '1d;$d'
        done
    done < <(grep -o '`[a-z_]*: [a-z_0-9 ]*`' <<<"$1" | tr -d '`')
    for file in $(grep -o '`[a-z_]*: ' <<<"$1" | tr -d '`: ' | uniq); do
        grep -h '^[0-9]* z-scores' "$logs/test_$file.log"
    done
    for file in $(grep -o '`[a-z_]*\.sh`' <<<"$1" | tr -d '`'); do
        grep -hE '^    |passed, ' "$logs/test_$file.log" | grep -v '^    ok'
    done
}
while IFS= read -r line; do
    case $line in
    '| '*' | '*' | '*' |')
        case $line in '| promise '*) printf '%s\n' "$line" && continue ;; esac
        tests=$(cut -d'|' -f3 <<<"$line")
        new=$(figures "$tests" | tr -s ' ' | sed 's/^ //; s/[;:.]*$//; s/|/\&#124;/g' | paste -sd';' | sed 's/;/; /g')
        printf '%s|%s| %s |\n' "|$(cut -d'|' -f2 <<<"$line")" "$tests" "${new:-exact}"
        ;;
    *) printf '%s\n' "$line" ;;
    esac
done <"$page" >"$page.new" && mv "$page.new" "$page"
