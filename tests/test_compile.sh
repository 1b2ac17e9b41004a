#!/bin/bash
# The header compiles everywhere, and computes the same bits everywhere. Run from the top of the repository.
# SPDX-License-Identifier: MIT
set -u
house="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror"
exact="-ffp-contract=off"
. tests/check.sh

have() { command -v "$1" >/dev/null 2>&1; }

# One compiler, one standard: the header alone, twice, and used to the last function. The oldest standard of each
# language is compiled with -O3 too, which sees what the mere look does not warn of.
compile_all() {
    local compiler=$1 standard=$2 language=$3 how=-fsyntax-only
    local with="$compiler -x $language -std=$standard $house $exact -I."
    case $standard in c99 | c++11) how="-O3 -c -o $work/bits.o" ;; esac
    $with -fsyntax-only "$work/alone.c" && $with -fsyntax-only "$work/twice.c" && $with $how tests/bits.c
}

check_languages() {
    local compiler standard
    for compiler in gcc clang; do
        for standard in c99 c11 c17; do
            if have $compiler; then check "$compiler -std=$standard" compile_all $compiler $standard c
            else skip "$compiler -std=$standard" "there is no $compiler"; fi
        done
    done
    for compiler in g++ clang++; do
        for standard in c++11 c++14 c++17 c++20; do
            if have $compiler; then check "$compiler -std=$standard" compile_all $compiler $standard c++
            else skip "$compiler -std=$standard" "there is no $compiler"; fi
        done
    done
}

two_files() {
    gcc -std=c99 $house $exact -I. "$work/first.c" "$work/second.c" -o "$work/two" -lm && "$work/two"
}

# Neither -O0 nor -O2 leaves a symbol of the header in an object that does not use it.
exports_nothing() {
    local compiler=$1 level
    for level in O0 O2; do
        $compiler -x c -std=c99 -$level $exact -I. -c "$work/alone.c" -o "$work/alone.o" || return 1
        nm "$work/alone.o" | grep -v ' U _GLOBAL_OFFSET_TABLE_$' >"$work/symbols"
        cat "$work/symbols"
        [ ! -s "$work/symbols" ] || return 1
    done
}

# Of libm at most sqrtf (fabsf is an instruction). A compiler copies structures with memcpy and memset as it
# likes, and bits.c prints.
calls_only_sqrtf() {
    local compiler=$1 level
    local known='sqrtf|mem(cpy|set|move)|printf|fprintf|stderr|puts|fwrite|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail'
    for level in O0 O2 O3; do
        $compiler -x c -std=c99 -$level $exact -I. -c tests/bits.c -o "$work/bits.o" || return 1
        nm -u "$work/bits.o" | awk '{ print $2 }' >"$work/symbols"
        grep -qx sqrtf "$work/symbols" || [ $level != O0 ] || return 1
        if grep -vxE "$known" "$work/symbols"; then return 1; fi
    done
}

# bits_of COMPILER FLAGS...: the checksum, or nothing.
bits_of() { "$@" -I. tests/bits.c -o "$work/bits" -lm && "$work/bits"; }

same_bits() {
    local bits
    bits=$(bits_of "$@") || return 1
    echo "expected $reference, is $bits"
    [ -n "$bits" ] && [ "$bits" = "$reference" ]
}

check_bits() {
    local flags compiler language
    reference=$(bits_of gcc -std=c99 -O0 $exact 2>&1)
    check "gcc -O0 computes: $reference" grep -qE '^[0-9a-f]{8} over [0-9]{6,} numbers$' <<<"$reference"
    while read -r compiler language flags; do
        if ! have $compiler; then
            skip "the same bits: $compiler $flags" "there is no $compiler"
            continue
        fi
        check "the same bits: $compiler $flags" same_bits $compiler -x $language $flags $exact
    done <<END
gcc c -std=c99 -O2
gcc c -std=c99 -O2 -fno-math-errno -fno-trapping-math
gcc c -std=c99 -O3 -march=native
gcc c -std=c99 -O3 -march=native -fno-math-errno -fno-trapping-math
gcc c -std=c99 -O2 -DSSS_LANES=1
gcc c -std=c99 -O3 -march=native -fno-math-errno -fno-trapping-math -DSSS_LANES=3
gcc c -std=c99 -O1
gcc c -std=c99 -O3
clang c -std=c99 -O0
clang c -std=c99 -O1
clang c -std=c99 -O3
clang c -std=c99 -O2
clang c -std=c99 -O2 -fno-math-errno -fno-trapping-math
clang c -std=c99 -O3 -march=native
clang c -std=c99 -O3 -march=native -fno-math-errno -fno-trapping-math
g++ c++ -std=c++11 -O0
g++ c++ -std=c++11 -O3 -march=native
clang++ c++ -std=c++11 -O0
clang++ c++ -std=c++11 -O3 -march=native
END
}

# Another processor's or system's bits; only in the long run. Of the emulators wine is not asked for: it is large.
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
    [ -n "${LONG:-}" ] || return 0
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

# Nothing but the headers that every compiler has itself, and no library: only what a compiler itself may call.
bare() {
    local compiler=$1 own
    own=$(echo '#include <stdint.h>' | $compiler -ffreestanding -E - | sed -n 's,^# 1 "\(.*\)/stdint.h".*,\1,p')
    $compiler -std=c99 -O2 $house $exact -ffreestanding -fno-math-errno -nostdlib -nostdinc -isystem "$own" -I. \
        -c "$work/bare.c" -o "$work/bare.o" || return 1
    ! nm -u "$work/bare.o" | awk '{ print $2 }' | grep -vxE 'mem(cpy|set|move)|_GLOBAL_OFFSET_TABLE_'
}

# The header's own words, not some other error.
header_refuses() {
    if "$@" -I. -c "$work/alone.c" -o "$work/alone.o" 2>"$work/error"; then return 1; fi
    cat "$work/error"
    grep -q 'error.*sss_resample.h needs IEEE arithmetic' "$work/error"
}

check_refusals() {
    local compiler flag
    for compiler in gcc clang g++ clang++; do
        for flag in -ffast-math -ffinite-math-only -Ofast; do
            if have $compiler; then check "$compiler $flag is refused" header_refuses $compiler $flag
            else skip "$compiler $flag is refused" "there is no $compiler"; fi
        done
    done
    if [ "$(uname -m)" = x86_64 ]; then
        check "floats computed as long doubles are refused" header_refuses gcc -std=c99 -mfpmath=387
    else skip "floats computed as long doubles are refused" "this is no x86"; fi
}

with_limit() { gcc -std=c99 -O1 $house $exact "$1" -I. tests/bits.c -o "$work/limit" -lm && "$work/limit"; }

check_opencl() {
    local standard
    echo 'kernel void nothing(void) {}' >"$work/nothing.cl"
    for standard in CL1.2 CL3.0; do
        local with="clang -x cl -cl-std=$standard -Xclang -finclude-default-header -fsyntax-only"
        if $with "$work/nothing.cl" >/dev/null 2>&1; then
            check "OpenCL C as $standard" $with -Wall -Wextra -Wshadow -Wundef -Werror -I. "$work/kernel.cl"
        else
            skip "OpenCL C as $standard" "no clang that knows it"
        fi
    done
}

# The first ```c block of README.md, as it stands: whole if it has a main, else as a part.
readme_compiles() {
    awk '/^```c$/ { inside = 1; next } /^```/ { if (inside) exit } inside' README.md >"$work/readme.c"
    [ -s "$work/readme.c" ] || { echo "README.md has no block that begins with \`\`\`c" && return 1; }
    if grep -qE '\bmain *\(' "$work/readme.c"; then
        gcc -std=c99 -O2 $house -I. "$work/readme.c" -o "$work/readme" -lm
    else
        gcc -std=c99 -O2 $house -I. -c "$work/readme.c" -o "$work/readme.o"
    fi
}

write_sources() {
    printf '#include "sss_resample.h"\ntypedef int not_empty;\n' >"$work/alone.c"
    printf '#include "sss_resample.h"\n#include "sss_resample.h"\ntypedef int not_empty;\n' >"$work/twice.c"
    cat >"$work/first.c" <<'END'
#include "sss_resample.h"
int second(sss_medium *m);
int main(void) {
    sss_medium m;
    return second(&m) || !(sss_profile(&m, 0, 1.0f) > 0.0f);
}
END
    cat >"$work/second.c" <<'END'
#include "sss_resample.h"
int second(sss_medium *m);
int second(sss_medium *m) {
    const float albedo[3] = {0.5f, 0.5f, 0.5f}, length[3] = {1.0f, 1.0f, 1.0f};
    return sss_burley(m, albedo, length) != SSS_OK;
}
END
    cat >"$work/bare.c" <<'END'
#include "sss_resample.h"
int bare(const float *albedo, const float *length, const sss_vec3 *at, sss_exit *exits);
int bare(const float *albedo, const float *length, const sss_vec3 *at, sss_exit *exits) {
    sss_medium m;
    sss_plan plan;
    sss_need need;
    sss_resampler s;
    sss_probe probe;
    if (sss_burley(&m, albedo, length) != SSS_OK || sss_dipole(&m, albedo, length, 1.3f) != SSS_OK ||
        sss_better_dipole_from_albedo(&m, albedo, length, 1.3f) != SSS_OK)
        return 0;
    need.footprint = need.curvature_radius = need.shading_cost = sss_within(&m, 0, sss_profile(&m, 1, 1.0f));
    need.tolerance = need.footprint;
    need.hinted = 1;
    plan = sss_plan_for(&m, &need);
    if (sss_begin(&s, &m, &plan, at[0], at[1], 1u) != SSS_OK) return 0;
    while (sss_next_probe(&s, &probe)) sss_add_hit(&s, probe.origin, probe.direction, sss_intensity(&s, at[0], at[1]));
    return sss_finish(&s, exits);
}
END
    cat >"$work/kernel.cl" <<'END'
#include "sss_resample.h"
kernel void lookup(global const sss_medium *media, global const sss_vec3 *points, global sss_exit *out,
                   global float *numbers) {
    size_t i = get_global_id(0);
    const float albedo[3] = {0.9f, 0.5f, 0.1f}, length[3] = {1.0f, 0.5f, 0.1f};
    sss_medium m = media[i], own;
    sss_plan plan;
    sss_need need;
    sss_resampler s;
    sss_probe probe;
    sss_exit exits[SSS_MAX_EXITS];
    sss_entry group[3];
    float weight[3][3];
    int k, count;
    sss_result result = sss_burley(&own, albedo, length);
    if (result == SSS_OK) result = sss_burley_mfp(&own, albedo, length);
    if (result == SSS_OK) result = sss_dipole(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_better_dipole(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_dipole_from_albedo(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_better_dipole_from_albedo(&own, albedo, length, 1.3f);
    need.footprint = need.curvature_radius = need.shading_cost = need.tolerance = 1.0f;
    need.hinted = 0;
    plan = sss_plan_for(&own, &need);
    if (sss_begin_sample(&s, &m, &plan, points[0], points[1], sss_hash((uint)i, SSS_VERSION), 7u) != SSS_OK) return;
    while (sss_next_probe(&s, &probe)) sss_add_hit(&s, probe.origin, probe.direction, probe.length);
    count = sss_finish(&s, exits);
    for (k = 0; k < count; ++k) out[k] = exits[k];
    for (k = 0; k < 3; ++k) {
        group[k].position = points[k];
        group[k].medium = &own;
    }
    sss_share(&exits[0], group, 3, sss_is_shared(&own, 0, 0.1f), 0.1f, weight);
    sss_share_weight(&own, points[0], &exits[0], sss_share_density(&own, points[0], &exits[0]), weight[1]);
    numbers[3] = weight[0][0] + weight[1][0];
    numbers[0] = sss_profile(&m, 0, 1.0f) + sss_within(&own, 1, 2.0f);
    numbers[2] = sss_intensity(&s, points[0], points[1]);
    numbers[1] = (float)sss_result_string(result)[0];
}
END
}

write_sources
check_languages
check "two files of one program" two_files
for compiler in gcc clang; do
    if have $compiler; then
        check "no symbol from the header alone, $compiler" exports_nothing $compiler
        check "no call into libm but sqrtf, $compiler" calls_only_sqrtf $compiler
    else
        skip "no symbol from the header alone, $compiler" "there is no $compiler"
        skip "no call into libm but sqrtf, $compiler" "there is no $compiler"
    fi
done
for compiler in gcc clang; do
    if have $compiler; then check "no libc at all, $compiler" bare $compiler
    else skip "no libc at all, $compiler" "there is no $compiler"; fi
done
check_bits
check_processors
check_refusals
for limit in SSS_MAX_EXITS=1 SSS_MAX_EXITS=8 SSS_MAX_CANDIDATES=16; do
    check "-D$limit compiles and works" with_limit -D$limit
done
check_opencl
if [ -f README.md ]; then check "the example of README.md" readme_compiles
else skip "the example of README.md" "there is no README.md"; fi
finish
