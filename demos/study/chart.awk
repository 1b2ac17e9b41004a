# chart.awk - what chart.gp draws: medians over the repeats of chart.csv, times to a given error, frontiers, best
# numbers of candidates, and the findings that the titles state.
# Use: awk -v out=build/chart -f demos/study/chart.awk build/chart.csv
# SPDX-License-Identifier: MIT
BEGIN {
    FS = ","
    TARGET = 0.05  # relative error
    BUDGET = 2e-4  # seconds a pixel
    scenes = split("sphere slab corner needles bear", scene, " ")
    methods = split("disk three-axes sphere disk-sphere chord memo ours told planned planned-told cloud walk", method,
                    " ")
}
/^# chart/ { machine = $0; sub(/.*CPU time on /, "", machine); next }
/^scene/ { for (i = 1; i <= NF; i++) column[$i] = i; next }
{
    key = $1 "," $2 "," $3 "," $4 "," $5
    if (!(key in count)) order[++keys] = key
    n = ++count[key]
    take("seconds"); take("variance"); take("build_seconds"); take("bytes"); take("shading_over_probe")
    take("candidates"); take("dmfp"); take("reference_error")
    for (l = 1; l <= 1024; l *= 4) take("error_" l)
    pixels[$1] = $column["pixels"]
    if ($4 == "cloud" && $5 + 0 > clouds) clouds = $5 + 0 # the finest
    if (n > repeats) repeats = n
    sizes[$2]; costs[$3]; setting[$4, $5]
}
function take(name) { raw[key, name, n] = $column[name] + 0 }

# Insertion sort of list[1..n].
function sort(list, n,    i, j, x) {
    for (i = 2; i <= n; i++) {
        x = list[i]
        for (j = i - 1; j > 0 && list[j] > x; j--) list[j + 1] = list[j]
        list[j + 1] = x
    }
}
function get(key, name,    i, n, list) {
    if ((key, name) in kept) return kept[key, name]
    n = count[key]
    for (i = 1; i <= n; i++) list[i] = raw[key, name, i]
    sort(list, n)
    return kept[key, name] = (list[int((n + 1) / 2)] + list[int(n / 2) + 1]) / 2
}
function row(s, size, cost, m, set) { return s "," size "," cost "," m "," set }

# Mean over the repeats, for what is noise of the samples and not of the clock.
function mean(key, name,    i, sum) {
    for (i = 1; i <= count[key]; i++) sum += raw[key, name, i]
    return sum / count[key]
}
# Greatest less least time over the median of the repeats; of that the median over all rows.
function scatter(    k, i, n, list, low, high) {
    for (k = 1; k <= keys; k++) {
        low = high = raw[order[k], "seconds", 1]
        for (i = 2; i <= count[order[k]]; i++) {
            if (raw[order[k], "seconds", i] < low) low = raw[order[k], "seconds", i]
            if (raw[order[k], "seconds", i] > high) high = raw[order[k], "seconds", i]
        }
        list[++n] = (high - low) / get(order[k], "seconds")
    }
    sort(list, n)
    return list[int((n + 1) / 2)]
}
function time(key,    s) { # of one lookup; a cloud is shared by the pixels that see the object
    split(key, s, ",")
    return get(key, "seconds") + get(key, "build_seconds") / pixels[s[1]]
}
# CPU seconds to TARGET by a method at one setting, and by its best setting; 0 where it never gets there.
function reach(key,    v) {
    if (!(key in count)) return 0
    if (key ~ /,cloud,/) return mean(key, "error_1") <= TARGET ? time(key) : 0
    v = mean(key, "variance") / (TARGET * TARGET)
    return time(key) * (v > 1 ? v : 1)
}
function least(s, size, cost, m,    k, t, best, part) {
    best = 0
    for (k in setting) {
        split(k, part, SUBSEP)
        if (part[1] != m) continue
        t = reach(row(s, size, cost, m, part[2]))
        if (t > 0 && (best == 0 || t < best)) { best = t; chosen = part[2] }
    }
    return best
}
# Error after BUDGET: with 8 candidates where there is a choice, and the best size of a cloud.
function after(s, size, cost, m,    k, e, best, part, key) {
    best = 0
    for (k in setting) {
        split(k, part, SUBSEP)
        key = row(s, size, cost, m, part[2])
        if (part[1] != m || !(key in count) || (part[2] > 1 && part[2] < 1000 && part[2] != 8)) continue
        if (m == "cloud") e = time(key) <= BUDGET ? mean(key, "error_1") : 0
        else e = sqrt(mean(key, "variance") * (time(key) > BUDGET ? 1 : time(key) / BUDGET))
        if (e > 0 && (best == 0 || e < best)) best = e
    }
    return best
}
function line(file, text) { print text > (out "-" file ".dat") }
function title(name, text) { print name " = \"" text "\"" > (out "-titles.gp") }
# Geometric means over the scenes of a measure m[1..n]; low and high are left in globals.
function spread(list, n,    i, sum) {
    low = high = list[1]
    for (i = 1; i <= n; i++) {
        sum += log(list[i])
        if (list[i] < low) low = list[i]
        if (list[i] > high) high = list[i]
    }
    return exp(sum / n)
}
function ratio(s, cost) { return get(row(s, 1, cost, "ours", 8), "shading_over_probe") }
function mean_ratio(cost,    i, list) {
    for (i = 1; i <= scenes; i++) list[i] = ratio(scene[i], cost)
    return spread(list, scenes)
}

# ---- Which method when: CPU time of a pixel to TARGET over the cost of shading
function write_when(    i, k, c, n, list, t, x) {
    for (k = 1; k <= methods; k++) {
        line("when", "\n\n# " method[k])
        for (c = 1; c <= ncosts; c++) {
            n = 0
            for (i = 1; i <= scenes; i++) {
                t = least(scene[i], 1, cost[c], method[k])
                if (t > 0) list[++n] = t * 1e6
            }
            if (n < scenes) continue
            x = mean_ratio(cost[c])
            t = spread(list, n)
            when[method[k], c] = t
            line("when", sprintf("%.4g %.4g %.4g %.4g", x, t, low, high))
        }
    }
}
# ---- Error over time, and the frontier of all that look for the same integral
function write_error(    i, k, c, l, name, part, key, n, ts, es, best) {
    for (c = 1; c <= ncosts; c++) for (i = 1; i <= scenes; i++) {
        n = 0
        for (k = 1; k <= keys; k++) {
            key = order[k]
            split(key, part, ",")
            if (part[1] != scene[i] || part[2] != 1 || part[3] != cost[c]) continue
            name = part[4] == "cloud" ? "cloud" : part[4] "-" part[5]
            if (part[4] == "cloud") {
                ts[++n] = time(key) * 1e6; es[n] = mean(key, "error_1")
                cloud[part[5]] = ts[n] " " es[n]
                continue
            }
            line("error-" cost[c], "\n\n# " scene[i] "-" name)
            for (l = 1; l <= 1024; l *= 4) {
                e = part[4] == "walk" ? sqrt(mean(key, "variance") / l) : mean(key, "error_" l)
                line("error-" cost[c], sprintf("%.5g %.5g", time(key) * l * 1e6, e))
                if (part[4] != "walk") { ts[++n] = time(key) * l * 1e6; es[n] = e }
            }
        }
        line("error-" cost[c], "\n\n# " scene[i] "-cloud")
        for (k in cloud) line("error-" cost[c], cloud[k])
        line("error-" cost[c], "\n\n# " scene[i] "-frontier")
        frontier("error-" cost[c], ts, es, n)
    }
}
function frontier(file, ts, es, n,    i, j, t, e, best) {
    for (i = 2; i <= n; i++) {
        t = ts[i]; e = es[i]
        for (j = i - 1; j > 0 && ts[j] > t; j--) { ts[j + 1] = ts[j]; es[j + 1] = es[j] }
        ts[j + 1] = t; es[j + 1] = e
    }
    best = 1e30
    for (i = 1; i <= n; i++) if (es[i] < best) {
        best = es[i]
        line(file, sprintf("%.5g %.5g", ts[i], es[i]))
    }
}
# The walk's truth against the profile's, the noise of both taken off. What is left below a tenth of that noise's square
# is not known, and stands as that.
function model_error(s, size, cost,    key, noise, e) {
    key = row(s, size, cost, "walk", 0)
    noise = mean(key, "variance") / 1024 + get(key, "reference_error") ^ 2
    e = mean(key, "error_1024") ^ 2 - noise
    if (e <= 0.1 * noise) unknown = 1
    return sqrt(e > 0.1 * noise ? e : 0.1 * noise)
}

# ---- Best M: the peak of a parabola over log2 M through the best power of two and its neighbours
function efficiency(s, cost, m, set,    key) {
    key = row(s, 1, cost, m, set)
    return 1 / (mean(key, "variance") * time(key))
}
function best_m(s, cost, m,    k, e, a, b, c, top, d) {
    for (k = top = 0; k <= 6; k++) {
        e[k] = log(efficiency(s, cost, m, 2 ^ k))
        if (k == 0 || e[k] > e[top]) top = k
    }
    peak = exp(e[top])
    if (top == 0 || top == 6) return 2 ^ top
    a = e[top - 1]; b = e[top]; c = e[top + 1]
    d = 0.5 * (a - c) / (a - 2 * b + c)
    peak = exp(b - 0.25 * (a - c) * d)
    return 2 ^ (top + d)
}
# M = sqrt((V_1 / V_g - 1) c_s / c_p): V_g is the variance of infinitely many candidates, c_p what one more of them
# costs, c_s all that a lookup costs once.
function theory_m(s, cost, m,    v1, vg, probe, once) {
    v1 = mean(row(s, 1, cost, m, 1), "variance")
    vg = (64 * mean(row(s, 1, cost, m, 64), "variance") - v1) / 63
    probe = (time(row(s, 1, cost, m, 64)) - time(row(s, 1, cost, m, 1))) / 63
    once = time(row(s, 1, cost, m, 1)) - probe
    bracket = v1 / vg - 1
    return v1 > vg && once > 0 ? sqrt(bracket * once / probe) : 0
}
function write_best(    i, c, k, M, t, names, n, key) {
    n = split("ours told", names, " ")
    for (k = 1; k <= n; k++) {
        line("best", "\n\n# " names[k])
        worst[names[k]] = 1
        for (i = 1; i <= scenes; i++) {
            for (c = 1; c <= ncosts; c++) {
                M = best_m(scene[i], cost[c], names[k])
                t = theory_m(scene[i], cost[c], names[k])
                if (t < 1) t = 1
                if (M / t > worst[names[k]]) worst[names[k]] = M / t
                if (t / M > worst[names[k]]) worst[names[k]] = t / M
                line("best", sprintf("%.4g %.4g %.4g %.4g", ratio(scene[i], cost[c]), M, t, bracket))
            }
            line("best", "")
        }
    }
    line("best", "\n\n# planned")
    for (c = 1; c <= ncosts; c++) {
        M = get(row(scene[1], 1, cost[c], "planned", 0), "candidates")
        line("best", sprintf("%.4g %d", ratio(scene[1], cost[c]), M))
    }
}
# ---- The plan against the frontier of what knows as much: its efficiency over that of the best exact method, and of
# the best whose weights are bounded
function write_plan(    i, c, k, told, key, own, best, bounded, part, e, known, against) {
    for (told = 0; told < 2; told++) {
        known = told ? "^(told|three-axes|disk-sphere|chord|memo|ours)$" : "^(three-axes|disk-sphere|chord|memo|ours)$"
        line("plan", "\n\n# " (told ? "told" : "ours"))
        lowest[told] = 1
        for (i = 1; i <= scenes; i++) for (c = 1; c <= ncosts; c++) {
            key = row(scene[i], 1, cost[c], told ? "planned-told" : "planned", 0)
            own = efficiency(scene[i], cost[c], told ? "planned-told" : "planned", 0)
            best_m(scene[i], cost[c], told ? "told" : "ours")
            best = bounded = peak
            against = told ? "told" : "ours"
            for (k = 1; k <= keys; k++) {
                split(order[k], part, ",")
                if (part[1] != scene[i] || part[2] != 1 || part[3] != cost[c] || part[4] !~ known) continue
                e = efficiency(scene[i], cost[c], part[4], part[5])
                if (e > best) { best = e; against = part[4] "-" part[5] }
                if (e > bounded && part[4] ~ /^(ours|told|chord)$/) bounded = e
            }
            plans[told]++
            if (own >= 0.8 * bounded) close_to[told]++
            if (own >= 0.8 * best) near[told]++
            if (own / best < lowest[told]) lowest[told] = own / best
            e = own / efficiency(scene[i], cost[c], told ? "told" : "ours", 8)
            if (e < 1 && get(key, "candidates") != 8) behind[told]++
            line("plan", sprintf("%.4g %.4g %.4g %.4g %d %s %s", ratio(scene[i], cost[c]), own / best, own / bounded, e,
                                 get(key, "candidates"), scene[i], against))
        }
    }
}
# ---- Over the size of the dmfp
function write_size(    i, k, z, n, list, x, xs, e) {
    for (k = 1; k <= methods; k++) {
        line("size", "\n\n# " method[k])
        for (z = 1; z <= nsizes; z++) {
            n = 0
            for (i = 1; i <= scenes; i++) {
                e = after(scene[i], size[z], 64, method[k])
                if (e > 0) { list[++n] = e; xs[n] = get(row(scene[i], size[z], 64, "ours", 8), "dmfp") }
            }
            if (n < scenes) continue
            x = spread(xs, n); e = spread(list, n)
            line("size", sprintf("%.4g %.4g %.4g %.4g", x, e, low, high))
            size_x[z] = x
            size_y[method[k], z] = e
        }
    }
    line("size", "\n\n# model")
    for (z = 1; z <= nsizes; z++) {
        unknown = 0
        for (i = 1; i <= scenes; i++) {
            xs[i] = get(row(scene[i], size[z], 64, "ours", 8), "dmfp")
            list[i] = model_error(scene[i], size[z], 64)
        }
        x = spread(xs, scenes); e = spread(list, scenes)
        line("size", sprintf("%.4g %.4g %.4g %.4g", x, e, low, high))
        size_y["model", z] = unknown ? 0 : e
    }
}
# ---- Findings

# The x at which one curve of y[name, i] falls below another, between its points, in logarithms; 0 if it never does.
function crossing(name, other, x, y, n,    i, a, b) {
    for (i = 1; i <= n; i++) {
        b = log(y[other, i] / y[name, i])
        if (b > 0) return i == 1 ? x[1] : exp(log(x[i - 1]) + log(x[i] / x[i - 1]) * a / (a - b))
        a = b
    }
    return 0
}
function findings_when(    c, i, x, low, high, text, pays) {
    for (c = 1; c <= ncosts; c++) {
        x[c] = mean_ratio(cost[c])
        when["plain", c] = when["three-axes", c]
        if (when["disk-sphere", c] < when["plain", c]) when["plain", c] = when["disk-sphere", c]
        i = when["plain", c] / when["told", c]
        if (c == 1 || i < low) low = i
        if (c == 1 || i > high) high = i
    }
    pays = crossing("ours", "plain", x, when, ncosts)
    text = sprintf("Told of the light, resampling is %.1f to %.0f times as fast as the best plain probe", low, high)
    text = text (pays == 0 ? ".\\nUntold it does not pay." : pays <= x[1] ? ".\\nUntold it pays too." : \
                 sprintf(".\\nUntold it pays from a shading cost of %.1g probes.", pays))
    if (("cloud", ncosts) in when) {
        for (c = 1; c <= ncosts && when["cloud", c] < when["told", c]; c++) continue
        if (c > ncosts) text = text " A point cloud is the fastest, at this dmfp."
    }
    title("when_title", text)
}
# How many scenes each method is first in, to the error that TARGET is.
function firsts(cost, target,    i, k, t, best, first, wins, text, saved) {
    saved = TARGET
    TARGET = target
    for (i = 1; i <= scenes; i++) {
        best = 0
        for (k = 1; k <= methods; k++) {
            if (method[k] ~ /^(disk|sphere|walk|planned.*)$/) continue
            t = least(scene[i], 1, cost, method[k])
            if (t > 0 && (best == 0 || t < best)) { best = t; first = method[k] }
        }
        wins[name_of(first)]++
    }
    TARGET = saved
    for (k in wins) text = text (text == "" ? "" : ", ") k " in " wins[k]
    return sprintf("to %g %% %s", 100 * target, text)
}
function name_of(m) { return m == "disk-sphere" || m == "three-axes" ? "plain" : m == "told" ? "ours told" : m }
function findings_size(    z, x, y, cloud, model, text) {
    for (z = 1; z <= nsizes; z++) {
        x[z] = size_x[z]
        y["cloud", z] = ("cloud", z) in size_y ? size_y["cloud", z] : 1
        y["told", z] = size_y["told", z]
        if (!model && size_y["model", z] > y["told", z]) model = x[z]
    }
    cloud = crossing("cloud", "told", x, y, nsizes)
    text = sprintf("A point cloud (up to %.1f MB) falls behind where the dmfp is below %.2g radii of the object;",
                   get(row(scene[scenes], 1, cost[1], "cloud", clouds), "bytes") / 1e6, cloud)
    title("size_title", text sprintf("\\nfrom %.2g on the profile itself is further from the truth than our noise.", model))
}
function findings_model(    l, v, b, d, k, lo, hi, text) {
    for (k = 1; k <= 2; k++) lo[k] = lo[k, "d"] = 9
    while ((getline l < (out "-model.dat")) > 0) {
        if (split(l, v, " ") != 7 || v[1] !~ /^[0-9]/) continue
        k = v[1] > 1 ? 2 : 1
        b = v[4] < v[5] ? v[4] : v[5]
        d = v[6] < v[7] ? v[6] : v[7]
        if (b < lo[k]) lo[k] = b
        if (b > hi[k]) hi[k] = b
        if (d < lo[k, "d"]) lo[k, "d"] = d
        if (d > hi[k, "d"]) hi[k, "d"] = d
    }
    close(out "-model.dat")
    for (k in lo) { lo[k] *= 100; hi[k] *= 100 }
    text = "Burley's profile misplaces %.0f to %.0f %% of the light at matched indices and %.0f to %.0f %% at 1.4;"
    text = sprintf(text, lo[1], hi[1], lo[2], hi[2])
    title("model_title", text sprintf("\\nthe better of the dipoles %.0f to %.0f %% and %.0f to %.0f %%.",
                                      lo[1, "d"], hi[1, "d"], lo[2, "d"], hi[2, "d"]))
}
# The step in brightness where the plan turns to Lambert: means over 15 columns on either side, and their noise.
function findings_seam(    l, v, n, i, x, y, mode, turn, s, q, m, k) {
    while ((getline l < (out "-seam.dat")) > 0 && l !~ /picture/) {
        if (split(l, v, " ") != 6 || v[1] !~ /^[0-9]/) continue
        y[++n] = v[3]; x[n] = v[2]
        if (v[6] >= 0.5) turn = n
    }
    close(out "-seam.dat")
    for (k = 0; k < 2; k++) {
        s = q = 0
        for (i = turn - 14 + 15 * k; i <= turn + 15 * k; i++) { s += y[i]; q += y[i] * y[i] }
        m[k] = s / 15
        v[k] = (q / 15 - m[k] * m[k]) / 14
    }
    s = 100 * (m[0] / m[1] - 1)
    title("seam_title", sprintf("%s where the plan turns to Lambert, at a dmfp of %.2g pixels:", \
                                s * s < 0.25 ? "No seam" : "A seam", x[turn]) \
          sprintf("\\nthe step in brightness is %.2f ± %.2f %%.", s, 100 * sqrt(v[0] + v[1])))
    title("seam_turn", sprintf("%.4g", x[turn]))
}
function write_titles(    c, text) {
    findings_when(); findings_size(); findings_model(); findings_seam()
    text = "The best number of candidates grows with the cost of shading as theory says,"
    title("best_title", text sprintf("\\nwithin a factor of %.1f, and of %.1f when told of the light.", worst["ours"],
                                     worst["told"]))
    text = sprintf("The plan is within 20 %% of the best bounded method in %d of %d cases, of the best of all in %d;",
                   close_to[0], plans[0], near[0])
    text = text sprintf("\\ntold of the light, which it does not know, in %d and %d.", close_to[1], near[1])
    title("plan_title", text sprintf(" It is slower than the default in %d and %d.", behind[0], behind[1]))
    for (c = 1; c <= ncosts; c++) {
        text = sprintf("Error over CPU time of a pixel; shading costs %.2g probes.", mean_ratio(cost[c]))
        title("error_title_" cost[c], text sprintf("\\nFirst of five scenes: %s; %s.", firsts(cost[c], 0.1),
                                                   firsts(cost[c], 0.01)))
    }
}
END {
    # Only what all scenes have: a chart of an unfinished run shows the part that is done.
    for (c in costs) if (!(row(scene[scenes], 1, c, "planned-told", 0) in count)) delete costs[c]
    for (s in sizes) if (!(row(scene[scenes], s, 64, "walk", 0) in count)) delete sizes[s]
    for (c in costs) cost[++ncosts] = c + 0
    sort(cost, ncosts)
    for (s in sizes) size[++nsizes] = s + 0
    sort(size, nsizes)
    write_when(); write_error(); write_best(); write_plan(); write_size()
    title("machine", sprintf("CPU time of one thread, %s; medians of %d, which spread by %.0f %%", machine, repeats,
                             100 * scatter()))
    for (i = 1; i <= scenes; i++) title("model_" scene[i], sprintf("%.4g", model_error(scene[i], 1, 64)))
    write_titles()
}
