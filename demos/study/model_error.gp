# model_error.gp - what the plan expects a flat profile to be off, against what it is off, from
# model_error's rows: gnuplot -e "out='build/model_error'" demos/study/model_error.gp
# SPDX-License-Identifier: MIT
set encoding utf8
data = out.".dat"
tolerance = 0.1
grey = "#8c8c8c"; black = "#202020"; blue = "#2f6fb3"; orange = "#e07b00"; red = "#c2255c"
w = 2.0 # twice the pixels, to be shown at half the size

# What is too small for the axes is drawn on their edge.
low = 0.004
shown(x) = x < low ? low : x
missed(p, m) = p <= tolerance && m > tolerance
needless(p, m) = p > tolerance && m <= tolerance
stats data using (missed($3, $4)) nooutput name "MISSED"
stats data using (needless($3, $4)) nooutput name "NEEDLESS"

set terminal pngcairo size 830 * w, 620 * w font sprintf("DejaVu Sans,%g", 10.5 * w)
set output out.".png"
text = "At a tolerance of 10 %%, the plan takes a profile that is further off"
text = text." in %.1f %% of %d cases,\nand walks where the profile would do in %.1f %%"
set title sprintf(text, 100 * MISSED_mean, MISSED_records, 100 * NEEDLESS_mean)
set tics nomirror out
set border 3 lc rgb "#606060"
set logscale xy
set xrange [low:1.1]; set yrange [low:12]
set format xy "%g %%"
set xtics ("≤ 0.4 %%" low)
set ytics ("≤ 0.4 %%" low)
do for [p in "1 2 5 10 20 50 100"] { set xtics add (p." %%" p / 100.0) }
do for [p in "1 2 5 10 20 50 100 200 500 1000"] { set ytics add (p." %%" p / 100.0) }
set xlabel "error of a flat profile that the plan expects"
set ylabel "its error against the random walk" offset 0.5
set lmargin 12; set rmargin 24; set bmargin 4; set tmargin 4
set key at graph 1.03, 0.98 left top Left reverse samplen 0.5 spacing 1.3
set pointsize 0.65 * w

set style rectangle back
set object 1 rectangle from low, tolerance to tolerance, 12 fc rgb red fs solid 0.10 noborder
set object 2 rectangle from tolerance, low to 1.1, tolerance fc rgb grey fs solid 0.15 noborder
set label 1 "profile chosen, and too far off" at low * 1.15, 9 left tc rgb red
set label 2 "walked, though the\nprofile would do" at 1.05, low * 1.6 right tc rgb "#606060"
set label 3 "profile chosen" at low * 1.15, 0.08 left tc rgb "#606060"
set label 4 "walked" at tolerance * 1.1, 9 left tc rgb "#606060"

# Shape by point, light by colour: 0 everywhere, 1 in front, 2 behind.
tint(l) = l == 0 ? 0x8c8c8c : l == 1 ? 0x2f6fb3 : 0xe07b00
shape(i, point, name) = sprintf("data index %d using (shown($3)):(shown($4)):(tint($2)) ", i) \
    .sprintf("with points pt %d lc rgb variable notitle, ", point) \
    .sprintf("NaN with points pt %d lc rgb black title '%s', ", point, name)
key(colour, name) = sprintf("NaN with points pt 5 lc rgb '%s' title '%s', ", colour, name)
parts = shape(0, 7, "ball").shape(1, 5, "slab").shape(2, 9, "cylinder").shape(3, 13, "spheroid") \
    .shape(4, 2, "edge").shape(5, 1, "inside corner") \
    .key(grey, "light everywhere").key(blue, "lamp in front").key(orange, "lamp behind")
eval("plot x with lines lw w dt 3 lc rgb grey title 'as expected', ".parts[1:strlen(parts) - 2])
