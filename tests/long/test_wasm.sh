#!/bin/bash
# The header as WebAssembly, without any library: the bits are those of the native program. Run from
# the top of the repository. SPDX-License-Identifier: MIT
set -u
. tests/check.sh

exact="-std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math"
native() { gcc $exact -O2 -I. tests/bits.c -o "$work/native" -lm && "$work/native"; }

# memory.copy stands for memcpy, as there is no libc to call.
compile_wasm() {
    clang --target=wasm32 $exact $1 -ffreestanding -nostdlib -mbulk-memory -Wno-ignored-pragmas -Wl,--no-entry -I. tests/bits.c \
        -o "$work/bits.wasm"
}
same_bits() {
    compile_wasm "$1" && node tests/tools/wasm.js "$work/bits.wasm" >"$work/bits" || return 1
    echo "expected $reference, is $(cat "$work/bits")"
    [ "$(cat "$work/bits")" = "$reference" ]
}

for tool in clang wasm-ld node; do
    have $tool && continue
    skip "the header as WebAssembly" "there is no $tool: make setup-long"
    finish
done
reference=$(native 2>&1)
check "the native program computes: $reference" grep -qE '^[0-9a-f]{8} over [0-9]{6,} numbers$' <<<"$reference"
for options in -O0 -O1 -O2 -O3 "-O3 -msimd128" "-O2 -DSSS_LANES=1"; do
    check "the same bits: wasm32 $options" same_bits "$options"
done
finish
