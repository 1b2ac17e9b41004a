#!/bin/bash
# render does what its --help says: options, files, and the same mean by every method. Run from the
# top of the repository, after `make all`. SPDX-License-Identifier: MIT
set -u
. tests/check.sh
render=$build/render
pfm=$build/tools/pfm
needs "$render" "$pfm"

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
    "$pfm" check "$work/a.pfm" 24 20 || { echo "the PFM is wrong: $?" && return 1; }
    json_is "$work/a.json" $scene $method 2
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

repeats_in_threads() {
    OMP_NUM_THREADS=1 picture first "$@" && OMP_NUM_THREADS=3 picture second "$@" &&
        cmp "$work/first.pfm" "$work/second.pfm"
}

error_is_positive() {
    picture first --seed 7 && picture second --seed 8 --against "$work/first.pfm" || return 1
    cat "$work/second.json"
    grep -qE '"relative_mse": *[0-9]' "$work/second.json" || return 1
    ! grep -qE '"relative_mse": *0(\.0*)?[,}]' "$work/second.json"
}

wrong_size_is_refused() {
    picture first &&
        refuses 2 "$render" --size 20x24 --spp 1 --pfm x.pfm --against "$work/first.pfm"
}

not_a_picture_is_refused() {
    echo "this is no picture" >"$work/text.pfm"
    refuses 2 "$render" --size 20x24 --spp 1 --pfm x.pfm --against "$work/text.pfm"
}

# ---- The mean

# All methods estimate one integral, so the mean over the picture must be the same. Each method
# renders RUNS pictures with seeds of its own; the spread of their means gives the noise, and z is
# the difference from the reference over the noise of both. With 2 * RUNS - 2 = 46 degrees of
# freedom |t| > 5 has the probability 9e-6, so 24 comparisons raise a false alarm in 2.2e-4 of all
# choices of seeds, and these seeds are fixed.
RUNS=24
LIMIT=5

means() { # NAME SEED OPTIONS: one line for each picture
    local name=$1 seed=$2 i
    shift 2
    for ((i = 0; i < RUNS; i++)); do
        "$render" --size 40x44 --spp 20 --seed $((seed + i)) "$@" --pfm "$work/m.pfm" >/dev/null ||
            return 1
        "$pfm" mean "$work/m.pfm" || return 1
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

check "--help" help_tells "$render" "scene method profile spp size seed candidates exits techniques independent
    light-aware model tolerance share per-channel png pfm stats against first-sample device list-devices merge help"
for method in plain resampled shared reference; do
    check "bear, $method: PNG, PFM, JSON" all_files bear $method
done
check "all options of resampling" all_files slab resampled --candidates 5 --exits 2 --techniques \
    disk,tangents,sphere,chord --independent --light-aware
check "all options of sharing" all_files corner shared --share 3 --per-channel --model auto --tolerance 0.3
for model in volume lambert; do check "$model" all_files slab resampled --model $model; done
check "the same seed, the same picture" repeats --light-aware
check "the same seed, the same picture, however many threads" repeats_in_threads --share 8 --light-aware
check "no error against itself" error_is_zero

only_long_from_here
for scene in sphere slab corner needles; do
    for method in plain resampled reference; do
        check "$scene, $method: PNG, PFM, JSON" all_files $scene $method
    done
done
check "dipole" all_files bear resampled --profile dipole
check "better dipole" all_files bear reference --profile better-dipole
for method in plain resampled reference; do
    check "$method: the same seed, the same picture" repeats --method $method
    check "$method: another seed, another picture" differs --method $method
done
check "the greatest seed" picture first --seed 4294967295
check "an error against another" error_is_positive
check "another size is refused" wrong_size_is_refused
check "another kind of file is refused" not_a_picture_is_refused
for scene in bear slab; do
    check "$scene: pictures" means reference 1000 --scene $scene --method reference
    check "$scene: pictures" means plain 2000 --scene $scene --method plain
    check "$scene: pictures" means resampled 3000 --scene $scene --method resampled
    check "$scene: pictures" means aware 4000 --scene $scene --method resampled --light-aware
    check "$scene: pictures" means shared 5000 --scene $scene --method shared --light-aware
    for method in plain resampled aware shared; do
        check "$scene: $method has the mean of the reference" compare_means $method
        figures
    done
done
finish
