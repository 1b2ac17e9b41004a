#!/bin/bash
# exit_points and noise: pictures without a display, and real windows on a display of this test's
# own, driven by keys and mouse. In the long run the programs are built here with AddressSanitizer,
# which looks for leaks when they end. Run from the top of the repository after `make all`.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh
pixels=$build/tools/pixels
needs "$build/exit_points" "$build/noise" "$pixels"
programs=$build # where those are that are looked at: later the ones with AddressSanitizer

# ---- The programs with AddressSanitizer

# The libraries of others that keep memory to the end. They must stay loaded for their names to be
# known then.
write_suppressions() {
    printf 'leak:%s\n' libGLX_mesa swrast_dri libOSMesa libOpenCL libpocl libLLVM >"$work/leaks"
    export LSAN_OPTIONS=suppressions=$work/leaks:print_suppressions=0
    export ASAN_OPTIONS=use_sigaltstack=0:exitcode=99 # PoCL gives its threads a signal stack of their own
}

checked="gcc -std=c99 -O1 -g1 -fsanitize=address -ffp-contract=off -fno-math-errno -fno-trapping-math -fopenmp -I.
    -I$build"
build_checked() {
    $checked demos/exit_points.c tests/tools/keep_loaded.c -o "$work/exit_points" -lglfw -ldl -lstb -lm &&
        $checked demos/noise.c cl/sss_cl.c tests/tools/keep_loaded.c -o "$work/noise" -lglfw -ldl -lOpenCL -lstb -lm
}

# ---- Options

no_display() {
    refuses 3 env -u DISPLAY -u WAYLAND_DISPLAY "$build/$1" && grep -q -- "--headless" "$work/error"
}

no_mesa() {
    gcc -std=c99 -O0 -I. -DCANVAS_OSMESA='"libthere_is_none.so"' demos/exit_points.c -o "$work/blind" -lglfw -ldl -lstb -lm &&
        refuses 3 "$work/blind" --headless --png x.png && grep -q libosmesa6 "$work/error"
}

# ---- Pictures without a display

# At most this many of 10000 pixels may differ by more than 24 of 255. The content is the same bits
# everywhere: what may differ is the edges of glyphs and lines by another OpenGL's rounding, and the
# digits of the seconds that noise shows.
LIMIT=60

small_exit_points() {
    timeout 60 "$programs/exit_points" --headless --size 480x270 --png "$work/$1.png" --seed "$2"
}
small_noise() {
    timeout 60 "$programs/noise" --headless --size 320x180 --spp 2 --reference 4 --png "$work/noise.png"
}

# as_committed NAME X Y W H: one part of the picture, so that what is small in the whole counts.
# `make test-pictures` makes the committed pictures anew.
as_committed() {
    local name=$1 differ
    shift
    differ=$("$pixels" differ "$work/$name.png" "tests/data/$name.png" "$@") || return 1
    echo "$differ of 10000 pixels differ, the limit is $LIMIT"
    [ "$differ" -le $LIMIT ]
}

check_pictures() {
    check "exit_points draws without a display" small_exit_points exit_points 1
    check "exit_points: the committed points" as_committed exit_points 19 55 455 113
    check "exit_points: the committed histograms" as_committed exit_points 19 188 455 47
    check "exit_points: the committed texts" as_committed exit_points
    check "noise draws without a display" small_noise
    check "noise: the committed pictures" as_committed noise 8 24 150 130
    check "noise: the committed errors" as_committed noise 162 24 150 130
    check "noise: the committed texts" as_committed noise
}

# The first half of a picture is not a picture: what was there stays, and nothing else is left.
keeps_what_was() {
    local code=0
    mkdir "$work/kept" && cp "$work/exit_points.png" "$work/kept/a.png" || return 1
    (trap '' XFSZ && ulimit -f 16 && cd "$work/kept" &&
        exec "$build/exit_points" --headless --size 480x270 --seed 2 --png a.png) >"$work/plain_output" 2>"$work/error"
    code=$?
    cat "$work/error" "$work/plain_output"
    ls "$work/kept"
    [ $code = 1 ] && [ "$(wc -l <"$work/error")" = 1 ] && [ ! -s "$work/plain_output" ] &&
        [ "$(ls "$work/kept")" = a.png ] && cmp "$work/kept/a.png" "$work/exit_points.png"
}
full_device() {
    ln -s /dev/full "$work/full.png" &&
        refuses 1 "$build/exit_points" --headless --size 480x270 --png full.png &&
        [ -L "$work/full.png" ] && [ -c /dev/full ]
}

# The sheet has 1280 x 720 units or more. Its panes begin 52 units from the left and end 18 from the
# right, with frames 1 and 2 wide; a pixel may be half covered. The object is as high and as wide as
# at 960x540, in units of 0.75 pixels, times `size`: how much larger the square is that fits into
# the pane. Each end of it is seen to a pixel, here and there.
keeps_shape() { # WIDTH HEIGHT
    local picture=$work/$1x$2.png
    "$build/exit_points" --headless --still --size $1x$2 --png "$picture" || return 1
    layout=$(awk -v w=$1 -v h=$2 'BEGIN {
        unit = w / 1280 < h / 720 ? w / 1280 : h / 720; across = (w / unit - 142) / 5; down = h / unit - 418
        size = across < 0.75 * down ? across : 0.75 * down
        printf "%d %d %d ", 0, 200 * unit, 100 * unit
        printf "%d %d %d %d %f %f", (76 + 2 * across) * unit + 2, 146 * unit + 2, across * unit - 4, down * unit - 4, unit, size }')
    set -- $layout $1
    echo "$("$pixels" extent "$picture" $1 $2 ${10} $3)" "$("$pixels" extent "$picture" $4 $5 $6 $7)" \
        $8 $9 ${10} >"$work/extent"
    [ -f "$work/extent_at_first" ] || cp "$work/extent" "$work/extent_at_first"
    awk 'function off(name, is, wanted, most) {
            printf "%s: %.1f, not %.1f\n", name, is, wanted
            if (!(is - wanted <= most && wanted - is <= most)) bad = 1
        }
        NR == 1 { wide = ($7 - $5 + 1) / $9 / $10; high = ($8 - $6 + 1) / $9 / $10; first = $9 }
        NR == 2 {
            most = 2 + 2 * $9 / first
            off("left of the panes", $1, 51 * $9, 1)
            off("right of the panes", $11 - 1 - $3, 16 * $9, 1)
            off("width of the object", $7 - $5 + 1, wide * $9 * $10, most)
            off("height of the object", $8 - $6 + 1, high * $9 * $10, most)
        }
        END { exit bad }' "$work/extent_at_first" "$work/extent"
}

repeats() { small_exit_points again 1 && cmp "$work/exit_points.png" "$work/again.png"; }
other_seed() {
    small_exit_points other 2 &&
        [ "$("$pixels" differ "$work/exit_points.png" "$work/other.png")" -gt $LIMIT ]
}

# ---- Windows

screen() { cp "$work/Xvfb_screen0" "$work/$1.xwd"; }
opens() { # TITLE PROGRAM OPTIONS
    local title=$1 program=$2
    shift 2
    "$programs/$program" --size 960x540 --png "$work/saved.png" "$@" >"$work/said" 2>&1 8<&- 9<&- &
    running=$!
    until_true finds_window "^$title\$" || { echo "there is no window: $(cat "$work/said")" &&
        return 1; }
    until_true has_size 960x540 || { echo "it has another size: $geometry" && return 1; }
    until_true shows_text || { echo "no title is there: $bright bright pixels" && return 1; }
}
has_size() {
    geometry=$(xdotool getwindowgeometry "$window" 2>&1) && [[ $geometry == *"Geometry: $1"* ]]
}
shows_text() {
    screen now && bright=$("$pixels" bright "$work/now.xwd" 0 10 960 30) && [ "$bright" -gt 200 ]
}

# Keeps a frame that is drawn to its end in the rectangle X Y W H; where frames follow each other
# there, any of them.
drawn() {
    screen before && sleep 0.1 && screen now
    [ "$("$pixels" differ "$work/before.xwd" "$work/now.xwd" "$@")" = 0 ]
}
before() { tries=10 until_true drawn "$@" || true; }

# keys_change KEYS X Y W H: after these keys at least MANY of 10000 pixels of the rectangle are
# others.
changed() {
    screen now && differ=$("$pixels" differ "$work/before.xwd" "$work/now.xwd" "$@") &&
        [ "$differ" -ge ${many:-30} ]
}
changes() {
    until_true changed "$@" || { echo "at $*: $differ of 10000 pixels have changed" && return 1; }
}
keys_change() {
    local keys=$1
    shift
    before "$@"
    xdotool key $keys && changes "$@"
}

same_as() { # FILE X Y W H: the screen shows what the file has there
    screen now
    differ=$("$pixels" differ "$work/now.xwd" "$@")
    [ "$differ" -le $LIMIT ]
}
# It shows that, and no bit of it changes for a second. On the way there it may come within the
# limit and leave it again: 60 of 10000, then 79, then 5.
ends_as() {
    local i
    same_as "$@" || return 1
    screen final
    for ((i = 0; i < 10; i++)); do
        sleep 0.1
        screen now
        cmp -s "$work/final.xwd" "$work/now.xwd" || return 1
    done
}
comes_to() { # FILE X Y W H, when all lookups are done
    tries=900 until_true ends_as "$@" ||
        { echo "$differ of 10000 pixels differ from $1, or it never rests" && return 1; }
}

# A key may be lost where no window manager gives the window its focus, so it has a second try.
said_wrote() { grep -c '^wrote ' "$work/said"; }
wrote_more_than() { [ "$(said_wrote)" -gt "$1" ]; }
saves() { # SIZE
    local size wrote=$(said_wrote)
    rm -f "$work/saved.png"
    xdotool key w
    tries=150 until_true wrote_more_than $wrote || { echo "W is not heard at first" &&
        xdotool key w; }
    until_true wrote_more_than $wrote || { echo "W is not heard: $(cat "$work/said")" && return 1; }
    size=$("$pixels" size "$work/saved.png")
    [ "$size" = "$1" ] || { echo "the picture has $size, not $1" && return 1; }
}

# The program ends with this code; 0 says that AddressSanitizer found nothing either.
ends() {
    until_true gone || { echo "it does not end" && kill $running; }
    wait $running
    local code=$?
    cat "$work/said"
    echo "exit code $code"
    [ $code = "$1" ]
}
closes() { xdotool key "$1" && ends 0; }

# The panes lie in y 110..335 of 960x540; the first in x 39..209, the last in x 775..946, the keys
# below y 495.
comes_back() { xdotool key $1 && comes_to "$work/960x540.png" 0 0 960 488; }

ring_at() {
    screen now && bright=$("$pixels" bright "$work/now.xwd" $(($1 - 8)) $(($2 - 8)) 17 17) &&
        [ "$bright" -ge 12 ]
}
click_moves_entry() {
    ! ring_at 110 160 || { echo "a ring is there before: $bright bright pixels" && return 1; }
    xdotool mousemove 110 160 click 1
    until_true ring_at 110 160 || { echo "no ring in the first pane: $bright bright pixels" &&
        return 1; }
    until_true ring_at 847 160 || { echo "no ring in the last pane: $bright bright pixels" &&
        return 1; }
}

drag() {
    xdotool mousemove $1 $2 mousedown ${5:-1} mousemove $((($1 + $3) / 2)) $2 mousemove $3 $4 mouseup ${5:-1}
}
drag_turns() {
    before 39 110 170 225
    drag 45 130 75 135 && many=100 changes 39 110 170 225
}
right_drag_turns() {
    before 39 110 170 225
    drag 110 230 150 230 3 && many=100 changes 39 110 170 225
}
wheel_zooms() {
    before 39 110 170 225
    xdotool mousemove 110 230 click 4 click 4 && many=100 changes 39 110 170 225
}
click_on_key() {
    before 39 110 170 225
    xdotool mousemove 590 526 click 1 && changes 39 110 170 225 || return 1
    before 39 110 170 225
    xdotool click 1 && changes 39 110 170 225
}
turns_by_itself() {
    xdotool key space
    screen before
    many=100 changes 39 110 170 225 && xdotool key space
}
resizes() {
    xdotool windowsize "$window" 1200 600 && sleep 0.5 && tries=3 until_true saves 1200x600 ||
        return 1
    bright=$("$pixels" bright "$work/saved.png" 0 10 1200 36)
    echo "$bright bright pixels in the title"
    [ "$bright" -gt 200 ]
}
# The same picture as without a display, whose layout is checked above: all but the keys.
resizes_whole() { # WIDTH HEIGHT ROWS
    xdotool windowsize "$window" $1 $2
    comes_to "$work/$1x$2.png" 0 0 $1 $3
}

# Writes into a pipe that nobody empties: the writer has to wait, whatever the machine's speed. The
# first bytes of the picture tell that it has begun; the name is free for the next picture then, and
# the window must go on meanwhile.
wrote_times() { [ "$(said_wrote)" = "$1" ]; }
stall_writer() { # KEYS, which the program finds all at once
    rm -f "$work/saved.png" && mkfifo "$work/saved.png" && exec 9<>"$work/saved.png" &&
        kill -STOP $running && xdotool key "$@" && kill -CONT $running &&
        timeout 30 head -c 8 <&9 >"$work/stalled.png" && rm "$work/saved.png" &&
            exec 8</proc/self/fd/9 && exec 9>&-
}
drain_writer() {
    timeout 30 cat <&8 >>"$work/stalled.png"
    local code=$?
    exec 8<&-
    echo "the pipe had $(wc -c <"$work/stalled.png") bytes, code $code"
    [ $code = 0 ] && [ "$("$pixels" size "$work/stalled.png")" = 960x540 ] &&
        [ "$(tail -c 8 "$work/stalled.png" | head -c 4)" = IEND ]
}
writes_beside_the_window() { # compared are the panes: the histograms may still grow
    local before=$(said_wrote)
    before 39 110 907 225
    stall_writer w p || { echo "the writer does not begin" && return 1; }
    changes 39 110 907 225 || { echo "the window waits for the writer" && return 1; }
    xdotool key w
    keys_change p 39 110 907 225 || { echo "the window waits with the second picture" && return 1; }
    wrote_times $before && [ ! -e "$work/saved.png" ] || { echo "told too early" && return 1; }
    drain_writer || return 1
    until_true wrote_times $((before + 2)) || { echo "not two more: $(cat "$work/said")" &&
        return 1; }
    [ "$("$pixels" size "$work/saved.png")" = 960x540 ] && [ ! -e "$work/saved.png.part" ] ||
        { ls -l "$work"/saved* && return 1; }
    [ "$("$pixels" differ "$work/stalled.png" "$work/saved.png" 39 110 907 225)" -ge 30 ] &&
        until_true same_as "$work/stalled.png" 0 0 960 340 ||
            { echo "not the two pictures that were shown" && return 1; }
}
write_error_is_told() {
    rm -f "$work/saved.png" && ln -s /dev/full "$work/saved.png" && xdotool key w &&
        until_true grep -q '^exit_points: cannot write .*saved.png: ' "$work/said"
    local told=$?
    [ $told = 0 ] || cat "$work/said"
    rm "$work/saved.png"
    return $told
}
# Q while a picture is under way: the program ends when that is written.
closing_loses_nothing() {
    stall_writer w || { echo "the writer does not begin" && return 1; }
    xdotool key q
    sleep 0.5
    kill -0 $running || { echo "it ends without the picture" && return 1; }
    drain_writer || return 1
    until_true gone || { echo "it does not end" && return 1; }
    tail -n 2 "$work/said"
    tail -n 1 "$work/said" | grep -q '^wrote '
}

# 480x270 on a screen of twice the usual density is the picture of 960x540, pixel by pixel: text too
# is cut for them.
opens_dense() {
    "$build/tools/x11" density 192 && opens "exit points" exit_points --size 480x270 --still &&
        comes_to "$work/960x540.png" 0 0 960 488 && saves 960x540 || return 1
    differ=$("$pixels" differ "$work/saved.png" "$work/960x540.png" 0 0 960 488)
    echo "$differ of 10000 pixels of the saved picture differ, the limit is $LIMIT"
    [ "$differ" -le $LIMIT ]
}
closed_by_its_button() {
    "$build/tools/x11" close "$window"
    ends 0
}
# No limit on it: on a machine that others use, it says as much of them.
tell_wait() { echo "    $1, with AddressSanitizer: $(grep '^the window went' "$work/said")"; }

check_exit_points() {
    check "exit_points opens a window" opens "exit points" exit_points --still
    check "the window shows what the headless picture shows" resizes_whole 960 540 488
    check "a wide window too" resizes_whole 1200 600 542
    check "a tall window too" resizes_whole 600 780 747
    check "and the first size again" resizes_whole 960 540 488
    check "] changes the dmfp" keys_change bracketright 39 376 907 92
    check "[ brings back all that was" comes_back bracketleft
    check "a click moves the entry" click_moves_entry
    check "dragging beside the object turns it" drag_turns
    check "so does the right button" right_drag_turns
    check "the wheel zooms" wheel_zooms
    check "a click on the key P in the list is that key" click_on_key
    check "P shows probes" keys_change p 39 110 907 225
    check "P again shows points" keys_change p 39 110 907 225
    check "+ changes the candidates" keys_change plus 775 70 170 20
    check "- changes them back" keys_change minus 775 70 170 20
    check "1 changes the techniques" keys_change 1 578 90 170 15
    check "F changes the profile" keys_change f 39 376 907 92
    check "S changes the scene" keys_change s 39 110 907 225
    check "space turns the object" turns_by_itself
    check "W saves what the window shows" saves 960x540
    check "the window goes on while pictures are written" writes_beside_the_window
    check "a picture that cannot be written: one clear line" write_error_is_told
    check "Q ends it when its last picture is written" closing_loses_nothing
    check "its exit code tells of the lost picture, and of no leak" ends 1
    tell_wait exit_points
    check "a dense screen gets as many pixels, and sharp text" opens_dense
    check "the window's own button closes it, without a leak" closed_by_its_button
    "$build/tools/x11" density 96
}

# The line is white from y 72 to 461: the pictures lie in x 24..474, the errors in x 486..936.
divider_at() {
    screen now && bright=$("$pixels" bright "$work/now.xwd" $(($1 - 2)) 90 5 150) &&
        [ "$bright" -ge 250 ]
}
no_divider_at() { ! divider_at $1; }
comes_true() { until_true "$@" || { echo "not $*: $bright bright pixels" && return 1; }; }
divider_moves() {
    comes_true divider_at 249 && drag 249 300 130 310 && comes_true divider_at 130 &&
        comes_true divider_at 592 &&
        comes_true no_divider_at 249 && drag 592 300 711 310 && comes_true divider_at 249
}
captions_fill() {
    screen now && bright=$("$pixels" bright "$work/now.xwd" 24 465 200 20) && [ "$bright" -gt 60 ]
}
resumes() { changes 0 463 960 50; } # the numbers go on

# Opening takes a while, compiling at first long; then the numbers go on, by the device.
device_opens() {
    xdotool key d
    tries=600 until_true grep -q '^device: ' "$work/said" || { cat "$work/said" && return 1; }
    screen before
    changes 0 463 480 50
}

check_noise() {
    check "noise opens a window" opens noise noise
    check "the divider follows the mouse, in both views" divider_moves
    check "the captions are there" comes_true captions_fill
    check "T changes the price" keys_change t 0 8 960 30
    check "L tells of the light" keys_change l 300 72 174 22
    check "+ changes the candidates" keys_change plus 0 510 960 30
    check "F changes the profile" keys_change f 0 510 960 30
    many=1000 check "S changes the scene" keys_change s 24 72 450 390
    screen before
    check "rendering goes on" resumes
    if [ "$("$build/render" --list-devices | grep -c ^opencl)" -gt 0 ]; then check "D opens an OpenCL device" device_opens
    else skip "D opens an OpenCL device" "there is none"; fi
    check "W saves what the window shows" saves 960x540
    check "a window of another size is filled" resizes
    check "Escape ends it, without a leak" closes Escape
    tell_wait noise
}

check_briefly() { # PROGRAM KEY RECTANGLE: a window, a key, a picture, the end
    check "$1 opens a window" opens "${1/_/ }" $1
    check "the key $2 changes what it shows" keys_change $2 $3 $4 $5 $6
    check "W saves what the window shows" saves 960x540
    check "Q ends it" closes q
}

check "exit_points --help" help_tells "$build/exit_points" "scene profile candidates seed size png headless help
    dmfp-scale techniques turn still probes"
check "noise --help" help_tells "$build/noise" "scene profile candidates seed size png headless help
    light-aware share same-time device against spp reference"
for program in exit_points noise; do check "$program without a display: one clear line" no_display $program; done
check_pictures
if start_display; then
    check_briefly exit_points s 39 110 907 225
    check_briefly noise s 24 72 450 390
else
    skip "windows" "make setup installs Xvfb and xdotool"
fi

only_long_from_here
check "the tool that plays the desktop is built" make -s build/tools/x11
check "without OSMesa: one clear line" no_mesa
write_suppressions
check "both build with AddressSanitizer" build_checked
programs=$work
check_pictures
check "exit_points: the same picture twice" repeats
check "exit_points: another seed, another picture" other_seed
check "a write that fails keeps what was there" keeps_what_was
check "a full device: one clear line" full_device
for size in "960 540" "1200 600" "600 780"; do
    check "panes inside and the object's shape kept, ${size/ / x }" keeps_shape $size
done
if [ "${xvfb:-}" ]; then
    check_exit_points
    check_noise
fi
finish
