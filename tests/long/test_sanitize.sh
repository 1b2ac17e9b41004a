#!/bin/bash
# The checks of fuzz.c under sanitizers: the kept corpus, and new hostile bytes for FUZZ_SECONDS
# (60). Run from the top of the repository. SPDX-License-Identifier: MIT
set -u
. tests/check.sh

# gcc has no list of functions to leave out, and divisions by zero are meant where
# tests/fuzz_ignore.txt says.
corpus() {
    gcc -std=c99 -O1 -g -ffp-contract=off -fno-math-errno -fsanitize=address,undefined,float-cast-overflow \
        -fno-sanitize-recover=all -I. -Itests '-DDATA_DIR="tests/data"' tests/test_fuzz.c -o "$work/corpus" -lcmocka -lm &&
        "$work/corpus" --short
}

# A fuzzer that found something has written its input to the folder that it is given.
fuzz() {
    local program=$1 seconds=$2
    make -s "$program" && mkdir -p "$work/new" || return 1
    "$program" -max_total_time="$seconds" -max_len=400 -artifact_prefix=build/ "$work/new" tests/data/fuzz >"$work/fuzz" 2>&1 ||
        { grep -v '^#' "$work/fuzz"; return 1; }
    grep -q '^Done' "$work/fuzz"
}

check "the corpus under AddressSanitizer and UBSan, gcc" corpus
for program in build/fuzz build/fuzz_memory; do
    if echo 'int LLVMFuzzerTestOneInput(void) { return 0; }' |
        clang -fsanitize=fuzzer -x c - -o "$work/x" 2>"$work/out"; then
        check "hostile bytes, $program" fuzz $program "${FUZZ_SECONDS:-60}"
    else
        skip "hostile bytes, $program" "clang has no libFuzzer: make setup-long"
    fi
done
finish
