#!/usr/bin/env bash
# Fills the column of figures in tests/README.md from the logs of the last `make test`, and fails if
# a test that the page names has not passed there. Run from the top of the repository; BUILD names
# where the logs are.
# SPDX-License-Identifier: MIT
set -u
page=tests/README.md logs=${BUILD:-build}/logs missing=0

# Tests are named `file: function function ...`, scripts `file.sh`.
while read -r file functions; do
    log=$logs/test_${file%:}.log
    for function in $functions; do
        grep -qE "^ok [0-9]+ - $function\$" "$log" 2>/dev/null ||
            { echo "$file $function has not passed"; missing=1; }
    done
done < <(grep -o '`[a-z_]*: [a-z_0-9 ]*`' "$page" | tr -d '`' | sort -u)
for script in $(grep -o '`[a-z_]*\.sh`' "$page" | tr -d '`' | sort -u); do
    log=$logs/test_$script.log
    grep -qE '^1\.\.[1-9]' "$log" 2>/dev/null && ! grep -q '^not ok' "$log" ||
        { echo "$script has not passed"; missing=1; }
done
[ $missing = 0 ] || exit 1

# What the tests of one row have printed: of each function its own lines, of each file, once, what
# it says at its end. Lines that begin with blanks are details, for the logs.
declare -A told
figures() {
    local file functions function
    while read -r file functions; do
        file=${file%:}
        for function in $functions; do
            awk -v name=" - $function" '/^(ok |not ok |1\.\.)/ { if ($0 ~ name "$") printf "%s", text; text = ""; next }
                /^ / { next }
                { text = text $0 "\n" }' "$logs/test_$file.log"
        done
        [ "${told[$file]:-}" ] || grep -hE '^[0-9]* (z-scores|worst errors)' "$logs/test_$file.log"
        told[$file]=1
    done < <(grep -o '`[a-z_]*: [a-z_0-9 ]*`' <<<"$1" | tr -d '`')
    for file in $(grep -o '`[a-z_]*\.sh`' <<<"$1" | tr -d '`'); do
        awk '/^    / && / z -?[0-9]/ { sub(/.* z /, ""); z = $0 < 0 ? -$0 : $0 + 0; n++; if (z > worst) worst = z; next }
             /^    / { print }
             /^ok / { passed++ }
             / # SKIP / { skipped++ }
             END {
                 if (n) printf "%d z-scores, worst %.2f\n", n, worst
                 printf "%d passed, %d skipped\n", passed - skipped, skipped
             }' "$logs/test_$file.log"
    done
}
# One line of them, without where the worst cases were.
join() {
    tr -s ' ' | sed 's/^ //; s/[;.]*$//; s/ at [-+0-9.e]*,/,/; s/|//g' | paste -sd';' |
        sed 's/;\([^ ]\)/; \1/g; s/:;/:/g'
}
promises=
while IFS= read -r line; do
    case $line in '## Promises') promises=1 ;; '## '*) promises= ;; esac
    if [[ $promises && $line == '| '* && $line != '| promise '* && $(tr -cd '|' <<<"$line" | wc -c) -eq 4 ]]; then
        tests=$(cut -d'|' -f3 <<<"$line")
        figures "$tests" >"$page.new.figures"
        new=$(join <"$page.new.figures")
        line="|$(cut -d'|' -f2 <<<"$line")|$tests| ${new:-passed} |"
    fi
    printf '%s\n' "$line"
done <"$page" >"$page.new" && rm -f "$page.new.figures" && mv "$page.new" "$page"
