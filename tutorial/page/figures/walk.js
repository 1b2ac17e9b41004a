// Figure 1: light walks through a half space, and what comes back is the profile.
define("walk", (f) => {
    const C = live.C,
        bins = 48,
        width = 0.125,
        shown = 14;
    let reach = 6,
        laser = 0,
        rate = 0,
        paths = [],
        wait = 0;

    f.title(
        "A walk of light",
        "Drag the laser over the wax. Each path scatters until it is absorbed or comes " +
            "back. The bars count where light came back. The line is sss_profile, from the " +
            "header.",
        "Keys: left and right move the laser.",
    );
    const restart = () => {
        C.walk_begin(albedo.value, mfp.value, width, 1);
        paths = [];
        rate = wait = 0;
    };
    const albedo = f.slider("albedo", 0.1, 0.98, 0.9, { change: () => restart() });
    const mfp = f.slider("mean free path", 0.1, 1.2, 0.4, { log: true, change: () => restart() });
    f.pause_button();
    f.button("Start again", () => restart());
    const sent = f.number("paths"),
        back = f.number("came back"),
        asked = f.number("albedo asked for");
    const half = f.number("half of it within");
    restart();

    // One path, drawn as it runs.
    const begin_path = () => {
        const count = C.walk_one(),
            data = floats(C.walk_path(), 2 * count),
            points = [];
        for (let i = 0; i < count; i++) points.push([data[2 * i], data[2 * i + 1]]);
        paths.push({ points, laser, at: 0, age: 0, back: count > 1 && points[count - 1][1] === 0 });
        if (paths.length > shown) paths.shift();
    };
    const advance = (p, seconds) => {
        p.at = Math.min(p.points.length - 1, p.at + seconds * Math.max(12, p.points.length / 1.5));
        if (p.at >= p.points.length - 1) p.age += seconds;
    };

    const half_radius = () => {
        let low = 0,
            high = 60;
        for (let i = 0; i < 30; i++) {
            const middle = (low + high) / 2;
            if (C.within(1, 0, middle) < albedo.value / 2) low = middle;
            else high = middle;
        }
        return low;
    };

    f.height = (w) => {
        reach = w < 560 ? 3.2 : 6; // half the width of the picture
        return w < 560 ? 1.05 * w : 0.5 * w;
    };
    return {
        work(seconds) {
            wait -= seconds;
            if (wait <= 0) {
                begin_path();
                wait = 0.22;
            }
            paths.forEach((p) => advance(p, seconds));
            paths = paths.filter((p) => p.age < 2.5);
            rate = Math.min(rate + seconds * 60, 400);
            let left = C.walk_count() < 2e6 ? Math.floor(rate) : 0;
            if (left > 0)
                spend(4, () => C.walk_many(left > 0 ? Math.min(left, 20) : 0, (left -= 20)));
        },

        draw(g, w, h) {
            const c = f.c,
                ground = Math.round(0.44 * h),
                unit = w / (2 * reach),
                at = w / 2 + laser * unit;
            const fill = g.createLinearGradient(0, ground, 0, h);
            fill.addColorStop(0, c.wax);
            fill.addColorStop(1, c.waxdeep);
            g.fillStyle = c.air;
            g.fillRect(0, 0, w, ground);
            g.fillStyle = fill;
            g.fillRect(0, ground, w, h - ground);

            // Bars and the profile: power in a ring, half of it on each side.
            const data = doubles(C.walk_bins(), 2 * bins),
                total = Math.max(C.walk_count(), 1);
            const density = (r) => Math.PI * r * C.profile(1, 0, r),
                top = (0.74 * ground) / density(1e-4);
            g.fillStyle = c.orange;
            g.globalAlpha = 0.75;
            for (let side = 0; side < 2; side++) {
                for (let i = 0; i < bins; i++) {
                    const tall = Math.min((data[side * bins + i] / total / width) * top, ground);
                    const x = at + (side ? i : -i - 1) * width * unit;
                    g.fillRect(x + 0.5, ground - tall, width * unit - 1, tall);
                }
            }
            g.globalAlpha = 1;
            for (const side of [-1, 1]) {
                const curve = [];
                for (let i = 0; i <= 120; i++) {
                    const r = 1e-4 + (2 * reach * i) / 120;
                    curve.push([at + side * r * unit, ground - density(r) * top]);
                }
                line(g, [c.blue, 2.5], ...curve);
            }

            // Paths.
            g.save();
            g.beginPath();
            g.rect(0, ground, w, h - ground);
            g.clip();
            paths.forEach((p) => {
                const x0 = w / 2 + p.laser * unit,
                    whole = Math.floor(p.at),
                    rest = p.at - whole,
                    ended = p.age > 0;
                const seen = p.points.slice(0, whole + 1);
                if (whole + 1 < p.points.length) {
                    const [ax, az] = p.points[whole],
                        [bx, bz] = p.points[whole + 1];
                    seen.push([ax + rest * (bx - ax), az + rest * (bz - az)]);
                }
                const pixels = seen.map(([x, z]) => [x0 + x * unit, ground + z * unit]);
                const [ex, ez] = pixels[pixels.length - 1];
                g.globalAlpha = clamp(1 - p.age / 2.5, 0, 1) * (ended && !p.back ? 0.55 : 1);
                line(g, [c.glow, 1.5], ...pixels);
                if (!ended) dot(g, ex, ez, 3, c.glow);
                else if (!p.back) {
                    line(g, [c.ink, 1.5], [ex - 4, ez - 4], [ex + 4, ez + 4]);
                    line(g, [c.ink, 1.5], [ex - 4, ez + 4], [ex + 4, ez - 4]);
                }
            });
            g.restore();
            g.globalAlpha = 1;
            paths
                .filter((p) => p.back && p.age > 0)
                .forEach((p) => {
                    g.globalAlpha = clamp(1 - p.age / 2.5, 0, 1);
                    dot(
                        g,
                        w / 2 + (p.laser + p.points[p.points.length - 1][0]) * unit,
                        ground,
                        4.5,
                        c.glow,
                        c.ink,
                    );
                });
            g.globalAlpha = 1;

            // The laser, and what is what.
            line(g, [c.ink, 1.5], [0, ground], [w, ground]);
            line(g, [c.bad, 2.5], [at, 0], [at, ground]);
            handle(g, at, 22, c);
            const left = at > w / 2,
                tx = left ? 12 : w - 12,
                align = left ? "left" : "right";
            write(
                g,
                w < 560 ? "bars: came back" : "bars: light that came back",
                tx,
                20,
                c.orange,
                align,
                13,
                600,
                c.air,
            );
            write(g, "line: sss_profile", tx, 40, c.blue, align, 13, 600, c.air);
            write(g, "× absorbed", 12, h - 16, c.ink, "left", 13, 400, c.waxdeep);
        },

        show() {
            sent.set(thousands(C.walk_count()));
            back.set(fixed(C.walk_returned() / C.walk_count(), 3));
            asked.set(fixed(albedo.value, 3));
            half.set(fixed(half_radius() / mfp.value, 2) + " mean free paths");
        },

        drag(x) {
            laser = clamp((x - f.w / 2) / (f.w / (2 * reach)), -reach + 0.5, reach - 0.5);
        },
        key(dx) {
            if (!dx) return false;
            laser = clamp(laser + 0.25 * dx, -reach + 0.5, reach - 0.5);
        },
        grabs: (x, y) => y < 0.44 * f.h,
        state: () => ({ laser }),
    };
});
