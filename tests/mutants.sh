#!/bin/sh
# Plants the bugs of tests/mutants.txt one by one in a copy of sss_resample.h and asks the named
# tests to notice. Fails if a bug survives, if an edit changes nothing or if the result does not
# compile. Run from the repository's root:
#     sh tests/mutants.sh [part of a name]
# It means something only where the unchanged header passes: run the tests first.
# CC and MUTANT_CFLAGS may be set.
set -u
compiler=${CC:-gcc}
flags=${MUTANT_CFLAGS:--std=c99 -O2 -ffp-contract=off -fno-math-errno -fno-trapping-math -fopenmp}
only=${1:-}
copy=$(mktemp -d) || exit 1
trap 'rm -rf "$copy"' EXIT
trap 'echo "mutants.sh: stopped by a signal, the table is not complete"; exit 1' HUP INT TERM
failures=0
total=0

# Builds and runs one test against the copy: 0 if it noticed, 1 if not, 2 if it does not compile, 3
# if it took too long, which is no verdict.
try() {
    # shellcheck disable=SC2086
    $compiler $flags -w -I"$copy" -Itests -I. '-DDATA_DIR="tests/data"' "tests/test_$1.c" -o "$copy/test" -lcmocka -lm \
        >"$copy/log" 2>&1 || return 2
    SSS_TEST_LONG=1 timeout 600 "$copy/test" >"$copy/log" 2>&1
    case $? in 0) return 1 ;; 124) return 3 ;; esac
    return 0
}
report() {
    printf '%-38s %-12s %s\n' "$1" "$2" "$3"
}
judge() {
    for name in $2; do
        try "$name"
        case $? in
        0) report "$1" killed "by test_$name"; return 0 ;;
        3) report "$1" TIMEOUT "test_$name"; return 1 ;;
        2) report "$1" BROKEN "does not compile: $(grep -m 1 error "$copy/log")"; return 1 ;;
        esac
    done
    report "$1" SURVIVED "$2"
    return 1
}

while IFS= read -r line; do
    case $line in '' | '#'*) continue ;; esac
    name=${line%% | *}
    rest=${line#* | }
    tests=${rest%% | *}
    edit=${rest#* | }
    case $name in *"$only"*) ;; *) continue ;; esac
    total=$((total + 1))
    sed -e "$edit" sss_resample.h >"$copy/sss_resample.h" ||
        { report "$name" STALE "sed refuses the edit"; exit 1; }
    if cmp -s sss_resample.h "$copy/sss_resample.h"; then
        report "$name" STALE "the edit changes nothing"
        failures=$((failures + 1))
        continue
    fi
    judge "$name" "$tests" || failures=$((failures + 1))
done <tests/mutants.txt

echo "$total bugs planted, $failures not noticed"
[ "$failures" -eq 0 ] && [ "$total" -gt 0 ]
