# chart.gp - the charts, from what chart.awk makes: gnuplot -e "out='build/chart'" demos/study/chart.gp
# SPDX-License-Identifier: MIT
set encoding utf8
load out."-titles.gp"
grey = "#8c8c8c"; black = "#202020"; blue = "#2f6fb3"; orange = "#e07b00"; red = "#c2255c"; green = "#2b8a3e"
pale_orange = "#f0c48f"; pale_red = "#e6a9bd"; pale_yellow = "#f3e3b3"; dark_yellow = "#c9a227"
set tics nomirror out
set border 3 lc rgb "#606060"
set key off
set logscale xy

# Parts of plot commands: a curve of a named block of the data, its name beside its point number `at`, and so on.
curve(name, how, width, dash, colour) = \
    sprintf("data index '%s' with %s lw %g dt %d lc rgb '%s', ", name, how, width * w, dash, colour)
tag(name, at, dy, colour, text) = \
    sprintf("data index '%s' every ::%d::%d using 1:2:(\"%s\") with labels left offset 1, %g tc rgb '%s', ", \
            name, at, at, text, dy, colour)
band(name, colour, opacity) = \
    sprintf("data index '%s' using 1:3:4 with filledcurves fc rgb '%s' fs transparent solid %g noborder, ", \
            name, colour, opacity)
dots(name, x, y, kind, colour) = \
    sprintf("data index '%s' using %s:%s with points pt %d lc rgb '%s', ", name, x, y, kind, colour)
draw(parts) = "plot ".parts[1:strlen(parts) - 2] # without the last comma
heading(text) = sprintf("set label 98 \"%s\" at screen 0.5, 0.955 center", text)
beside(i, y, colour, text) = \
    sprintf("set label %d \"%s\" at graph 1.02, first %g left tc rgb '%s'", i, text, y, colour)

do for [format in "png svg"] {
    # PNG has twice the pixels, to be shown at half the size.
    w = format eq "png" ? 2.0 : 1.0
    terminal(high) = sprintf("set terminal %s size %d,%d font 'DejaVu Sans,%d'", format eq "png" ? "pngcairo" : "svg", \
                             830 * w, high * w, (format eq "png" ? 10.5 : 12) * w)
    small = sprintf(",%d", 8 * w)
    set pointsize 0.6 * w
    set label 99 machine at screen 0.995, 0.018 right tc rgb grey font small

    # ---- Which method when
    eval(terminal(520))
    set output out."-when.".format
    eval(heading(when_title))
    set xlabel "cost of shading an exit, over that of a probe"
    set ylabel "CPU time of a pixel to 5 % error (µs)"
    set lmargin 11; set rmargin 28; set bmargin 5; set tmargin 4
    set xrange [0.1:150]; set yrange [10:10000]
    set label 1 "pale: the range of the five scenes" at graph 0.03, 0.95 left tc rgb red font small
    data = out."-when.dat"
    eval(draw(band("told", red, 0.1).curve("three-axes", "linespoints pt 7", 1, 1, grey). \
         curve("disk-sphere", "linespoints pt 7", 1, 2, grey).curve("memo", "linespoints pt 7", 1.5, 1, blue). \
         curve("ours", "linespoints pt 7", 2, 1, orange).curve("told", "linespoints pt 7", 2, 1, red). \
         curve("cloud", "linespoints pt 7", 1.5, 1, green).curve("walk", "linespoints pt 7", 1.5, 2, black). \
         tag("three-axes", 3, 0.3, grey, "plain, three axes"). \
         tag("disk-sphere", 3, 0.4, grey, "plain, disk or sphere"). \
         tag("walk", 3, 0, black, "random walk, its own truth").tag("ours", 3, -0.6, orange, "ours, best M"). \
         tag("memo", 3, 0.3, blue, "memo, best M").tag("told", 3, 0, red, "ours, told of the light"). \
         tag("cloud", 3, 0, green, "point cloud")))
    unset label 98; unset label 1

    # ---- Error over time, one picture for each cost of shading; the last of six panels is the key
    do for [cost in "0 64 512 4096"] {
        eval(terminal(620))
        set output out."-error-".cost.".".format
        data = out."-error-".cost.".dat"
        set multiplot layout 2, 3 title value("error_title_".cost) offset 0, -0.2 \
            margins 0.075, 0.985, 0.1, 0.87 spacing 0.065, 0.13
        set xrange [0.3:30000]; set yrange [0.004:3]
        set xtics ("1 µs" 1, "10" 10, "100" 100, "1 ms" 1000, "10" 10000)
        set ytics ("1 %%" 0.01, "10 %%" 0.1, "100 %%" 1)
        unset xlabel; unset ylabel
        do for [scene in "sphere slab corner needles bear"] {
            set title scene offset 0, -0.7
            model = real(value("model_".scene))
            eval(draw(curve(scene."-frontier", "lines", 9, 1, pale_yellow). \
                 sprintf("%g with lines lw w dt 3 lc rgb black, ", model). \
                 curve(scene."-three-axes-1", "lines", 1, 1, grey).curve(scene."-disk-sphere-1", "lines", 1, 2, grey). \
                 curve(scene."-memo-8", "lines", 1.5, 1, blue).curve(scene."-ours-8", "lines", 2, 1, orange). \
                 curve(scene."-told-8", "lines", 2, 1, red).curve(scene."-walk-0", "lines", 1.5, 2, black). \
                 dots(scene."-cloud", "1", "2", 7, green)))
        }
        unset logscale; unset xtics; unset ytics; unset title; unset border
        set xrange [0:1]; set yrange [0:1]
        names = "'plain, three axes' 'plain, disk or sphere (dashed)' 'memo, M = 8' 'ours, M = 8' \
                 'ours, M = 8, told of the light' 'point cloud: 1, 8, 65 k points' 'random walk (dashed)' \
                 'dotted: profile against walk' 'frontier, without the walk'"
        colours = grey." ".grey." ".blue." ".orange." ".red." ".green." ".black." ".black." ".dark_yellow
        do for [i = 1:9] { set label i word(names, i) at 0, 1.02 - 0.11 * i left tc rgb word(colours, i) }
        plot -1
        do for [i = 1:9] { unset label i }
        unset multiplot
        set border 3 lc rgb "#606060"; set xtics nomirror out auto; set ytics nomirror out auto; set autoscale
        set logscale xy
    }

    # ---- Best M
    eval(terminal(500))
    set output out."-best.".format
    eval(heading(best_title))
    set lmargin 10; set rmargin 24; set bmargin 5; set tmargin 4
    set xlabel "cost of shading an exit, over that of a probe"
    set ylabel "candidates M of the greatest efficiency"
    set xrange [0.1:200]; set yrange [0.8:130]; set ytics (1, 2, 4, 8, 16, 32, 64, 128)
    data = out."-best.dat"
    eval(beside(1, 90, red, "told of the light:\\ndots measured,\\nlines theory"))
    eval(beside(2, 9, orange, "ours"))
    eval(draw(sprintf("data index 'told' using 1:3 with lines lw w lc rgb '%s', ", pale_red). \
         sprintf("data index 'ours' using 1:3 with lines lw w lc rgb '%s', ", pale_orange). \
         curve("planned", "lines", 1.5, 2, black).dots("ours", "1", "2", 7, orange).dots("told", "1", "2", 7, red). \
         tag("planned", 3, -0.3, black, "the header's plan")))
    unset label 1; unset label 2

    # ---- Over the dmfp
    eval(terminal(520))
    set output out."-size.".format
    eval(heading(size_title))
    set rmargin 27
    set xlabel "longest dmfp, over the radius of a sphere of the object's area"
    set ylabel "error after 200 µs a pixel"
    set xrange [0.05:25]; set yrange [0.002:4]
    set ytics ("0.3 %%" 0.003, "1 %%" 0.01, "3 %%" 0.03, "10 %%" 0.1, "30 %%" 0.3, "100 %%" 1, "300 %%" 3)
    data = out."-size.dat"
    eval(draw(band("model", black, 0.07).curve("three-axes", "lines", 1, 1, grey). \
         curve("disk-sphere", "lines", 1, 2, grey).curve("memo", "lines", 1.5, 1, blue). \
         curve("ours", "lines", 2, 1, orange).curve("told", "lines", 2, 1, red). \
         curve("cloud", "linespoints pt 7", 1.5, 1, green).curve("model", "lines", 2, 3, black). \
         tag("model", 4, 0, black, "profile against walk"). \
         tag("three-axes", 4, 1, grey, "plain (dashed: disk or sphere)"). \
         tag("memo", 4, 0.2, blue, "memo, M = 8").tag("ours", 4, -0.4, orange, "ours, M = 8"). \
         tag("told", 4, -0.8, red, "ours, told of the light").tag("cloud", 4, 0, green, "point cloud")))

    # ---- The profiles
    eval(terminal(480))
    set output out."-model.".format
    eval(heading(model_title))
    unset label 99
    unset logscale x
    set xlabel "diffuse albedo of the half space"
    set ylabel "light in the wrong place"
    set xrange [0:1]; set yrange [0.015:1.5]
    set ytics ("2 %%" 0.02, "5 %%" 0.05, "10 %%" 0.1, "20 %%" 0.2, "50 %%" 0.5, "100 %%" 1)
    data = out."-model.dat"
    colours = blue." ".green." ".orange." ".red
    names = "'Burley by dmfp' 'Burley by mfp' 'dipole' 'better dipole'"
    eval(beside(1, 0.03, black, "solid: matched indices\\ndashed: index 1.4"))
    plot for [k = 4:7] data using ($1 == 1 ? $3 : NaN):k with linespoints pt 7 lw 2 * w lc rgb word(colours, k - 3), \
         for [k = 4:7] data using ($1 > 1 ? $3 : NaN):k with linespoints pt 6 lw w dt 2 lc rgb word(colours, k - 3), \
         for [k = 4:7] data every ::6::6 using (1):(column(k) * (k % 2 ? 1.06 : 0.93)):(word(names, k - 3)) \
             with labels left offset 1, 0 tc rgb word(colours, k - 3)
    unset label 1

    # ---- The plan
    eval(terminal(480))
    set output out."-plan.".format
    eval(heading(plan_title))
    set label 99 machine at screen 0.995, 0.018 right tc rgb grey font small
    unset logscale
    set xlabel "cost of shading an exit, over that of a probe"
    set ylabel "the plan's efficiency over the best"
    set xrange [0.1:200]; set yrange [0:1.4]; set logscale x
    set ytics ("0" 0, "20 %%" 0.2, "40 %%" 0.4, "60 %%" 0.6, "80 %%" 0.8, "100 %%" 1)
    data = out."-plan.dat"
    eval(beside(1, 1, grey, "the best method"))
    eval(beside(2, 0.8, black, "20 % below it"))
    eval(beside(3, 0.65, orange, "ours"))
    eval(beside(4, 0.57, red, "told of the light"))
    eval(beside(5, 0.4, black, "dots: of all methods,\\nrings: of those with\\nbounded weights"))
    stem(name, x, colour) = sprintf("data index '%s' using %s:2:(0):($3 - $2) with vectors nohead lw w lc rgb '%s', ", \
                                    name, x, colour)
    eval(draw("0.8 with lines lw w dt 3 lc rgb black, 1 with lines lw w lc rgb grey, ". \
         stem("ours", "1", pale_orange).stem("told", "($1 * 1.12)", pale_red). \
         dots("ours", "1", "2", 7, orange).dots("ours", "1", "3", 6, orange). \
         dots("told", "($1 * 1.12)", "2", 7, red).dots("told", "($1 * 1.12)", "3", 6, red)))
    do for [i = 1:5] { unset label i }

    # ---- The seam: the picture, and below it the columns' brightness
    unset label 98; unset label 99
    eval(terminal(780))
    set output out."-seam.".format
    data = out."-seam.dat"
    unset logscale
    set multiplot title seam_title
    set lmargin at screen 0.1; set rmargin at screen 0.97
    set tmargin at screen 0.93; set bmargin at screen 0.28
    unset xlabel; unset ylabel; unset xtics; unset ytics; unset border; unset colorbox
    set palette grey; set xrange [0:200]; set yrange [30:170]
    plot data index "picture" using 1:2:3 with image
    set tmargin at screen 0.25; set bmargin at screen 0.09
    set border 3 lc rgb "#606060"; set xtics nomirror out
    set xrange [1e-2:1e1]; set logscale x; set format x "%g"
    set yrange [0.94:1.06]; set ytics nomirror out ("-5 %%" 0.95, "0" 1, "+5 %%" 1.05)
    set xlabel "dmfp in pixels"
    set ylabel "plan over lookups"
    set arrow 1 from real(seam_turn), 0.94 to real(seam_turn), 1.06 nohead dt 2 lc rgb black
    plot data index "columns" using 2:3 with points pt 7 ps 0.3 * w lc rgb orange
    unset arrow 1; unset multiplot
    unset lmargin; unset rmargin; unset tmargin; unset bmargin; set autoscale; set xtics auto; set ytics auto
    set logscale xy
}
