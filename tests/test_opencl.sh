#!/bin/bash
# render on OpenCL devices, in parts and interrupted; the kernels' text by other compilers and under
# a simulator. Run from the top of the repository, with BUILD naming where the programs are.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
mkdir -p "$POCL_CACHE_DIR"
render=$build/render
pfm=$build/tools/pfm
needs "$render" "$build/test_opencl" "$pfm"

# ---- The text of the kernels

syntax() { # STANDARD FILE OPTIONS
    local standard=$1 file=$2
    shift 2
    clang -x cl -cl-std=$standard -Xclang -finclude-default-header -Wall -Wextra -Wpedantic -Werror "$@" \
        -fsyntax-only "$file"
}

# What is embedded, as text again. In it the headers are no headers, so functions without use would
# be warned of.
embedded_text() {
    cat "$build/sss_cl_source.h" "$build/tracer_cl_source.h" |
        LC_ALL=C awk -F, '/^[0-9]/ { for (i = 1; i < NF; i++) printf "%c", $i }' >"$work/text.cl"
    grep -q '__kernel void tracer_lookups' "$work/text.cl" && ! grep -n '#include "' "$work/text.cl"
}

check_text() { # STANDARD
    if have clang; then
        check "$1: kernels" syntax $1 demos/common/tracer.cl -I.
        check "$1: embedded text" syntax $1 "$work/text.cl" -Wno-unused-function
    else
        skip "$1: kernels and embedded text" "there is no clang"
    fi
}

# ---- Parts of a picture

part() { # NAME OPTIONS: a picture of the slab, small and of no round size
    local name=$1
    shift
    "$render" --scene slab --size 23x17 --pfm "$work/$name.pfm" "$@"
}

merge() { # NAME PARTS...
    local name=$1 files=() file
    shift
    for file in "$@"; do files+=("$work/$file.pfm"); done
    "$render" --merge "${files[@]}" --pfm "$work/$name.pfm" --png "$work/$name.png"
}

note() { tail -c 80 "$work/$1.pfm" | LC_ALL=C grep -a -o 'samples .*'; }

halves() { # OPTIONS
    part whole --spp 16 "$@" && part a --spp 8 "$@" && part b --spp 8 --first-sample 8 "$@" ||
        return 1
    ! cmp -s "$work/a.pfm" "$work/b.pfm" || return 1
    merge halves a b && "$pfm" same "$work/whole.pfm" "$work/halves.pfm" && note halves || return 1
    [ "$(note halves)" = "$(note whole)" ] &&
        [ "$(note whole)" = "samples 0 16 seed 1 of slab burley" ]
}

# Uneven, in no order, one of them merged before, one of another seed.
uneven() {
    part whole --spp 13 && part a --spp 1 && part b --spp 5 --first-sample 1 &&
        part c --spp 7 --first-sample 6 ||
        return 1
    merge bc c b && merge all bc a && "$pfm" same "$work/whole.pfm" "$work/all.pfm" || return 1
    [ "$(note all)" = "$(note whole)" ] || return 1
    part d --spp 2 --seed 2 && merge two d whole && note two && [ "$(note two | wc -l)" -eq 2 ]
}

one_part() {
    part a --spp 3 --first-sample 5 && merge same a && cmp "$work/a.pfm" "$work/same.pfm"
}

refuse_parts() {
    part a --spp 4 && part b --spp 4 --first-sample 3 && part other --spp 1 --scene bear --seed 9 &&
        part size --spp 1 --size 17x23 --seed 9 &&
            part profile --spp 1 --profile dipole --seed 9 || return 1
    head -c $((14 + 23 * 17 * 12)) "$work/a.pfm" >"$work/bare.pfm"
    head -c 1000 "$work/a.pfm" >"$work/short.pfm"
    (cat "$work/bare.pfm" && echo "samples 0 0 seed 1 of slab burley") >"$work/none.pfm"
    local wrong
    for wrong in a b other size profile bare short none; do
        refuses 2 "$render" --merge a.pfm $wrong.pfm --pfm x.pfm || { echo "a with $wrong" &&
            return 1; }
    done
}

# ---- Ctrl-C

interrupt() { # OPTIONS: the picture holds what its note says, and is the picture of so many samples
    local code count lines watchdog
    "$render" --scene slab --size 23x17 --spp 1000000 "$@" --pfm "$work/stopped.pfm" >"$work/said" 2>"$work/error" &
    local job=$!
    (sleep 100 && kill -KILL $job) &
    watchdog=$!
    sleep 2
    kill -INT $job
    wait $job
    code=$?
    kill $watchdog
    cat "$work/said" "$work/error"
    count=$(note stopped | cut -d ' ' -f 3)
    lines=$(grep -c 'stopped after' "$work/error")
    echo "exit code $code, $count samples"
    [ $code -eq 130 ] && [ "$lines" -eq 1 ] && [ "$count" -ge 1 ] && [ "$count" -lt 1000000 ] ||
        return 1
    part again --spp "$count" "$@" && cmp "$work/stopped.pfm" "$work/again.pfm"
}

# ---- Devices

no_device() {
    export OCL_ICD_VENDORS=$work/nowhere
    "$render" --list-devices
    refuses 3 "$render" --device opencl --size 8x8 --spp 1 --pfm x.pfm || return 1
    refuses 3 "$render" --device opencl:all --size 8x8 --spp 1 --pfm x.pfm || return 1
    [ ! -e "$work/x.pfm" ] && part cpu --device cpu --spp 1
}

lists_devices() {
    "$render" --list-devices >"$work/list" && cat "$work/list"
    [ "$(head -n 1 "$work/list")" = cpu ] && sed -n 2p "$work/list" | grep -q '^opencl:0  .'
}

same_picture() { # SCENE METHOD OPTIONS
    local scene=$1 method=$2
    shift 2
    local with=(--scene $scene --method $method --size 23x17 --spp 3 --first-sample 2 "$@")
    "$render" "${with[@]}" --pfm "$work/cpu.pfm" --stats "$work/cpu.json" &&
        "$render" "${with[@]}" --device opencl --pfm "$work/device.pfm" --stats "$work/device.json" || return 1
    cmp "$work/cpu.pfm" "$work/device.pfm" || return 1
    [ "$(grep -o '"probes.*' "$work/cpu.json")" = "$(grep -o '"probes.*' "$work/device.json")" ]
}

# Without sources or the current folder's help.
works_anywhere() {
    cp "$render" "$work/renamed" && cd "$work" &&
        ./renamed --device opencl:0 --size 8x8 --spp 1 --png anywhere.png &&
        [ -s anywhere.png ]
}

several_devices() {
    part one --spp 40 --device cpu && part several --spp 40 --device opencl:all &&
        cmp "$work/one.pfm" "$work/several.pfm"
}

compares_on_device() {
    "$render" --compare --scene slab --size 23x17 --spp 1 --device opencl --png "$work/sheet.png" && [ -s "$work/sheet.png" ]
}

# Out of bounds and the like. The simulator does not know an annotation that inlining leaves, hence
# no inlining.
simulate() {
    OCL_ICD_VENDORS=$work/nowhere oclgrind --log "$work/log" --build-options "-cl-opt-disable -Dalways_inline=noinline" \
        "$build/test_opencl" --small || return 1
    [ ! -s "$work/log" ] || { cat "$work/log" && return 1; }
}

# Other code from the same text: one lane, as on devices that are not a CPU, or another way to join
# work-items.
other_code() {
    POCL_EXTRA_BUILD_FLAGS=-DSSS_LANES=1 "$build/test_opencl" --small &&
        POCL_WORK_GROUP_METHOD=cbs "$build/test_opencl" --small
}

check "the embedded text stands alone" embedded_text
check_text CL1.2
check "two halves make the whole" halves
check "no device: one line, exit code 3" eval "(no_device)"
# PoCL does not say that it cannot write to its folder.
names_cache() { # FOLDER
    POCL_CACHE_DIR=$1 timeout 60 "$render" --device opencl --size 8x8 --spp 1 --pfm "$work/x.pfm" 2>"$work/error"
    local code=$?
    cat "$work/error"
    echo "exit code $code"
    [ $code -ge 1 ] && [ $code -le 3 ] && grep -q "POCL_CACHE_DIR is $1\$" "$work/error" &&
        [ ! -e "$work/x.pfm" ]
}

device=$("$render" --list-devices | grep -q '^opencl:0 ' && echo 1)
exact=$device
! "$render" --device opencl --size 1x1 --spp 1 --pfm "$work/one.pfm" 2>&1 |
    grep -q 'does not round' || exact=
if [ "$device" ]; then
    check "--list-devices" lists_devices
    check "a program works from any folder" eval "(works_anywhere)"
    check "PoCL without its folder: told" names_cache /proc/nope
else
    skip "pictures on a device" "there is no OpenCL device"
fi
if [ "$exact" ]; then check "the device's picture, with all options" same_picture needles resampled --light-aware \
    --exits 3 --candidates 9 --independent --techniques disk,sphere,chord --profile better-dipole --seed 4294967295 &&
    check "the device's picture, with shared exits" same_picture bear shared --light-aware --share 8
else skip "the device's picture" "no device is IEEE-correct: test_opencl states by how much"; fi
check "two halves make the whole: shared exits" halves --share 8

only_long_from_here
check_text CL3.0
check "two halves make the whole: brute force" halves --method reference
check "parts of any size in any order" uneven
check "one part stays as it is" one_part
check "parts that do not go together" refuse_parts
check "samples up to the last number" part last --spp 2 --first-sample 4294967294
check "Ctrl-C" interrupt
[ "$device" ] || finish
index=$("$render" --list-devices | grep -c '^opencl:')
check "a number too high" refuses 2 "$render" --device opencl:$index --size 8x8 --spp 1 --pfm x.pfm
check "a number far too high" refuses 2 "$render" --device opencl:999999999999 --size 8x8 --spp 1 --pfm x.pfm
check "PoCL with a folder that is none: told" names_cache /dev/null
check "--compare on the device" compares_on_device
check "the same bits by other ways to compile" other_code
if have oclgrind; then check "a simulated device finds no fault" simulate
else skip "a simulated device finds no fault" "there is no oclgrind"; fi
[ "$exact" ] || finish
for scene in sphere slab corner needles bear; do
    for method in plain resampled shared reference; do
        check "$scene, $method: the device's picture" same_picture $scene $method
    done
done
for model in auto volume lambert; do
    check "$model: the device's picture" same_picture bear resampled --model $model --per-channel
done
check "tiles of other sides: the device's picture" same_picture corner shared --share 3
check "several devices at once" several_devices
POCL_DEVICES="pthread basic" check "several devices at once, of one runtime" several_devices
check "two halves make the whole: device" halves --device opencl
check "Ctrl-C on the device" interrupt --device opencl
finish
