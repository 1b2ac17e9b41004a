// Figure 4: axes and colours on a crease.
define("crease", (f) => {
    const C = live.C,
        degree = Math.PI / 180,
        bound = 12,
        most = 400000;
    const dmfp = [1, 0.35, 0.12],
        names = ["red", "green", "blue"];
    let from_edge = 0.25,
        drawn = { probes: [], hits: [] },
        wait = 0,
        exact = 1;
    const cloud = weight_cloud(f, 6);

    f.title(
        "Axes and colours in a crease",
        "Probes along one axis graze the other wall: their hits are rare and heavy. Add " +
            "the two tangents, and no weight passes 12. Then switch red off: no probe looks for " +
            "its far light, so hits there are rare and heavy again.",
        "Keys: left and right move the entry along the wall, up and down open the crease.",
    );
    const axes = [
        f.check("normal axis", true, (b) => keep(b, axes)),
        f.check("two tangents", false, (b) => keep(b, axes)),
    ];
    const colours = names.map((n) => f.check(n, true, (b) => keep(b, colours)));
    const opening = f.slider("angle of the crease", 50, 180, 92, {
        digits: 0,
        unit: "°",
        change: () => restart(),
    });
    const largest = f.number("largest weight", "orange"),
        variance = f.number("variance, relative");
    const mean = f.number("mean"),
        truth = f.number("exact"),
        count = f.number("probes");
    // One of a row stays on.
    const keep = (box, row) => {
        if (!row.some((one) => one.checked)) box.checked = true;
        restart();
    };
    const all_on = () => axes.every((b) => b.checked) && colours.every((b) => b.checked);

    // The energy, exact, for the mean of the three unit profiles: an integral for each wall, over
    // rings about the foot of the entry on it, each ring cut by the edge.
    const energy = () => {
        const half = (opening.value / 2) * degree,
            full = 2 * half,
            d = from_edge;
        const wall = (height, foot) => {
            let sum = 0;
            for (let k = 0; k < 600; k++) {
                const r0 = 9 * (k / 600) ** 3,
                    r1 = 9 * ((k + 1) / 600) ** 3,
                    r = (r0 + r1) / 2;
                const on = Math.acos(clamp(-foot / r, -1, 1)) / Math.PI;
                const s = Math.hypot(r, height);
                for (let c = 0; c < 3; c++)
                    sum += (Math.PI * (r1 * r1 - r0 * r0) * on * C.profile(4, c, s)) / 0.8 / 3;
            }
            return sum;
        };
        return wall(0, d) + wall(d * Math.sin(full), d * Math.cos(full));
    };
    const restart = () => {
        const half = (opening.value / 2) * degree;
        const techniques = (axes[0].checked ? 1 : 0) | (axes[1].checked ? 2 : 0);
        const bits = colours.reduce((sum, b, i) => sum | (b.checked ? 1 << i : 0), 0);
        C.crease_begin(techniques, bits, Math.sin(half), Math.cos(half), from_edge, 1);
        exact = energy();
        wait = 0;
        cloud.clear();
        f.changed();
    };

    const places = () => {
        const wide = f.w >= 640,
            w = wide ? 0.46 * f.w : f.w,
            h = wide ? f.h : 0.8 * f.w;
        const box = wide
            ? { x: w + 70, y: 40, w: f.w - w - 92, h: f.h - 96 }
            : { x: 48, y: h + 40, w: f.w - 64, h: f.h - h - 90 };
        return { wide, w, h, box, cx: w / 2, cy: 0.66 * h, unit: 0.5 * w };
    };
    const entry_at = () => {
        const p = places(),
            half = (opening.value / 2) * degree;
        return [
            p.cx - from_edge * Math.sin(half) * p.unit,
            p.cy - from_edge * Math.cos(half) * p.unit,
        ];
    };

    f.height = (w) => (w >= 640 ? 0.5 * w : 0.8 * w + 320);
    return {
        work(seconds) {
            if (C.crease_count() >= most) return false;
            C.crease_run(1500);
            const hits = hits_drawn();
            cloud.add(hits, places().box, (hit) =>
                hit.weight > bound ? [2.2, f.c.orange] : [1.2, f.c.blue],
            );
            wait -= seconds;
            if (wait <= 0) {
                drawn = {
                    probes: probes_drawn().slice(0, 26),
                    hits: hits.filter((hit) => hit.probe < 26),
                };
                wait = 0.8;
            }
        },

        draw(g, w, h) {
            const c = f.c,
                p = places(),
                half = (opening.value / 2) * degree;
            const at = (x, z) => [p.cx + x * p.unit, p.cy - z * p.unit];
            g.save();
            g.beginPath();
            g.rect(0, 0, p.w, p.h);
            g.clip();
            g.fillStyle = c.air;
            g.fillRect(0, 0, p.w, p.h);
            const left = at(-4 * Math.sin(half), 4 * Math.cos(half)),
                right = at(4 * Math.sin(half), 4 * Math.cos(half));
            polygon(g, c.wax, left, at(0, 0), right, [right[0], 9 * h], [left[0], 9 * h]);
            line(g, [c.ink, 2], left, at(0, 0), right);

            drawn.probes.forEach(([ax, , az, bx, , bz]) =>
                line(g, [c.soft, 0.8], at(ax, az), at(bx, bz)),
            );
            g.globalAlpha = 0.85;
            drawn.hits.forEach((hit) =>
                dot(
                    g,
                    ...at(hit.x, hit.z),
                    clamp(3.2 * Math.sqrt(hit.weight), 1.5, 60),
                    hit.weight > bound ? c.orange : c.blue,
                    c.paper,
                ),
            );
            g.globalAlpha = 1;
            const [ex, ey] = entry_at();
            handle(g, ex, ey, c);
            write(g, "entry", ex, ey - 24, c.accent, "center", 13, 600, c.air);
            write(
                g,
                "probes, and hits of area weight",
                12,
                p.h - 18,
                c.ink,
                "left",
                13,
                400,
                c.wax,
            );
            g.restore();

            const q = cloud.draw(g, p.box);
            const sure = all_on(),
                y = q.y(bound);
            line(g, [sure ? c.green : c.soft, 2, [7, 5]], [p.box.x, y], [p.box.x + p.box.w, y]);
            write(
                g,
                sure ? "12: no weight passes" : "12: the bound with all on",
                p.box.x + p.box.w,
                y - 12,
                sure ? c.green : c.soft,
                "right",
                13,
                600,
                c.panel,
            );
        },

        show() {
            largest.set(
                fixed(C.crease_largest(), C.crease_largest() < 100 ? 1 : 0),
                C.crease_largest() > bound,
            );
            variance.set(fixed(C.crease_variance(), 2));
            mean.set(fixed(C.crease_mean(), 3));
            truth.set(fixed(exact, 3));
            count.set(thousands(C.crease_count()));
        },

        grabs(x, y) {
            const [ex, ey] = entry_at();
            return Math.hypot(x - ex, y - ey) < 50;
        },
        drag(x, y) {
            const p = places();
            from_edge = clamp(Math.hypot(x - p.cx, y - p.cy) / p.unit, 0.05, 1.2);
            restart();
        },
        key(dx, dy) {
            if (!dx && !dy) return false;
            if (dx) from_edge = clamp(from_edge - 0.05 * dx, 0.05, 1.2);
            else opening.value = clamp(opening.value + 5 * -dy, 50, 180);
            restart();
        },
        begin: restart(),
        state: () => ({ from_edge }),
        handle: entry_at,
        exact: () => exact,
    };
});
