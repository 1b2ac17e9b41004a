// Figure 6: importance resampling by hand.
define("pick", (f) => {
    const C = live.C,
        bins = 40,
        dmfp = 1.6,
        most = 2e5;
    let hits = [],
        probes = [],
        held = -1,
        spin = 0,
        running = !still_eyes,
        marker = 0;

    f.title(
        "Resampling by hand",
        "Send probes through the ball. What they hit are candidates, drawn as discs of " +
            "area w. One is picked with a chance in proportion to w. Pick often, and raise M: " +
            "the picks come to follow the target g, though the probes do not.",
        "Keys: space sends probes, return picks, left and right change M.",
    );
    const sizes = [1, 2, 4, 8, 16, 32, 64];
    const m = f.choice(
        "probes M",
        sizes.map((v) => [String(v), String(v)]),
        "4",
        () => restart(),
    );
    f.button("Send and pick", () => send());
    const run = f.button(running ? "Stop" : "Run", () => {
        running = !running;
        run.textContent = running ? "Stop" : "Run";
    });
    const count = f.number("picks"),
        apart = f.number("picks and g differ by"),
        total = f.number("W, sum of w");
    const count_m = () => Number(m.value);

    const restart = () => {
        C.pick_begin(dmfp, 2);
        send();
    };
    const send = () => {
        held = C.pick_one(count_m());
        hits = hits_drawn();
        probes = probes_drawn();
        const sum = hits.reduce((s, hit) => s + hit.weight, 0);
        let before = 0;
        for (let i = 0; i < held; i++) before += hits[i].weight;
        marker = held >= 0 ? (before + hits[held].weight / 2) / sum : 0;
        spin = 0;
        f.changed();
    };
    // The target over the distance on a ball, where the area within r is pi r^2. Its sum is 1.
    const target = (r) => (2 * Math.PI * r * C.profile(6, 0, r)) / C.within(6, 0, 2);
    const difference = () => {
        const data = doubles(C.pick_bins(), bins),
            n = C.pick_count();
        let sum = 0;
        for (let i = 0; i < bins; i++)
            sum += Math.abs(
                data[i] / n -
                    (C.within(6, 0, (2 * (i + 1)) / bins) - C.within(6, 0, (2 * i) / bins)) /
                        C.within(6, 0, 2),
            );
        return sum / 2;
    };

    const places = () => {
        const wide = f.w >= 640,
            w = wide ? 0.46 * f.w : f.w,
            h = wide ? f.h : 0.98 * f.w;
        const box = wide
            ? { x: w + 36, y: 44, w: f.w - w - 60, h: f.h - 100 }
            : { x: 28, y: h + 40, w: f.w - 44, h: f.h - h - 90 };
        return { w, h, box, cx: w / 2, cy: 0.44 * h, r: 0.33 * h };
    };

    f.height = (w) => (w >= 640 ? 0.54 * w : 0.98 * w + 310);
    return {
        work(seconds) {
            spin = Math.min(1, spin + seconds / (still_eyes ? 0.01 : 0.9));
            if (running && C.pick_count() < most) {
                let left = clamp(0.03 * C.pick_count(), 2, 1e4);
                spend(5, () => (C.pick_many(left > 0 ? 10 : 0, count_m()), (left -= 10)));
            }
            return spin < 1 || (running && C.pick_count() < most);
        },
        draw(g, w, h) {
            const c = f.c,
                p = places(),
                at = (x, z) => [p.cx + x * p.r, p.cy - z * p.r];
            const sum = hits.reduce((s, hit) => s + hit.weight, 0),
                size = (0.17 * p.r) / Math.sqrt(Math.max(...hits.map((hit) => hit.weight), 0.02));
            g.fillStyle = c.air;
            g.fillRect(0, 0, p.w, p.h);
            dot(g, p.cx, p.cy, p.r, c.wax, c.ink);
            g.save();
            g.beginPath();
            g.rect(0, 0, p.w, p.h);
            g.clip();
            probes.forEach(([ax, , az, bx, , bz]) =>
                line(
                    g,
                    [c.soft, 0.8, [3, 4]],
                    at(ax, Math.min(az, 1.18)),
                    at(bx, Math.max(bz, -1.14)),
                ),
            );
            hits.forEach((hit, i) => {
                g.globalAlpha = i === held && spin >= 1 ? 1 : 0.6;
                dot(
                    g,
                    ...at(hit.x, hit.z),
                    clamp(size * Math.sqrt(hit.weight), 1.5, 0.4 * p.r),
                    i === held && spin >= 1 ? c.orange : c.blue,
                    c.paper,
                );
            });
            g.globalAlpha = 1;
            if (held >= 0 && spin >= 1) {
                const [x, y] = at(hits[held].x, hits[held].z);
                dot(
                    g,
                    x,
                    y,
                    clamp(size * Math.sqrt(hits[held].weight), 1.5, 0.4 * p.r) + 5,
                    null,
                    c.orange,
                );
                write(
                    g,
                    "picked",
                    x,
                    y +
                        (y > p.cy ? 1 : -1) *
                            (clamp(size * Math.sqrt(hits[held].weight), 4, 0.4 * p.r) + 18),
                    c.orange,
                    "center",
                    13,
                    700,
                    c.air,
                );
            }
            dot(g, ...at(0, 1), 5, c.ink, c.paper);
            line(g, [c.ink, 1], at(0, 0.95), at(0, 0.42));
            write(g, "entry x", p.cx, p.cy - 0.34 * p.r, c.ink, "center", 13, 600, c.wax);
            g.restore();

            // The weights side by side, and a pointer that falls on one of them.
            const x0 = 20,
                long = p.w - 40,
                y0 = p.h - 46;
            let x = x0;
            hits.forEach((hit, i) => {
                const wide = (long * hit.weight) / sum;
                g.fillStyle = i === held && spin >= 1 ? c.orange : c.blue;
                g.globalAlpha = i === held && spin >= 1 ? 1 : 0.6;
                g.fillRect(x, y0, Math.max(wide - 1, 0.6), 18);
                x += wide;
            });
            g.globalAlpha = 1;
            if (held >= 0) {
                const ease = 1 - Math.pow(1 - spin, 3),
                    sweep = Math.abs(((ease * 2.5 + (marker - 0.5) * ease + 10) % 2) - 1);
                const place = spin >= 1 ? marker : sweep,
                    px = x0 + long * place;
                polygon(g, c.ink, [px, y0 - 2], [px - 7, y0 - 14], [px + 7, y0 - 14]);
            }
            write(
                g,
                held < 0
                    ? "no probe hit: a fair sample of zero"
                    : "w side by side: the chance of each is w / W",
                x0,
                y0 + 32,
                c.ink,
                "left",
                12,
                400,
                c.air,
            );

            // Picks over distance.
            const data = doubles(C.pick_bins(), bins),
                n = Math.max(C.pick_count(), 1),
                top = 1.15 * target(1e-4);
            const q = plot(
                g,
                c,
                p.box,
                { from: 0, to: 2, ticks: [0, 1, 2], title: "distance from the entry, in radii" },
                { from: 0, to: top, title: "how often picked" },
            );
            g.fillStyle = c.orange;
            g.globalAlpha = 0.75;
            for (let i = 0; i < bins; i++) {
                const v = Math.min(((data[i] / n) * bins) / 2, top);
                g.fillRect(q.x((2 * i) / bins) + 0.5, q.y(v), p.box.w / bins - 1, q.y(0) - q.y(v));
            }
            g.globalAlpha = 1;
            const curve = [];
            for (let i = 0; i <= 100; i++) curve.push(q.at(i / 50, target(i / 50 + 1e-4)));
            line(g, [c.blue, 2.5], ...curve);
            write(
                g,
                "line: the target g",
                p.box.x + p.box.w,
                p.box.y + 12,
                c.blue,
                "right",
                13,
                600,
                c.panel,
            );
            write(
                g,
                "bars: what sss_finish picked",
                p.box.x + p.box.w,
                p.box.y + 32,
                c.orange,
                "right",
                13,
                600,
                c.panel,
            );
        },
        show() {
            count.set(thousands(C.pick_count()));
            apart.set(
                C.pick_count() < 100 ? "too few to say" : fixed(100 * difference(), 1) + " %",
            );
            total.set(
                fixed(
                    hits.reduce((s, hit) => s + hit.weight, 0),
                    3,
                ),
            );
        },
        key(dx, dy, key) {
            if (dx) {
                const i = clamp(sizes.indexOf(count_m()) + dx, 0, sizes.length - 1);
                m.inputs[sizes[i]].click();
            } else if (key === " ") send();
            else if (key === "Enter") run.click();
            else return false;
        },
        begin: restart(),
        state: () => ({ m: count_m() }),
    };
});
