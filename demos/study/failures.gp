# failures.gp - the panels of demos/study/failures.c, each for itself and all together:
#     gnuplot -e "out='build/failures'" demos/study/failures.gp
# SPDX-License-Identifier: MIT
set encoding utf8
load out."-titles.gp"
grey = "#8c8c8c"; black = "#202020"; blue = "#2f6fb3"; orange = "#e07b00"
set key off
set style fill solid
pictures = "edge reach colours wall bumps"
is_picture(name) = strstrt(pictures, name) > 0
colour_of(side) = side == 0 ? blue : orange

# The half of a panel, left (side 0) or right, into the box x0..x1, y0..y1 of the screen. The axes of both are the same.
box(x0, x1, y0, y1) = sprintf("set lmargin at screen %g; set rmargin at screen %g; set bmargin at screen %g; \
    set tmargin at screen %g", x0, x1, y0, y1)
axes(name) = \
    name eq "hits" ? "set xlabel 'candidates M'; set ylabel 'mean over truth'; set logscale x 2; \
        set xrange [0.8:500]; set xtics (1, 4, 16, 64); set yrange [0:2.4]" : \
    name eq "retry" ? "set xlabel 'radius of the sphere / d'; set ylabel 'mean over truth'; set logscale xy; \
        set xrange [0.08:13]; set xtics (0.1, 1, 10); set yrange [0.5:40]; set ytics (1, 3, 10, 30)" : \
    name eq "hair" ? "set xlabel 'lookups'; set ylabel 'largest weight / albedo'; set logscale xy; \
        set xrange [50:4e6]; set xtics ('10^2' 100, '10^4' 1e4, '10^6' 1e6); set yrange [1:2000]; \
        set ytics ('1' 1, '10' 10, '100' 100, '10^3' 1000)" : \
    name eq "slab" ? "set xlabel 'thickness of the slab / h'; set ylabel 'mean over truth'; set logscale x; \
        set xrange [0.08:12]; set xtics (0.1, 0.3, 1, 3, 10); set yrange [0.4:1.15]; set ytics 0.2" : \
    "set xlabel 'distance / mean free path'; set ylabel 'relative error'; set logscale xy; \
        set xrange [0.01:1e5]; set xtics ('10^{-2}' 0.01, '1' 1, '10^2' 100, '10^4' 1e4); set yrange [1e-9:1e3]; \
        set ytics ('10^{-8}' 1e-8, '10^{-4}' 1e-4, '1' 1)"
one = "1 with lines dt 3 lw w lc rgb black, "
data(name) = sprintf("'%s-%s.dat' ", out, name)
bars(name, i, colour) = \
    sprintf("%s index %d using 1:2:3 with yerrorlines pt 7 lw 1.5 * w lc rgb '%s', ", data(name), i, colour)
body(side, i, text) = bars("hits", 3 * side + i, colour_of(side)). \
    sprintf("%s index %d every ::7::7 using (80):2:('%s') with labels left tc rgb black \
        offset 0, %g, ", data("hits"), 3 * side + i, text, side ? 0.8 : 0)
curves(name, side) = \
    name eq "hits" ? one.body(side, 0, side ? "" : "plane").body(side, 1, side ? "all three" : "sphere"). \
        body(side, 2, side ? "" : "plates") : \
    name eq "hair" ? sprintf("16 with lines dt 3 lw w lc rgb black, %s index %d using 1:2 with linespoints pt 7 \
        lw 1.5 * w lc rgb '%s', ", data(name), side, colour_of(side)) : \
    name eq "floats" ? sprintf("%s using 1:%d with lines lw 1.5 * w lc rgb '%s', ", data(name), side + 2, \
        colour_of(side)) : one.bars(name, side, colour_of(side))
photo(name, side) = \
    sprintf("'%s-%s-%s.png' binary filetype=png with rgbimage, ", out, name, side == 0 ? "left" : "right")
without_comma(s) = s[1:strlen(s) - 2]

reset_axes = "unset logscale; set autoscale; unset xlabel; unset ylabel; set xtics auto nomirror out; \
    set ytics auto nomirror out; set format '%g'; set border 3 lc rgb '#606060'; unset arrow; unset label; \
    "
half(name, side, x0, x1, y0, y1) = reset_axes."; ".(is_picture(name) \
    ? box(0.5 * (x0 + x1 - tall * (y1 - y0)), 0.5 * (x0 + x1 + tall * (y1 - y0)), y0, y1)."; \
       unset xtics; unset ytics; unset border; " \
    : box(x0 + 0.22 * (x1 - x0), x1 - 0.03 * (x1 - x0), y0 + 0.18 * (y1 - y0), y1)."; ".axes(name)."; "). \
    (name eq "hair" && side == 1 \
        ? "set label 9 'bound of the default plan' at graph 0.03, first 22 left tc rgb black; " : ""). \
    sprintf("set label 1 \"%s\" at screen %g, %g center tc rgb '%s'; ", \
            value((side == 0 ? "left_" : "right_").name), 0.5 * (x0 + x1), y1 + 0.05 * (y1 - y0), colour_of(side)). \
    "plot ".without_comma(is_picture(name) ? photo(name, side) : curves(name, side))
# A whole panel, in a box of the screen.
heading(name, x0, x1, y0, y1) = sprintf("set label 2 \"{/:Bold %s}\" at screen %g, %g center tc rgb black", \
    value("title_".name), 0.5 * (x0 + x1), y1 - 0.05 * (y1 - y0))

set macros
do for [name in names] {
    w = 2.0; tall = 860.0 / 1800
    set terminal pngcairo enhanced size 1800, 860 font 'DejaVu Sans,19'
    set output out."-".name.".png"
    set multiplot
    do for [side = 0:1] {
        command = half(name, side, 0.5 * side, 0.5 * side + 0.5, 0.04, 0.83)
        # the title belongs to the first of the two plots, after its labels were reset
        plot_at = strstrt(command, "plot ")
        eval(command[1:plot_at - 1])
        if (side == 0) { eval(heading(name, 0, 1, 0, 0.99)) }
        eval(command[plot_at:*])
    }
    unset multiplot
}

# All panels on one sheet, and four on another; a panel takes 700 by 350.
w = 1.2
four = "edge hits wall bumps"
do for [sheet = 0:1] {
    shown = sheet ? four : names
    rows = words(shown) / 2
    share = 1.0 / rows
    tall = 0.25 * rows
    set terminal pngcairo enhanced size 1400, 350 * rows font (sheet ? 'DejaVu Sans,13' : 'DejaVu Sans,11')
    set output out.(sheet ? "-four" : "").".png"
    set multiplot
    do for [i = 1:words(shown)] {
        name = word(shown, i)
        x0 = 0.5 * ((i - 1) % 2); y0 = 1 - share * (1 + (i - 1) / 2)
        do for [side = 0:1] {
            command = half(name, side, x0 + 0.245 * side, x0 + 0.245 * side + 0.245, y0 + 0.04 * share, y0 + 0.775 * share)
            plot_at = strstrt(command, "plot ")
            eval(command[1:plot_at - 1])
            if (side == 0) { eval(heading(name, x0, x0 + 0.49, y0, y0 + 0.935 * share)) }
            eval(command[plot_at:*])
        }
    }
    unset multiplot
}
