#!/bin/bash
# exit_points and noise: options, pictures without a display, and real windows on a display of this test's own, driven
# by keys and mouse. The programs are built here with AddressSanitizer, which looks for leaks when they end. Run from the
# top of the repository after `make all`, with BUILD naming where the programs are. SPDX-License-Identifier: MIT
set -u
build=$(cd "${BUILD:-build}" 2>/dev/null && pwd) || build=none
. tests/check.sh
export POCL_CACHE_DIR=${POCL_CACHE_DIR:-$build/pocl} # nothing goes into a home directory

if [ ! -x "$build/exit_points" ] || [ ! -x "$build/noise" ]; then
    echo "not ok $build/exit_points and $build/noise are there: build them first"
    failed=1
    finish
fi

# ---- Tools

# pixels differ A B X Y W H: how many of 10000 pixels of a rectangle differ by more than 24 of 255 in some channel.
# pixels bright A X Y W H: how many pixels of it are nearly white. pixels size A: its size. Reads PNG, and the screen as
# Xvfb keeps it in a file (XWD: a header of big endian words, then rows of blue, green, red, unused).
write_tools() {
    cat >"$work/pixels.c" <<'END'
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <stb/stb_image.h>
typedef struct { int w, h; unsigned char *rgb; } picture;
static unsigned word(const unsigned char *b, int i) {
    return (unsigned)b[4 * i] << 24 | (unsigned)b[4 * i + 1] << 16 | (unsigned)b[4 * i + 2] << 8 | b[4 * i + 3];
}
static picture load(const char *path) {
    picture p = {0, 0, NULL};
    int channels, i;
    static unsigned char b[1 << 24];
    FILE *f;
    if (strstr(path, ".png")) {
        p.rgb = stbi_load(path, &p.w, &p.h, &channels, 3);
    } else if ((f = fopen(path, "rb")) && fread(b, 1, sizeof b, f) > 100) {
        const unsigned char *rows = b + word(b, 0) + 12 * word(b, 19);
        p.w = (int)word(b, 4), p.h = (int)word(b, 5);
        p.rgb = malloc((size_t)p.w * p.h * 3);
        for (i = 0; i < p.w * p.h; i++) {
            const unsigned char *from = rows + (size_t)(i / p.w) * word(b, 12) + 4 * (i % p.w);
            p.rgb[3 * i] = from[2], p.rgb[3 * i + 1] = from[1], p.rgb[3 * i + 2] = from[0];
        }
    }
    if (!p.rgb) fprintf(stderr, "cannot read %s\n", path), exit(2);
    return p;
}
int main(int count, char **words) {
    picture a = load(words[2]), b;
    int from = words[1][0] == 'd' ? 4 : 3, x, y, c, n = 0, at[4];
    if (words[1][0] == 's') return printf("%dx%d\n", a.w, a.h) < 0;
    b = from == 4 ? load(words[3]) : a;
    for (c = 0; c < 4; c++) at[c] = from + c < count ? atoi(words[from + c]) : c == 2 ? a.w : c == 3 ? a.h : 0;
    if (at[0] + at[2] > a.w || at[1] + at[3] > a.h || at[0] + at[2] > b.w || at[1] + at[3] > b.h) return puts("10000"), 0;
    for (y = at[1]; y < at[1] + at[3]; y++) {
        for (x = at[0]; x < at[0] + at[2]; x++) {
            int differs = 0, bright = 1;
            for (c = 0; c < 3; c++) {
                int v = a.rgb[3 * (y * a.w + x) + c], d = v - b.rgb[3 * (y * b.w + x) + c];
                differs |= d > 24 || d < -24;
                bright &= v > 180;
            }
            n += from == 4 ? differs : bright;
        }
    }
    printf("%d\n", from == 4 ? (int)(1e4 * n / ((double)at[2] * at[3]) + 0.5) : n);
    return 0;
}
END
    gcc -O1 "$work/pixels.c" -o "$work/pixels" -lstb -lm && return
    echo "not ok the tools of this test compile"
    failed=1
    finish
}

# The libraries of others that keep memory to the end. They must stay loaded for their names to be known then.
write_suppressions() {
    printf 'leak:%s\n' libGLX_mesa swrast_dri libOSMesa libOpenCL libpocl libLLVM >"$work/leaks"
    echo 'int dlclose(void *library) { return library == 0; }' >"$work/dlclose.c"
    export LSAN_OPTIONS=suppressions=$work/leaks:print_suppressions=0
    export ASAN_OPTIONS=use_sigaltstack=0 # PoCL gives its threads a signal stack of their own
}

checked="gcc -std=c99 -O1 -g1 -fsanitize=address -ffp-contract=off -fno-math-errno -fno-trapping-math -fopenmp -I.
    -Idemos -Icl -I$build"
build_checked() {
    $checked demos/exit_points.c "$work/dlclose.c" -o "$work/exit_points" -lglfw -ldl -lstb -lm &&
        $checked demos/noise.c cl/sss_cl.c "$work/dlclose.c" -o "$work/noise" -lglfw -ldl -lOpenCL -lstb -lm
}
is_built() { wait $builder || { cat "$work/build.log" && return 1; }; }

# ---- Options

help_works() {
    "$build/$1" --help >"$work/help" 2>"$work/error" && [ ! -s "$work/error" ] || return 1
    local option
    for option in scene profile candidates seed size png headless help ${2//,/ }; do
        grep -q -- "--$option" "$work/help" || { echo "--help says nothing of --$option" && return 1; }
    done
}

# refuses CODE PROGRAM OPTIONS: one line of complaint, nothing on the standard output, this exit code.
refuses() {
    local wanted=$1 code
    shift
    (cd "$work" && "$@" >plain_output 2>error)
    code=$?
    cat "$work/error"
    echo "exit code $code"
    [ $code = "$wanted" ] && [ "$(wc -l <"$work/error")" = 1 ] && [ ! -s "$work/plain_output" ]
}

no_display() { refuses 3 env -u DISPLAY -u WAYLAND_DISPLAY "$build/$1" && grep -q -- "--headless" "$work/error"; }

no_mesa() {
    gcc -std=c99 -O0 -I. -DCANVAS_OSMESA='"libthere_is_none.so"' demos/exit_points.c -o "$work/blind" -lglfw -ldl -lstb -lm &&
        refuses 3 "$work/blind" --headless --png x.png && grep -q libosmesa6 "$work/error"
}

check_options() {
    check "exit_points --help" help_works exit_points dmfp-scale,techniques,turn,still,probes
    check "noise --help" help_works noise light-aware,same-time,device,against,spp,reference
    local program words
    while IFS= read -r words; do
        for program in exit_points noise; do
            check "$program, refused: $words" refuses 2 "$build/$program" --headless $words
        done
    done <<'END'
--nonsense
nonsense
--scene
--scene nowhere
--profile none
--candidates 0
--candidates 257
--seed -1
--size 24
--size 0x24
--png no/such/directory/x.png
END
    check "exit_points, refused: --dmfp-scale 0" refuses 2 "$build/exit_points" --headless --dmfp-scale 0
    check "exit_points, refused: --techniques all" refuses 2 "$build/exit_points" --headless --techniques all
    check "exit_points, refused: --turn left" refuses 2 "$build/exit_points" --headless --turn left
    check "noise, refused: --device gpu" refuses 2 "$build/noise" --headless --device gpu
    check "noise, refused: --spp 0" refuses 2 "$build/noise" --headless --spp 0
    check "noise, refused: --against none.pfm" refuses 2 "$build/noise" --headless --against none.pfm
    for program in exit_points noise; do check "$program without a display: one clear line" no_display $program; done
    check "without OSMesa: one clear line" no_mesa
}

# ---- Pictures without a display

# At most this many of 10000 pixels may differ by more than 24 of 255. The content is the same bits everywhere: what may
# differ is the edges of glyphs and lines by another OpenGL's rounding, and the digits of the seconds that noise shows.
LIMIT=60

small_exit_points() { timeout 60 "$work/exit_points" --headless --size 480x270 --png "$work/$1.png" --seed "$2"; }
small_noise() { timeout 60 "$work/noise" --headless --size 320x180 --spp 2 --reference 4 --png "$work/noise.png"; }

# as_committed NAME X Y W H: one part of the picture, so that what is small in the whole counts. `make test-pictures`
# makes the committed pictures anew.
as_committed() {
    local name=$1 differ
    shift
    differ=$("$work/pixels" differ "$work/$name.png" "tests/data/$name.png" "$@") || return 1
    echo "$differ of 10000 pixels differ, the limit is $LIMIT"
    [ "$differ" -le $LIMIT ]
}

check_pictures() {
    small_exit_points again 1 >/dev/null &
    local again=$!
    small_exit_points other 2 >/dev/null &
    local other=$!
    check "exit_points draws without a display" small_exit_points exit_points 1
    check "exit_points: the committed points" as_committed exit_points 19 55 455 113
    check "exit_points: the committed histograms" as_committed exit_points 19 188 455 47
    check "exit_points: the committed texts" as_committed exit_points
    check "exit_points: the same picture twice" repeats
    check "exit_points: another seed, another picture" other_seed
    check "noise draws without a display" small_noise
    check "noise: the committed pictures" as_committed noise 8 24 150 130
    check "noise: the committed errors" as_committed noise 162 24 150 130
    check "noise: the committed texts" as_committed noise
}

repeats() { wait $again && cmp "$work/exit_points.png" "$work/again.png"; }
other_seed() { wait $other && [ "$("$work/pixels" differ "$work/exit_points.png" "$work/other.png")" -gt $LIMIT ]; }

# ---- Windows

start_display() {
    command -v Xvfb >/dev/null && command -v xdotool >/dev/null || return 1
    Xvfb -displayfd 3 -screen 0 1280x800x24 -fbdir "$work" 3>"$work/display" 2>"$work/xvfb.log" &
    xvfb=$!
    trap 'kill $xvfb 2>/dev/null; rm -rf "$work"' EXIT
    until_true test -s "$work/display" || return 1
    export DISPLAY=:$(cat "$work/display")
}

# Up to ten seconds.
until_true() {
    local i
    for ((i = 0; i < 100; i++)); do
        "$@" && return
        sleep 0.1
    done
    return 1
}

screen() { cp "$work/Xvfb_screen0" "$work/$1.xwd"; }
finds_window() { window=$(xdotool search --onlyvisible --name "$1" 2>/dev/null | head -n 1) && [ -n "$window" ]; }

opens() { # TITLE PROGRAM OPTIONS
    local title=$1 program=$2
    shift 2
    "$work/$program" --size 960x540 --png "$work/saved.png" "$@" >"$work/said" 2>&1 &
    running=$!
    until_true finds_window "^$title\$" && xdotool getwindowgeometry "$window" | grep 'Geometry: 960x540' &&
        until_true shows_text
}
shows_text() { screen now && [ "$("$work/pixels" bright "$work/now.xwd" 0 10 960 30)" -gt 200 ]; }

# keys_change KEYS X Y W H: after these keys at least MANY of 10000 pixels of the rectangle are others.
changed() { screen now && [ "$("$work/pixels" differ "$work/before.xwd" "$work/now.xwd" "$@")" -ge ${many:-30} ]; }
keys_change() {
    local keys=$1
    shift
    screen before
    xdotool key $keys && until_true changed "$@"
}

same_as() { # FILE X Y W H: the screen shows what the file has there
    screen now
    differ=$("$work/pixels" differ "$work/now.xwd" "$@")
    [ "$differ" -le $LIMIT ]
}

saves() {
    rm -f "$work/saved.png"
    xdotool key w && until_true grep -q "^wrote .*saved.png" "$work/said" && until_true test -s "$work/saved.png" &&
        [ "$("$work/pixels" size "$work/saved.png")" = "$1" ]
}

gone() { ! kill -0 $running 2>/dev/null; }

# Q ends the program with code 0: then AddressSanitizer found nothing either.
closes() {
    xdotool key "$1"
    until_true gone || kill $running
    wait $running
    local code=$?
    cat "$work/said"
    echo "exit code $code"
    [ $code = 0 ]
}

# The panes lie in y 110..335 of 960x540; the first in x 39..209, the last in x 775..946, the keys below y 495.
shows_what_headless_draws() {
    "$work/exit_points" --headless --still --size 960x540 --png "$work/still.png" || return 1
    until_true same_as "$work/still.png" 0 0 960 488 || { echo "$differ of 10000 pixels differ" && return 1; }
}

comes_back() { xdotool key $1 && until_true same_as "$work/still.png" 0 0 960 488; }

ring_at() { screen now && [ "$("$work/pixels" bright "$work/now.xwd" $(($1 - 8)) $(($2 - 8)) 17 17)" -ge 12 ]; }
click_moves_entry() {
    ! ring_at 110 160 && xdotool mousemove 110 160 click 1 && until_true ring_at 110 160 && ring_at 847 160
}

drag() { xdotool mousemove $1 $2 mousedown ${5:-1} mousemove $((($1 + $3) / 2)) $2 mousemove $3 $4 mouseup ${5:-1}; }
drag_turns() {
    screen before
    drag 45 130 75 135 && many=100 until_true changed 39 110 170 225
}
right_drag_turns() {
    screen before
    drag 110 230 150 230 3 && many=100 until_true changed 39 110 170 225
}
wheel_zooms() {
    screen before
    xdotool mousemove 110 230 click 4 click 4 && many=100 until_true changed 39 110 170 225
}
click_on_key() {
    screen before
    xdotool mousemove 590 526 click 1 && until_true changed 39 110 170 225 || return 1
    screen before
    xdotool click 1 && until_true changed 39 110 170 225
}
turns_by_itself() {
    xdotool key space
    screen before
    many=100 until_true changed 39 110 170 225 && xdotool key space
}
resizes() {
    xdotool windowsize "$window" 1200 600 && sleep 0.5 && until_true saves 1200x600 &&
        [ "$("$work/pixels" bright "$work/saved.png" 0 10 1200 36)" -gt 200 ]
}

check_exit_points() {
    check "exit_points opens a window" opens "exit points" exit_points --still
    check "the window shows what the headless picture shows" shows_what_headless_draws
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
    check "a window of another size is filled" resizes
    check "Q ends it, without a leak" closes q
}

# The line is white from y 72 to 461: the pictures lie in x 24..474, the errors in x 486..936.
divider_at() { screen now && [ "$("$work/pixels" bright "$work/now.xwd" $(($1 - 2)) 90 5 150)" -ge 250 ]; }
divider_moves() {
    until_true divider_at 249 && drag 249 300 130 310 && until_true divider_at 130 && divider_at 592 && ! divider_at 249 &&
        drag 592 300 711 310 && until_true divider_at 249
}
captions_fill() {
    screen now
    [ "$("$work/pixels" bright "$work/now.xwd" 24 465 200 20)" -gt 60 ]
}
resumes() { until_true changed 0 463 960 50; } # the numbers go on

# Opening takes a while, compiling at first long; then the numbers go on, by the device.
device_opens() {
    xdotool key d
    until_true grep -q '^device: ' "$work/said" || until_true grep -q '^device: ' "$work/said" || return 1
    screen before
    until_true changed 0 463 480 50
}

check_noise() {
    check "noise opens a window" opens noise noise
    check "the divider follows the mouse, in both views" divider_moves
    check "the captions are there" until_true captions_fill
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
}

write_tools
write_suppressions
build_checked >"$work/build.log" 2>&1 &
builder=$!
check_options
check "both build with AddressSanitizer" is_built
check_pictures
if start_display; then
    check_exit_points
    check_noise
else
    skip "windows" "make setup installs Xvfb and xdotool"
fi
finish
