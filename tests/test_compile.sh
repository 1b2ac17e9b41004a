#!/bin/bash
# The header compiles everywhere, and computes the same bits everywhere. Run from the top of the
# repository.
# SPDX-License-Identifier: MIT
set -u
house="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror"
exact="-ffp-contract=off"
. tests/check.sh

# One compiler, one standard: the header alone, twice, and used to the last function. In the long
# run the oldest standard of each language is compiled with -O3 too, which sees what the mere look
# does not warn of.
compile_all() {
    local compiler=$1 standard=$2 language=$3 how=-fsyntax-only
    local with="$compiler -x $language -std=$standard $house $exact -I."
    case $standard$in_long_run in c991 | c++111) how="-O3 -c -o $work/bits.o" ;; esac
    $with -fsyntax-only tests/compile/alone.c && $with -fsyntax-only tests/compile/twice.c &&
        $with $how tests/bits.c
}

check_languages() { # COMPILERS LANGUAGE STANDARDS
    local compiler standard
    for compiler in $1; do
        for standard in $3; do
            if have $compiler; then check "$compiler -std=$standard" compile_all $compiler $standard $2
            else skip "$compiler -std=$standard" "there is no $compiler"; fi
        done
    done
}

two_files() {
    gcc -std=c99 $house $exact -I. tests/compile/first.c tests/compile/second.c -o "$work/two" -lm && "$work/two"
}

# Names that <windows.h> and others define as macros.
no_common_name() {
    $1 -x "$2" -Wall -Wextra -Wpedantic -Werror -I. -fsyntax-only tests/compile/windows.c
}

# Neither -O0 nor -O2 leaves a symbol of the header in an object that does not use it.
exports_nothing() {
    local compiler=$1 level
    for level in O0 O2; do
        $compiler -x c -std=c99 -$level $exact -I. -c tests/compile/alone.c -o "$work/alone.o" ||
            return 1
        nm "$work/alone.o" | grep -v ' U _GLOBAL_OFFSET_TABLE_$' >"$work/symbols"
        cat "$work/symbols"
        [ ! -s "$work/symbols" ] || return 1
    done
}

# Of libm at most sqrtf (fabsf is an instruction). A compiler copies structures with memcpy and
# memset as it likes, and bits.c prints.
calls_only_sqrtf() {
    ! nm -u "$work/bits.o" | awk '{ print $2 }' | grep -vxE \
        'sqrtf|mem(cpy|set|move)|printf|fprintf|stderr|puts|putchar|fwrite|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail'
}

# bits_of COMPILER FLAGS...: the checksum, or nothing. Linked without the flags: fast math would
# flush denormals. Other people's builds warn of nothing in all of the interface, also where loops
# have a single turn.
bits_of() {
    "$@" -Wall -Wextra -Werror -I. -c tests/bits.c -o "$work/bits.o" &&
        $1 "$work/bits.o" -o "$work/bits" -lm &&
        "$work/bits"
}

same_bits() {
    local bits
    bits=$(bits_of "$@") || return 1
    echo "expected $reference, is $bits"
    [ -n "$bits" ] && [ "$bits" = "$reference" ] && calls_only_sqrtf
}

reference=$(bits_of gcc -std=c99 -O0 $exact 2>&1)
check_bits() { # a table of compilers, languages and flags
    local flags compiler language
    while read -r compiler language flags; do
        if ! have $compiler; then
            skip "the same bits: $compiler $flags" "there is no $compiler"
            continue
        fi
        check "the same bits, of libm only sqrtf: $compiler $flags" same_bits $compiler -x $language $flags $exact
    done
}

# Another processor's or system's bits. Of the emulators wine is not asked for: it is large.
foreign_bits() {
    local emulator=$1 bits
    shift
    "$@" $exact -I. tests/bits.c -o "$work/foreign" -lm || return 1
    [ ! -f "$work/foreign.exe" ] || mv "$work/foreign.exe" "$work/foreign"
    bits=$(WINEPREFIX=$work/wine WINEDEBUG=-all $emulator "$work/foreign" | tr -d '\r')
    echo "expected $reference, is $bits"
    [ "$bits" = "$reference" ]
}

check_processors() {
    local emulator compiler flags level
    while read -r emulator compiler flags; do
        for level in -O0 -O1 -O2 -O3 "-O3 -fno-math-errno -fno-trapping-math"; do
            if ! have $compiler; then skip "the same bits: $compiler $level" "make setup-long installs it"
            elif have $emulator; then
                check "the same bits: $compiler $level" foreign_bits $emulator $compiler -std=c99 $flags $level
            else
                check "compiles: $compiler $level" $compiler -std=c99 $flags $level $house $exact -I. -c tests/bits.c \
                    -o "$work/bits.o"
                skip "the same bits: $compiler $level" "there is no $emulator"
            fi
        done
    done <<END
qemu-aarch64 aarch64-linux-gnu-gcc -static
qemu-s390x s390x-linux-gnu-gcc -static -fexcess-precision=fast
qemu-i386 i686-linux-gnu-gcc -static -msse2 -mfpmath=sse
wine x86_64-w64-mingw32-gcc -static
END
}

# Nothing but the headers that every compiler has itself, and no library: only what a compiler
# itself may call.
bare() {
    local compiler=$1 own
    own=$(echo '#include <stdint.h>' | $compiler -ffreestanding -E - |
        sed -n 's,^# 1 "\(.*\)/stdint.h".*,\1,p')
    $compiler -std=c99 -O2 $house $exact -ffreestanding -fno-math-errno -nostdlib -nostdinc -isystem "$own" -I. \
        -c tests/compile/bare.c -o "$work/bare.o" || return 1
    ! nm -u "$work/bare.o" | awk '{ print $2 }' |
        grep -vxE 'mem(cpy|set|move)|_GLOBAL_OFFSET_TABLE_'
}

# The header's own words, not some other error.
header_refuses() {
    if "$@" -I. -c tests/compile/alone.c -o "$work/alone.o" 2>"$work/error"; then return 1; fi
    cat "$work/error"
    grep -q 'error.*sss_resample.h needs \(IEEE\|float\) arithmetic' "$work/error"
}

check_refusals() { # COMPILERS FLAGS
    local compiler flag
    for compiler in $1; do
        for flag in $2; do
            if have $compiler; then check "$compiler $flag is refused" header_refuses $compiler $flag
            else skip "$compiler $flag is refused" "there is no $compiler"; fi
        done
    done
}
check_long_doubles() {
    if [ "$(uname -m)" = x86_64 ]; then
        check "floats computed as long doubles are refused" header_refuses gcc -std=c99 -mfpmath=387
    else skip "floats computed as long doubles are refused" "this is no x86"; fi
}

with_limit() {
    gcc -std=c99 -O1 $house $exact "$1" -I. tests/bits.c -o "$work/limit" -lm && "$work/limit"
}

check_opencl() { # STANDARD
    local with="clang -x cl -cl-std=$1 -Xclang -finclude-default-header -fsyntax-only"
    if $with /dev/null >/dev/null 2>&1; then
        check "OpenCL C as $1" $with -Wall -Wextra -Wshadow -Wundef -Werror -I. tests/compile/kernel.cl
    else
        skip "OpenCL C as $1" "no clang that knows it"
    fi
}

# The first ```c block of README.md, as it stands: whole if it has a main, else as a part.
readme_compiles() {
    awk '/^```c$/ { inside = 1; next } /^```/ { if (inside) exit } inside' README.md >"$work/readme.c"
    [ -s "$work/readme.c" ] || { echo "README.md has no block that begins with \`\`\`c" &&
        return 1; }
    if grep -qE '\bmain *\(' "$work/readme.c"; then
        gcc -std=c99 -O1 $house -I. "$work/readme.c" -o "$work/readme" -lm
    else
        gcc -std=c99 -O1 $house -I. -c "$work/readme.c" -o "$work/readme.o"
    fi
}

# The calls of one object file, by one compiler.
check_objects() {
    local compiler=$1 what
    for what in exports_nothing bare; do
        if have $compiler; then check "$what, $compiler" $what $compiler
        else skip "$what, $compiler" "there is no $compiler"; fi
    done
}

check_languages "gcc clang" c c99
check_languages "g++ clang++" c++ c++11
check "two files of one program" two_files
check "common names may be macros, C" no_common_name gcc c
check "common names may be macros, C++" no_common_name g++ c++
check_objects gcc
check "gcc -O0 computes: $reference" grep -qE '^[0-9a-f]{8} over [0-9]{6,} numbers$' <<<"$reference"
check_bits <<END
gcc c -std=c99 -O3 -march=native -fno-math-errno -fno-trapping-math
clang c -std=c99 -O2 -DSSS_LANES=1
clang++ c++ -std=c++11 -O3 -march=native
END
check_refusals gcc "-ffast-math -freciprocal-math"
check_opencl CL1.2
check "the example of README.md" readme_compiles

only_long_from_here
check_languages "gcc clang" c "c11 c17"
check_languages "g++ clang++" c++ "c++14 c++17 c++20"
check_objects clang
check_bits <<END
gcc c -std=c99 -O1
gcc c -std=c99 -O2
gcc c -std=c99 -O2 -fno-math-errno -fno-trapping-math
gcc c -std=c99 -O3
gcc c -std=c99 -O3 -march=native
gcc c -std=c99 -O3 -march=native -fno-math-errno -fno-trapping-math -DSSS_LANES=3
gcc c -std=c99 -O2 -DSSS_LANES=1
clang c -std=c99 -O0
clang c -std=c99 -O1
clang c -std=c99 -O2
clang c -std=c99 -O2 -fno-math-errno -fno-trapping-math
clang c -std=c99 -O3
clang c -std=c99 -O3 -march=native
clang c -std=c99 -O3 -march=native -fno-math-errno -fno-trapping-math
clang c -std=c99 -O3 -march=native -ffast-math -fno-finite-math-only
clang c -std=c99 -O3 -march=native -funsafe-math-optimizations
clang c -std=c99 -O3 -march=native -fassociative-math -fno-signed-zeros -fno-trapping-math
clang c -std=c99 -O3 -march=native -freciprocal-math
clang c -std=c99 -O3 -march=native -fapprox-func -fno-honor-nans
g++ c++ -std=c++11 -O0
g++ c++ -std=c++11 -O3 -march=native
clang++ c++ -std=c++11 -O0
END
check_processors
check_refusals gcc "-ffinite-math-only -Ofast"
check_refusals "clang g++ clang++" "-ffast-math -ffinite-math-only -Ofast"
check_long_doubles
for limit in SSS_MAX_EXITS=1 SSS_MAX_EXITS=8 SSS_MAX_CANDIDATES=16; do
    check "-D$limit compiles and works" with_limit -D$limit
done
check_opencl CL3.0
finish
