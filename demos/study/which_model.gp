# which_model.gp - the map of demos/study/which_model.c:
#     gnuplot -e "out='build/which_model'" demos/study/which_model.gp
# SPDX-License-Identifier: MIT
set encoding utf8
set terminal pngcairo enhanced size 1600, 800 font 'DejaVu Sans,21'
set output out.".png"
set key off
set border 3 lc rgb '#606060'
set lmargin 13
set rmargin 3
set tmargin 1
set xrange [-0.7:1.48]
set yrange [-2:1.5]
set xtics ('0.2' -0.699, '0.5' -0.301, '1' 0, '2' 0.301, '5' 0.699, '10' 1, '20' 1.301) out nomirror
set ytics ('0.01' -2, '0.1' -1, '1' 0, '10' 1) out nomirror
set xlabel 'half thickness, or radius of curvature, over dmfp'
set ylabel 'pixel over dmfp'
set palette maxcolors 5 defined (0 '#d9d9d9', 1 '#c6dbef', 2 '#fdd9a8', 3 '#f4c2cf', 4 '#fbe6d8')
set cbrange [-0.5:4.5]
unset colorbox

# Where each model is: the middle of its cells.
data = out.".dat"
label(k, text) = sprintf("stats data using ($3 == %d ? $1 : NaN):($3 == %d ? $2 : NaN) nooutput; \
    set label %d \"%s\" at STATS_mean_x, STATS_mean_y center front tc rgb '#202020'", k, k, k + 1, text)
eval(label(0, "{/:Bold Lambert}\\nthe light leaves within a pixel"))
eval(label(1, "{/:Bold one disk probe}\\nflat as far\\nas the light goes"))
eval(label(2, "{/:Bold resampled}\\n{/:Bold profile}"))
eval(label(3, "{/:Bold random walk}\\nthin or curved:\\na flat profile\\nis too far off"))
eval(label(4, "{/:Bold resampled}\\n{/:Bold profile}\\nif 30 % will do,\\nelse the walk"))
plot data using 1:2:3 with image
