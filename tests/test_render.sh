#!/bin/bash
# render does what its --help says: options, files, and the same mean by every method. Run from the top of the
# repository, with BUILD naming where the programs are. SPDX-License-Identifier: MIT
set -u
build=${BUILD:-build}
. tests/check.sh

render=$(cd "$build" 2>/dev/null && pwd)/render
needs "$render"

# ---- Options

help_works() {
    "$render" --help >"$work/help" 2>"$work/error" || return 1
    [ ! -s "$work/error" ] || return 1
    local option
    for option in scene method profile spp size seed candidates exits techniques independent light-aware png pfm \
        stats against first-sample device list-devices merge help; do
        grep -q -- "--$option" "$work/help" || { echo "--help says nothing of --$option" && return 1; }
    done
}

check_options() {
    check "--help" help_works
    while IFS= read -r words; do
        check "refused: $words" refuses 2 "$render" $words
    done <<'END'
--nonsense
nonsense
-x
--scene
--method
--profile
--spp
--size
--seed
--candidates
--exits
--techniques
--png
--pfm
--stats
--against
--scene nowhere
--scene Bear
--method none
--profile none
--spp 0
--spp -1
--spp 1.5
--spp many
--spp 1e3
--spp 99999999999999999999
--size 24
--size 24x
--size x24
--size 0x24
--size 24x-24
--size 24x24x24
--size 999999x1
--seed -1
--seed 4294967296
--seed one
--candidates 0
--candidates 257
--candidates few
--exits 0
--exits 5
--techniques none
--techniques disk,none
--techniques disk,
--techniques ,chord
--png no/such/directory/x.png --size 8x8 --spp 1
--pfm no/such/directory/x.pfm --size 8x8 --spp 1
--stats no/such/directory/x.json --size 8x8 --spp 1
--against no/such/file.pfm --pfm x.pfm --size 8x8 --spp 1
--first-sample
--first-sample -1
--first-sample 4294967295 --spp 2
--first-sample 4 --compare
--device
--device gpu
--device opencl:
--device opencl:x
--device opencl:-1
--device opencl:1x
--merge
--merge --pfm x.pfm
--merge no/such/file.pfm
--merge no/such/file.pfm --pfm x.pfm
--merge a.pfm --pfm x.pfm --spp 4
--merge a.pfm --merge b.pfm --pfm x.pfm
END
    check "refused: an empty scene" refuses 2 "$render" --scene ""
    check "refused: an empty list of techniques" refuses 2 "$render" --techniques ""
    check "refused: empty file names" refuses 2 "$render" --size 8x8 --spp 1 --pfm ""
}

# ---- Files

# pfm check FILE W H: a colour PFM of this size, all finite, not black in all. pfm mean FILE: three numbers.
write_tools() {
    cat >"$work/pfm.c" <<'END'
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
int main(int count, char **words) {
    int w = 0, h = 0, i, k, good = count > 2;
    double scale = 0, sum[3] = {0, 0, 0};
    unsigned char b[4];
    char note[8];
    FILE *f = good ? fopen(words[2], "rb") : NULL;
    if (!f || fscanf(f, "PF %d %d %lf", &w, &h, &scale) != 3 || fgetc(f) != '\n' || scale != -1.0) return 1;
    if (count > 4 && (w != atoi(words[3]) || h != atoi(words[4]))) return 2;
    for (i = 0; i < w * h; ++i) {
        for (k = 0; k < 3; ++k) {
            unsigned long bits;
            unsigned u;
            float x;
            if (fread(b, 1, 4, f) != 4) return 3;
            bits = b[0] | (unsigned long)b[1] << 8 | (unsigned long)b[2] << 16 | (unsigned long)b[3] << 24;
            u = (unsigned)bits;
            memcpy(&x, &u, 4);
            if (!(x - x == 0.0f)) return 4; /* negative is fair: the tracer subtracts what it expects */
            sum[k] += x;
        }
    }
    if (fread(note, 1, 8, f) != 8 || memcmp(note, "samples ", 8) != 0) return 5; /* what render says of itself */
    for (k = 0; k < 3; ++k) sum[k] /= (double)w * h;
    if (strcmp(words[1], "mean") == 0) printf("%.9g %.9g %.9g\n", sum[0], sum[1], sum[2]);
    return sum[0] + sum[1] + sum[2] > 0.0 ? 0 : 6;
}
END
    gcc -O1 "$work/pfm.c" -o "$work/pfm" && return
    echo "not ok the tools of this test compile"
    failed=1
    finish
}

bytes() { od -An -tx1 -v -j "$2" -N "$3" "$1" | tr -d ' \n'; }

# Signature, size in the first chunk, IEND at the end.
png_is() {
    local size
    size=$(wc -c <"$1")
    [ "$(bytes "$1" 0 16)" = 89504e470d0a1a0a0000000d49484452 ] || return 1
    [ "$(bytes "$1" 16 8)" = "$(printf '%08x%08x' "$2" "$3")" ] || return 1
    [ "$(bytes "$1" $((size - 12)) 12)" = 0000000049454e44ae426082 ]
}

json_is() { # FILE SCENE METHOD SPP
    local key number='-?[0-9.]+(e[-+][0-9]+)?'
    cat "$1"
    grep -q "\"scene\": *\"$2\"" "$1" && grep -q "\"method\": *\"$3\"" "$1" || return 1
    grep -q "\"spp\": *$4\b" "$1" || return 1
    for key in seconds probes shaded; do grep -qE "\"$key\": *$number[,}]" "$1" || return 1; done
    grep -qE "\"mean\": *\[$number, *$number, *$number\]" "$1" || return 1
    [ "$(head -c 1 "$1")" = "{" ] && [ "$(tail -c 2 "$1")" = "}" ] && ! grep -qiE 'nan|inf' "$1"
}

all_files() { # SCENE METHOD [OPTIONS]
    local scene=$1 method=$2
    shift 2
    "$render" --scene $scene --method $method --size 24x20 --spp 2 --png "$work/a.png" --pfm "$work/a.pfm" \
        --stats "$work/a.json" "$@" || return 1
    png_is "$work/a.png" 24 20 || { echo "the PNG is wrong" && return 1; }
    "$work/pfm" check "$work/a.pfm" 24 20 || { echo "the PFM is wrong: $?" && return 1; }
    json_is "$work/a.json" $scene $method 2
}

check_files() {
    local scene method
    for scene in sphere slab corner needles bear; do
        for method in plain resampled reference; do
            check "$scene, $method: PNG, PFM, JSON" all_files $scene $method
        done
    done
    check "dipole" all_files bear resampled --profile dipole
    check "better dipole" all_files bear reference --profile better-dipole
    check "all options of resampling" all_files slab resampled --candidates 5 --exits 2 --techniques \
        disk,tangents,sphere,chord --independent --light-aware
}

picture() { # NAME [OPTIONS]
    local name=$1
    shift
    "$render" --scene slab --size 24x20 --spp 2 "$@" --pfm "$work/$name.pfm" --stats "$work/$name.json"
}

# Header and pixels; behind them stands the seed.
same() { cmp -n $((14 + 24 * 20 * 12)) "$work/first.pfm" "$work/$1.pfm"; }

repeats() { # the same seed twice, and on one thread
    picture first --seed 7 "$@" && picture second --seed 7 "$@" && same second || return 1
    OMP_NUM_THREADS=1 picture third --seed 7 "$@" && same third || return 1
    OMP_NUM_THREADS=5 picture fourth --seed 7 "$@" && same fourth
}

differs() {
    picture first --seed 7 "$@" && picture second --seed 8 "$@" && ! same second
}

error_is_zero() {
    picture first --seed 7 && picture second --seed 7 --against "$work/first.pfm" || return 1
    cat "$work/second.json"
    grep -qE '"relative_mse": *0(\.0*)?[,}]' "$work/second.json"
}

error_is_positive() {
    picture first --seed 7 && picture second --seed 8 --against "$work/first.pfm" || return 1
    cat "$work/second.json"
    grep -qE '"relative_mse": *[0-9]' "$work/second.json" || return 1
    ! grep -qE '"relative_mse": *0(\.0*)?[,}]' "$work/second.json"
}

wrong_size_is_refused() {
    picture first && refuses 2 "$render" --size 20x24 --spp 1 --pfm x.pfm --against "$work/first.pfm"
}

not_a_picture_is_refused() {
    echo "this is no picture" >"$work/text.pfm"
    refuses 2 "$render" --size 20x24 --spp 1 --pfm x.pfm --against "$work/text.pfm"
}

check_repetition() {
    local method
    for method in plain resampled reference; do
        check "$method: the same seed, the same picture" repeats --method $method
        check "$method: another seed, another picture" differs --method $method
    done
    check "light-aware: the same seed, the same picture" repeats --light-aware
    check "the greatest seed" picture first --seed 4294967295
    check "no error against itself" error_is_zero
    check "an error against another" error_is_positive
    check "another size is refused" wrong_size_is_refused
    check "another kind of file is refused" not_a_picture_is_refused
}

# ---- The mean

# All methods estimate one integral, so the mean over the picture must be the same. Each method renders RUNS
# pictures with seeds of its own; the spread of their means gives the noise, and z is the difference from the
# reference over the noise of both. With 2 * RUNS - 2 = 46 degrees of freedom |t| > 5 has the probability 9e-6, so
# 18 comparisons raise a false alarm in 1.6e-4 of all choices of seeds, and these seeds are fixed.
RUNS=24
LIMIT=5

means() { # NAME SEED OPTIONS: one line for each picture
    local name=$1 seed=$2 i
    shift 2
    for ((i = 0; i < RUNS; i++)); do
        "$render" --size 40x44 --spp 20 --seed $((seed + i)) "$@" --pfm "$work/m.pfm" >/dev/null || return 1
        "$work/pfm" mean "$work/m.pfm" || return 1
    done >"$work/$name.means"
}

compare_means() { # NAME
    awk -v limit=$LIMIT -v runs=$RUNS '
        {
            f = FILENAME == ARGV[1]
            n[f]++
            for (c = 1; c <= 3; c++) {
                s[f, c] += $c
                q[f, c] += $c * $c
            }
        }
        END {
            bad = n[0] != runs || n[1] != runs
            for (c = 1; c <= 3; c++) {
                error = 0
                for (f = 0; f < 2; f++) {
                    m[f] = s[f, c] / n[f]
                    error += (q[f, c] / n[f] - m[f] * m[f]) / (n[f] - 1)
                }
                z = (m[0] - m[1]) / sqrt(error)
                printf "channel %d: reference %.6f, here %.6f, %+.3f %%, z %.2f; ", c, m[1], m[0],
                       100 * (m[0] / m[1] - 1), z
                printf "the limit is a bias of %.2f %%\n", 100 * limit * sqrt(error) / m[1]
                if (!(z <= limit && z >= -limit)) bad = 1
            }
            exit bad
        }' "$work/reference.means" "$work/$1.means"
}

check_means() {
    local scene
    for scene in bear slab; do
        check "$scene: pictures" means reference 1000 --scene $scene --method reference
        check "$scene: pictures" means plain 2000 --scene $scene --method plain
        check "$scene: pictures" means resampled 3000 --scene $scene --method resampled
        check "$scene: pictures" means aware 4000 --scene $scene --method resampled --light-aware
        for method in plain resampled aware; do
            check "$scene: $method has the mean of the reference" compare_means $method
            sed 's/^/    /' "$work/out"
        done
    done
}

write_tools
check_options
check_files
check_repetition
check_means
finish
