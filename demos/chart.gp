# chart.gp - the charts, from what chart.awk makes: gnuplot -e "out='build/chart'" demos/chart.gp
# SPDX-License-Identifier: MIT
load out."-titles.gp"
grey = "#8c8c8c"; black = "#202020"; blue = "#2f6fb3"; orange = "#e07b00"; red = "#c2255c"; green = "#2b8a3e"
set tics nomirror out
set border 3 lc rgb "#606060"
set key off
set logscale xy

do for [format in "png svg"] {
    w = format eq "png" ? 2.0 : 1.0 # PNG has twice the pixels, to be shown at half the size
    terminal(high) = sprintf("set terminal %s size %d,%d font 'DejaVu Sans,%d'", format eq "png" ? "pngcairo" : "svg", 830 * w, high * w, (format eq "png" ? 10.5 : 12) * w)
    small = sprintf(",%d", 8 * w)
    set pointsize 0.6 * w
    set label 99 machine at screen 0.995, 0.018 right tc rgb grey font small
    heading(text) = sprintf("set label 98 \"%s\" at screen 0.5, 0.955 center", text)

    # ---- Which method when
    eval(terminal(520))
    set output out."-when.".format
    eval(heading(when_title))
    set xlabel "cost of shading an exit, over that of a probe"
    set ylabel "CPU time of a pixel to 5 % error (µs)" 
    set lmargin 11; set rmargin 28; set bmargin 4.2; set tmargin 4
    set xrange [0.03:60]; set yrange [20:12000]
    data = out."-when.dat"
    set label 1 "pale: the range of the five scenes" at graph 0.03, 0.95 left tc rgb red font small
    plot data index "told" using 1:3:4 with filledcurves fc rgb red fs transparent solid 0.10 noborder, \
        data index "three-axes" with linespoints lw w pt 7 lc rgb grey, \
        data index "disk-sphere" with linespoints lw w pt 7 dt 2 lc rgb grey, \
        data index "memo" with linespoints lw 1.5 * w pt 7 lc rgb blue, \
        data index "ours" with linespoints lw 2 * w pt 7 lc rgb orange, \
        data index "told" with linespoints lw 2 * w pt 7 lc rgb red, \
        data index "cloud" with linespoints lw 1.5 * w pt 7 lc rgb green, \
        data index "walk" with linespoints lw 1.5 * w pt 7 dt 2 lc rgb black, \
        data index "three-axes" every ::3::3 using 1:2:("plain, three axes") with labels left offset 1, 0.3 tc rgb grey, \
        data index "disk-sphere" every ::3::3 using 1:2:("plain, disk or sphere") with labels left offset 1, 0.3 tc rgb grey, \
        data index "memo" every ::3::3 using 1:2:("memo, best M") with labels left offset 1, -0.5 tc rgb blue, \
        data index "ours" every ::3::3 using 1:2:("ours, best M") with labels left offset 1, 0.4 tc rgb orange, \
        data index "told" every ::3::3 using 1:2:("ours, told of the light") with labels left offset 1, 0 tc rgb red, \
        data index "cloud" every ::3::3 using 1:2:("point cloud") with labels left offset 1, 0 tc rgb green, \
        data index "walk" every ::3::3 using 1:2:("random walk") with labels left offset 1, 0 tc rgb black

    # ---- Error over time, one picture for each cost of shading
    unset label 98; unset label 1
    set rmargin 1.5; set lmargin 7; set tmargin 2; set bmargin 3.2
    do for [cost in "0 64 512 4096"] {
        eval(terminal(620))
        set output out."-error-".cost.".".format
        data = out."-error-".cost.".dat"
        set multiplot layout 2, 3 title value("error_title_".cost) offset 0, -0.2 margins 0.075, 0.985, 0.115, 0.89 spacing 0.065, 0.13
        set xrange [0.4:30000]; set yrange [0.004:3]
        set xtics ("1 µs" 1, "10" 10, "100" 100, "1 ms" 1000, "10" 10000)
        set ytics ("1 %%" 0.01, "10 %%" 0.1, "100 %%" 1)
        do for [scene in "sphere slab corner needles bear"] {
            set title scene offset 0, -0.7
            model = real(value("model_".scene))
            plot data index scene."-frontier" with lines lw 9 * w lc rgb "#f3e3b3", \
                model with lines lw w dt 3 lc rgb black, \
                data index scene."-three-axes-1" with lines lw w lc rgb grey, \
                data index scene."-disk-sphere-1" with lines lw w dt 2 lc rgb grey, \
                data index scene."-memo-8" with lines lw 1.5 * w lc rgb blue, \
                data index scene."-ours-8" with lines lw 2 * w lc rgb orange, \
                data index scene."-told-8" with lines lw 2 * w lc rgb red, \
                data index scene."-cloud" with points pt 7 lc rgb green, \
                data index scene."-walk-0" with lines lw 1.5 * w dt 2 lc rgb black
        }
        unset logscale; unset xtics; unset ytics; unset xlabel; unset ylabel; unset title; unset border
        set xrange [0:1]; set yrange [0:1]
        names = "'plain, three axes' 'plain, disk or sphere (dashed)' 'memo, M = 8' 'ours, M = 8' 'ours, M = 8, told of the light' 'point cloud: 1, 8, 65 k points' 'random walk (dashed)' 'dotted: profile against walk' 'frontier'"
        colours = grey." ".grey." ".blue." ".orange." ".red." ".green." ".black." ".black." #c9a227"
        do for [i = 1:9] { set label i word(names, i) at 0.0, 1.02 - 0.11 * i left tc rgb word(colours, i) }
        plot -1
        do for [i = 1:9] { unset label i }
        unset multiplot
        set logscale xy; set border 3 lc rgb "#606060"; set xtics nomirror out auto; set ytics nomirror out auto; set autoscale
    }

    # ---- Best M
    eval(terminal(500))
    set output out."-best.".format
    set lmargin 10; set rmargin 24; set bmargin 4.2; set tmargin 4
    eval(heading(best_title))
    set xlabel "cost of shading an exit, over that of a probe"
    set ylabel "candidates M of the greatest efficiency"
    set xrange [0.025:70]; set yrange [0.8:90]; set ytics (1, 2, 4, 8, 16, 32, 64)
    data = out."-best.dat"
    plot data index "told" using 1:3 with lines lw w lc rgb "#e6a9bd", \
        data index "ours" using 1:3 with lines lw w lc rgb "#f0c48f", \
        data index "planned" with lines lw 1.5 * w dt 2 lc rgb black, \
        data index "ours" using 1:2 with points pt 7 lc rgb orange, \
        data index "told" using 1:2 with points pt 7 lc rgb red, \
        data index "planned" every ::3::3 using 1:2:("the header's plan") with labels left offset 1, -0.3 tc rgb black, \
        "+" every ::0::0 using (45):(26):("told of the light:\ndots measured,\nlines theory") with labels left tc rgb red, \
        "+" every ::0::0 using (45):(11.5):("ours") with labels left tc rgb orange
    unset yrange; set ytics auto

    # ---- Over the dmfp
    eval(terminal(520))
    set output out."-size.".format
    eval(heading(size_title))
    set xlabel "longest dmfp, over the radius of a sphere of the object's area"
    set ylabel "error after 200 µs a pixel" 
    set xrange [0.05:25]; set yrange [0.002:4]; set ytics ("0.3 %%" 0.003, "1 %%" 0.01, "3 %%" 0.03, "10 %%" 0.1, "30 %%" 0.3, "100 %%" 1, "300 %%" 3)
    data = out."-size.dat"
    plot data index "model" using 1:3:4 with filledcurves fc rgb black fs transparent solid 0.07 noborder, \
        data index "three-axes" with lines lw w lc rgb grey, \
        data index "disk-sphere" with lines lw w dt 2 lc rgb grey, \
        data index "memo" with lines lw 1.5 * w lc rgb blue, \
        data index "ours" with lines lw 2 * w lc rgb orange, \
        data index "told" with lines lw 2 * w lc rgb red, \
        data index "cloud" with linespoints pt 7 lw 1.5 * w lc rgb green, \
        data index "model" with lines lw 2 * w dt 3 lc rgb black, \
        data index "model" every ::4::4 using 1:2:("profile against walk") with labels left offset 1, 0 tc rgb black, \
        data index "three-axes" every ::4::4 using 1:2:("plain (dashed: disk or sphere)") with labels left offset 1, 1 tc rgb grey, \
        data index "memo" every ::4::4 using 1:2:("memo, M = 8") with labels left offset 1, 0.2 tc rgb blue, \
        data index "ours" every ::4::4 using 1:2:("ours, M = 8") with labels left offset 1, -0.4 tc rgb orange, \
        data index "told" every ::4::4 using 1:2:("ours, told of the light") with labels left offset 1, -0.8 tc rgb red, \
        data index "cloud" every ::4::4 using 1:2:("point cloud") with labels left offset 1, 0 tc rgb green

    # ---- The profiles
    unset label 99
    eval(terminal(480))
    set output out."-model.".format
    eval(heading(model_title))
    set xlabel "diffuse albedo of the half space"
    set ylabel "light in the wrong place" 
    unset logscale x
    set xrange [0:1]; set yrange [0.015:1.5]; set ytics ("2 %%" 0.02, "5 %%" 0.05, "10 %%" 0.1, "20 %%" 0.2, "50 %%" 0.5, "100 %%" 1)
    data = out."-model.dat"
    plot for [k = 4:7] data using ($1 == 1 ? $3 : NaN):k with linespoints pt 7 lw 2 * w lc rgb word(blue." ".green." ".orange." ".red, k - 3), \
        for [k = 4:7] data using ($1 > 1 ? $3 : NaN):k with linespoints pt 6 lw w dt 2 lc rgb word(blue." ".green." ".orange." ".red, k - 3), \
        data every ::6::6 using (1):4:("Burley by dmfp") with labels left offset 1, -0.3 tc rgb blue, \
        data every ::6::6 using (1):5:("Burley by mfp") with labels left offset 1, 0.4 tc rgb green, \
        data every ::6::6 using (1):6:("dipole") with labels left offset 1, -0.4 tc rgb orange, \
        data every ::6::6 using (1):7:("better dipole") with labels left offset 1, 0.4 tc rgb red, \
        "+" every ::0::0 using (1):(0.03):("solid: matched indices\ndashed: index 1.4") with labels left offset 1, 0 tc rgb black
    set logscale x

    # ---- The plan
    set label 99 machine at screen 0.995, 0.018 right tc rgb grey font small
    eval(terminal(480))
    set output out."-plan.".format
    eval(heading(plan_title))
    set xlabel "cost of shading an exit, over that of a probe"
    set ylabel "the plan's efficiency over the best" 
    unset logscale y
    set xrange [0.025:70]; set yrange [0:1.25]; set ytics ("0" 0, "20 %%" 0.2, "40 %%" 0.4, "60 %%" 0.6, "80 %%" 0.8, "100 %%" 1)
    data = out."-plan.dat"
    plot 0.8 with lines lw w dt 3 lc rgb black, 1 with lines lw w lc rgb grey, \
        data index "ours" using 1:2 with points pt 7 lc rgb orange, \
        data index "told" using ($1 * 1.12):2 with points pt 7 lc rgb red, \
        "+" every ::0::0 using (80):(1):("the best method") with labels left tc rgb grey, \
        "+" every ::0::0 using (80):(0.8):("20 %% below it") with labels left tc rgb black, \
        "+" every ::0::0 using (80):(0.6):("ours") with labels left tc rgb orange, \
        "+" every ::0::0 using (80):(0.5):("told of the light") with labels left tc rgb red
    set logscale y

    # ---- The seam
    unset label 98; unset label 99
    eval(terminal(780))
    set output out."-seam.".format
    data = out."-seam.dat"
    unset logscale
    set multiplot title seam_title
    set lmargin at screen 0.1; set rmargin at screen 0.97
    set tmargin at screen 0.93; set bmargin at screen 0.28
    unset xlabel; unset ylabel; unset xtics; unset ytics; unset border; unset title; unset colorbox
    set palette grey gamma 2.2; set xrange [0:200]; set yrange [30:170]
    plot data index "picture" using 1:2:3 with image
    set tmargin at screen 0.25; set bmargin at screen 0.09
    set border 3 lc rgb "#606060"; set xtics nomirror out; set ytics nomirror out
    set xrange [1e-2:1e2]; set logscale x; set format x "%g"; set yrange [0.94:1.06]; set ytics ("-5 %%" 0.95, "0" 1, "+5 %%" 1.05)
    set xlabel "dmfp in pixels"
    set ylabel "plan over lookups"
    set arrow 1 from real(seam_turn), 0.94 to real(seam_turn), 1.06 nohead dt 2 lc rgb black
    plot data index "columns" using 2:3 with points pt 7 ps 0.3 * w lc rgb orange
    unset arrow 1; unset multiplot
    unset lmargin; unset rmargin; unset tmargin; unset bmargin; set autoscale; set xtics auto; set ytics auto
    set logscale xy
}
