// Figure 3: the Jacobian. A disk probe meets a tilted plane.
define("tilt", (f) => {
    const C = live.C,
        degree = Math.PI / 180,
        band = 0.16,
        samples = 40000;
    let angle = 50,
        place = 0.45,
        seed = 1;

    f.title(
        "The shadow of a probe",
        "Turn the surface: a band of probes falls on a piece of it that is 1 / cos as " +
            "long. Hits are rarer there, so each one must count for more. Leave the cosine " +
            "out: the weights, drawn as discs, shrink, and energy is lost.",
        "Keys: left and right turn the surface, up and down move the band.",
    );
    const cosine = f.check("divide by the cosine", true, () => {});
    const turn = f.slider("tilt", -78, 78, angle, {
        digits: 0,
        unit: "°",
        change: () => set(turn.value),
    });
    const stretch = f.number("shadow of the band"),
        weight = f.number("weight of its hit");
    const right = f.number("energy with the cosine", "blue"),
        wrong = f.number("without it", "orange");
    const set = (a) => {
        angle = clamp(a, -78, 78);
        C.tilt_begin(Math.sin(angle * degree), Math.cos(angle * degree), seed);
    };
    set(angle);

    // Distances with equal chances between them: where the probes of the drawing stand.
    const quantiles = [];
    for (let i = 1; i < 11; i++) {
        let low = 0,
            high = 8;
        for (let k = 0; k < 30; k++) {
            const middle = (low + high) / 2;
            if (C.within(3, 0, middle) < i / 12.5) low = middle;
            else high = middle;
        }
        quantiles.push(low);
    }

    const places = () => ({
        cx: f.w / 2,
        cy: 0.56 * f.h,
        disk: 0.24 * f.h,
        unit: f.w < 560 ? f.w / 3.2 : f.w / 5,
    });
    f.height = (w) => (w < 560 ? 1.15 * w : 0.52 * w);
    return {
        work() {
            if (C.tilt_count() < samples) C.tilt_run(400);
            return C.tilt_count() < samples;
        },

        draw(g, w, h) {
            const c = f.c,
                p = places(),
                slope = Math.tan(angle * degree);
            const sx = (x) => p.cx + x * p.unit,
                sy = (x) => p.cy + slope * x * p.unit;

            // The object, and the disk above it with its density.
            polygon(g, c.wax, [sx(-9), sy(-9)], [sx(9), sy(9)], [sx(9), 20 * h], [sx(-9), 20 * h]);
            line(g, [c.ink, 2], [sx(-9), sy(-9)], [sx(9), sy(9)]);
            const hump = [[sx(-2.4), p.disk]];
            for (let i = -120; i <= 120; i++) {
                const r = Math.abs(i / 50) + 0.012;
                hump.push([
                    sx(i / 50),
                    p.disk -
                        Math.min((0.05 * h * C.profile(3, 0, r)) / C.profile(3, 0, 0.4), 0.2 * h),
                ]);
            }
            hump.push([sx(2.4), p.disk]);
            polygon(g, c.grip, ...hump);
            line(g, [c.ink, 3], [sx(-2.2), p.disk], [sx(2.2), p.disk]);

            // The band and its shadow.
            const a = place - band / 2,
                b = place + band / 2;
            g.globalAlpha = 0.22;
            polygon(g, c.blue, [sx(a), p.disk], [sx(b), p.disk], [sx(b), sy(b)], [sx(a), sy(a)]);
            g.globalAlpha = 1;
            line(g, [c.blue, 6], [sx(a), p.disk], [sx(b), p.disk]);
            line(g, [c.blue, 6], [sx(a), sy(a)], [sx(b), sy(b)]);

            // Probes, and hits as discs of their weights.
            [-1, 1].forEach((side) =>
                quantiles.forEach((r) => {
                    const x = side * r,
                        hit = C.tilt_weight(r) * (cosine.checked ? 1 : Math.cos(angle * degree));
                    line(g, [c.soft, 1, [3, 4]], [sx(x), p.disk], [sx(x), sy(x)]);
                    g.globalAlpha = 0.85;
                    dot(g, sx(x), sy(x), 9 * Math.sqrt(hit), c.orange, c.paper);
                    g.globalAlpha = 1;
                }),
            );

            // The entry, what turns, and words.
            dot(g, p.cx, p.cy, 5, c.ink, c.paper);
            write(
                g,
                "entry x",
                p.cx - 10 * Math.sign(slope),
                p.cy + 22,
                c.ink,
                slope > 0 ? "right" : "left",
                13,
                600,
                c.wax,
            );
            const reach = Math.min(
                    0.42 * w,
                    (0.4 * h) / Math.abs(Math.sin(angle * degree) || 1e-9),
                ),
                ex = -Math.cos(angle * degree) * reach;
            handle(g, p.cx + ex, p.cy + ex * slope, c);
            write(
                g,
                "probes start here, with density P",
                slope > 0 ? w - 12 : 12,
                18,
                c.accent,
                slope > 0 ? "right" : "left",
                13,
                600,
                c.panel,
            );
            write(g, "1", sx(place), p.disk - 14, c.blue, "center", 14, 700, c.panel);
            const near = sx(place) > w - 125,
                above = near ? slope < 0 : slope > 0;
            write(
                g,
                "1 / cos = " + fixed(1 / Math.cos(angle * degree), 2),
                sx(place) + (near ? -14 : 14),
                sy(place) + (above ? -18 : 22),
                c.blue,
                near ? "right" : "left",
                14,
                700,
                above ? c.panel : c.wax,
            );

            // Energy.
            const wide = Math.min(0.36 * w, 260),
                x0 = slope > 0 ? 16 : w - 1.1 * wide - 20,
                y0 = h - 46;
            [
                [1, c.blue, "with the cosine"],
                [0, c.orange, "without"],
            ].forEach(([way, colour, text], i) => {
                const y = y0 + i * 24;
                g.fillStyle = c.panel;
                g.globalAlpha = 0.85;
                g.fillRect(x0 - 6, y - 10, wide * 1.1 + 12, 22);
                g.globalAlpha = 1;
                g.fillStyle = colour;
                g.fillRect(x0, y - 7, wide * clamp(C.tilt_energy(way), 0, 1.1), 14);
                write(g, text, x0 + 8, y, c.paper, "left", 12, 700);
            });
            line(g, [c.ink, 1.5], [x0 + wide, y0 - 16], [x0 + wide, y0 + 36]);
            write(g, "energy 1", x0 + wide, y0 - 24, c.ink, "center", 12, 600, c.panel);
        },

        show() {
            const hit =
                C.tilt_weight(Math.abs(place)) * (cosine.checked ? 1 : Math.cos(angle * degree));
            stretch.set(fixed(1 / Math.cos(angle * degree), 2) + " ×");
            weight.set(fixed(hit, 2));
            right.set(fixed(C.tilt_energy(1), 3));
            wrong.set(fixed(C.tilt_energy(0), 3), C.tilt_energy(0) < 0.98);
        },

        drag(x, y, first) {
            const p = places();
            if (first)
                this.band = y < (p.disk + p.cy) / 2 && Math.abs(x - p.cx - place * p.unit) < 60;
            if (this.band) place = clamp((x - p.cx) / p.unit, -1.4, 1.4);
            else
                turn.value =
                    (set(
                        Math.atan2(y - p.cy, x - p.cx || 1e-9) / degree > 90 ||
                            Math.atan2(y - p.cy, x - p.cx) / degree < -90
                            ? Math.atan2(p.cy - y, p.cx - x) / degree
                            : Math.atan2(y - p.cy, x - p.cx) / degree,
                    ),
                    angle);
        },
        key(dx, dy) {
            if (!dx && !dy) return false;
            if (dx) turn.value = (set(angle + 2 * dx), angle);
            else place = clamp(place - 0.05 * dy, -1.4, 1.4);
        },
        state: () => ({ angle, place }),
    };
});
