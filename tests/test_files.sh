#!/bin/bash
# What the programs write is whole or as it was, one output does not take another with it, and what
# they read is a picture. Run from the top of the repository, after `make all`.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
render=$build/render
needs "$render" "$build/noise" "$build/exit_points"

small="--scene slab --size 24x20 --spp 1"

# in_folder COMMAND...: runs it in a folder of its own, which is empty.
in_folder() {
    rm -rf "$work/folder"
    mkdir "$work/folder"
    (cd "$work/folder" && "$@")
}

# holds FILE...: these files are in the folder and no others.
holds() {
    echo "there is: $(echo *)"
    [ "$(printf '%s\n' * | sort)" = "$(printf '%s\n' "$@" | sort)" ]
}

# ends CODE LINES COMMAND...: its exit code, and how many lines of complaint.
ends() {
    local expected=$1 lines=$2 code
    shift 2
    timeout 60 "$@" 2>../error
    code=$?
    cat ../error
    echo "exit code $code"
    [ $code = "$expected" ] && [ "$(wc -l <../error)" = "$lines" ]
}

# ---- Outputs

one_fails() { # the other two are there
    ends 1 1 "$render" $small --stats /dev/full --png a.png --pfm a.pfm && holds a.png a.pfm &&
        grep -q 'cannot write /dev/full: No space left' ../error || return 1
    ends 1 1 "$render" $small --pfm /dev/full --png b.png --stats b.json && [ -s b.png ] &&
        [ -s b.json ]
}

# A file may grow to 2 KB here: the PFM has more, and what was there stays.
full_disk() {
    "$render" $small --pfm a.pfm && cp a.pfm before || return 1
    trap '' XFSZ
    ulimit -f 2
    ends 1 1 "$render" $small --seed 2 --pfm a.pfm --stats a.json && cmp a.pfm before &&
        holds a.json a.pfm before
}

links_are_followed() {
    mkdir there && touch there/old.pfm && ln -s there/old.pfm link.pfm &&
        ln -s there/new.pfm nowhere.pfm || return 1
    "$render" $small --pfm link.pfm && "$render" $small --pfm nowhere.pfm && [ -L link.pfm ] &&
        [ -L nowhere.pfm ] &&
        [ -s there/new.pfm ] && cmp there/old.pfm there/new.pfm
}

others_are_kept() {
    echo mine >a.png.part && echo mine >a.pfm.part && echo mine >a.json.part || return 1
    "$render" $small --png a.png --pfm a.pfm --stats a.json &&
        holds a.json a.json.part a.pfm a.pfm.part a.png a.png.part || return 1
    [ "$(cat *.part)" = $'mine\nmine\nmine' ]
}

rights_are_kept() {
    touch a.png && chmod 640 a.png && "$render" $small --png a.png &&
        [ "$(stat -c %a a.png)" = 640 ] || return 1
    (umask 027 && "$render" $small --png b.png) && [ "$(stat -c %a b.png)" = 640 ]
}

same_file() {
    ln -s a.png link
    ends 2 1 "$render" $small --png a.png --pfm a.png &&
        ends 2 1 "$render" $small --png a.png --pfm ./a.png &&
        ends 2 1 "$render" $small --png a.png --stats link &&
            ends 2 1 "$render" $small --pfm link --stats a.png &&
        holds link
}

# All are tried before the work, which would take hours.
tried_at_first() {
    local bad
    for bad in none/x . ""; do
        ends 2 1 "$render" --spp 100000 --png a.png --pfm b.pfm --stats "$bad" || return 1
        ends 2 1 "$render" --spp 100000 --pfm "$bad" --png a.png || return 1
    done
    [ "$(ls)" = "" ]
}

# Nobody reads: refused at once. Somebody does: all of it. Somebody leaves: the other output is
# there.
pipes() {
    mkfifo pipe && ends 2 1 "$render" $small --pfm pipe || return 1
    "$render" $small --pfm whole.pfm || return 1
    cat pipe >read.pfm &
    until_true "$render" $small --pfm pipe && wait $! && cmp whole.pfm read.pfm || return 1
    head -c 10 pipe >/dev/null &
    until_true reader_leaves && [ -s a.png ]
}
reader_leaves() { ends 1 1 "$render" $small --size 300x300 --pfm pipe --png a.png; }

# mesh, noise, exit_points: all write their picture the same way.
picture_beside() { # PROGRAM WORDS...
    local program=$1
    shift
    mkdir there && ln -s there/a.png link.png && echo mine >there/a.png.part || return 1
    "$build/$program" "$@" --headless --size 64x36 --png link.png && [ -L link.png ] &&
        [ -s there/a.png ] &&
        [ "$(cat there/a.png.part)" = mine ] && [ "$(ls there | wc -l)" = 2 ] || return 1
    mkfifo pipe && ends 2 1 "$build/$program" "$@" --headless --size 64x36 --png pipe
}

check "an output that fails leaves the others" in_folder one_fails
check "a full disk leaves the PFM that was there" in_folder full_disk
check "symbolic links are followed" in_folder links_are_followed
check "X.part of somebody else is kept" in_folder others_are_kept
check "a file keeps its rights, a new one has the usual" in_folder rights_are_kept
check "two outputs that are one file are refused" in_folder same_file
check "all outputs are tried before the work" in_folder tried_at_first
check "pipes" in_folder pipes
check "exit_points: link, X.part, pipe" in_folder picture_beside exit_points --candidates 1
check "noise: link, X.part, pipe" in_folder picture_beside noise --spp 1 --reference 2
if [ -x "$build/mesh" ]; then
    check "mesh: link, X.part, pipe" in_folder picture_beside mesh "$PWD/tests/data/tetrahedron.obj" --spp 2
else
    skip "mesh: link, X.part, pipe" "make setup installs Embree and assimp"
fi

# ---- Ctrl-C

# interrupted SECONDS COMMAND...: Ctrl-C after this time; the code is 130.
interrupted() {
    local seconds=$1 job code
    shift
    timeout --foreground 100 "$@" 2>../error &
    job=$!
    sleep $seconds
    kill -INT $(ps -o pid= --ppid $job)
    wait $job
    code=$?
    cat ../error
    echo "exit code $code"
    [ $code = 130 ] && grep -q ': stopped' ../error
}
stops_comparing() {
    interrupted 2 "$render" --compare --size 60x66 --spp 1000000 --png a.png --stats a.json &&
        [ -s a.png ] || return 1
    cat a.json
    grep -q '"method": "resampled, ' a.json && ! grep -q relative_mse a.json
}
stops() { # PROGRAM WORDS...
    interrupted 3 "$build/$@" --headless --size 64x36 --png a.png && [ -s a.png ]
}
check "Ctrl-C keeps what is compared by then" in_folder stops_comparing

# ---- PFM files

# pfm NAME SIZE SCALE VALUE NOTE: a picture of 4 x 4 pixels, all of which have these four bytes,
# little endian.
pfm() {
    local four=$4$4$4$4
    local row=$four$four$four
    printf "PF\n$2\n$3\n$row$row$row$row$5" >"$1.pfm"
}

one='\0\0\200\77' nan='\0\0\300\177' infinite='\0\0\200\377' note='samples 0 1 seed 1 of slab burley\n'

bad_pictures() { # as what render is to be measured against, and as a part of a picture
    local file
    pfm nan "4 4" -1.0 $nan "$note"
    pfm infinite "4 4" -1.0 $infinite "$note"
    pfm scale_nan "4 4" nan $one "$note"
    pfm scale_infinite "4 4" -inf $one "$note"
    pfm scale_0 "4 4" 0 $one "$note"
    pfm size_wraps "4294967300 4" -1.0 $one "$note"
    for file in nan infinite scale_nan scale_infinite scale_0 size_wraps; do
        ends 2 1 "$render" --size 4x4 --spp 1 --against $file.pfm --pfm x &&
            ends 2 1 "$render" --merge $file.pfm --pfm x &&
            ends 2 1 "$build/noise" --headless --against $file.pfm --png x ||
                { echo "it is $file" && return 1; }
    done
    pfm good "4 4" -1.0 $one "$note"
    "$render" --size 4x4 --spp 1 --against good.pfm --pfm x && "$render" --merge good.pfm --pfm x
}

bad_notes() {
    local words n=0
    for words in "0 1 seed 12345678901234567890123" "0 1 seed 4294967296" "0 1 seed -1" "12345678901234567890123 1 seed 1" \
        "0 12345678901234567890123 seed 1" "4294967295 2 seed 1"; do
        pfm a "4 4" -1.0 $one "samples $words of slab burley\n"
        ends 2 1 "$render" --merge a.pfm --pfm x || { echo "it is $words" && return 1; }
    done
    pfm a "4 4" -1.0 $one "$note\0more"
    ends 2 1 "$render" --merge a.pfm --pfm x || { echo "it is bytes that are no text" && return 1; }
    pfm a "4 4" -1.0 $one "samples 0 1 seed 4294967295 of slab burley\n" &&
        "$render" --merge a.pfm --pfm x
}

# 3,000 parts with gaps between them, and another that fits into one: what render says of them has
# 100 KB.
many_parts() {
    local i parts=()
    pfm part "4 4" -1.0 $one ""
    for ((i = 0; i < 3000; i++)); do
        pfm $i "4 4" -1.0 $one "samples $((2 * i)) 1 seed 1 of slab burley\n"
        parts+=($i.pfm)
    done
    pfm gap "4 4" -1.0 $one "samples 1 1 seed 1 of slab burley\n"
    "$render" --merge "${parts[@]}" --pfm all.pfm &&
        "$render" --merge all.pfm gap.pfm --pfm more.pfm &&
        "$render" --merge more.pfm --pfm again.pfm && cmp more.pfm again.pfm || return 1
    [ "$(tail -c +$(($(wc -c <part.pfm) + 1)) more.pfm | head -n 1)" = "samples 0 3 seed 1 of slab burley" ] &&
        ends 2 1 "$render" --merge more.pfm 2998.pfm --pfm x
}

# No error is defined against black.
black() {
    pfm black "4 4" -1.0 '\0\0\0\0' "$note"
    "$render" --size 4x4 --spp 1 --against black.pfm --stats a.json | grep "not defined" &&
        ! grep relative_mse a.json
}

pipes_in() {
    pfm good "4 4" -1.0 $one "$note" && mkfifo pipe || return 1
    ends 2 1 "$render" --size 4x4 --spp 1 --against pipe --pfm x &&
        ends 2 1 "$render" --merge pipe --pfm x &&
        ends 2 1 "$build/noise" --headless --against pipe --png x || return 1
    "$render" --size 4x4 --spp 1 --against <(sleep 1 && cat good.pfm) --pfm x
}

check "pictures with what is no number are refused" in_folder bad_pictures
check "notes with what is no sample are refused" in_folder bad_notes
check "a merge of 3,000 parts can be merged again" in_folder many_parts
check "black as the reference" in_folder black
check "pipes to read from" in_folder pipes_in

only_long_from_here
check "Ctrl-C keeps what noise has rendered" in_folder stops noise --spp 1000000
if [ -x "$build/mesh" ]; then
    check "Ctrl-C keeps what mesh has rendered" in_folder stops mesh "$PWD/tests/data/tetrahedron.obj" --spp 1000000
else
    skip "Ctrl-C keeps what mesh has rendered" "make setup installs Embree and assimp"
fi
finish
