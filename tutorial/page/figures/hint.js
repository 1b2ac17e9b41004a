// Figure 7: a hint of the light, painted by hand.
define("hint", (f) => {
    const C = live.C,
        cells = 24,
        entry = [-0.35, 0.2],
        most = 3e6,
        plain_samples = 60000;
    let seed = 7,
        trace = [],
        cursor = [12, 12],
        level = 4;

    f.title(
        "A light hint",
        "Left, the light of a window on wax. Right, paint a guess of it. A good guess " +
            "makes the noise smaller, a bad one larger, and the mean stays where it is, until " +
            "you paint zero where light comes.",
        "Keys: arrows move the brush, space paints.",
    );
    const brush = f.choice(
        "brush",
        [
            ["4", "bright"],
            ["1", "dim"],
            ["0.15", "dark"],
            ["0", "zero"],
        ],
        "4",
        () => (level = Number(brush.value)),
    );
    f.button("No guess", () => fill(() => 1));
    f.button("Perfect guess", () => fill((i) => light()[i]));
    f.button("Forget the sky", () => fill((i) => (light()[i] > 1 ? light()[i] : 0)));
    const mean = f.number("mean"),
        truth = f.number("truth"),
        off = f.number("off by");
    const variance = f.number("variance, relative", "orange"),
        plain = f.number("without a guess", "blue");
    const map = document.createElement("canvas");
    map.width = map.height = cells;
    const light = () => floats(C.hint_light_data(), cells * cells),
        guess = () => floats(C.hint_guess_data(), cells * cells);

    C.hint_scene();
    C.hint_begin(...entry, seed);
    let exact = 0,
        plain_variance = 0,
        ticks = [];
    // What takes a while, when the figure is first seen: the integral, and the variance of a guess
    // that is the same everywhere, measured with it.
    const prepare = () => {
        const mine = Array.from(guess());
        guess().fill(1);
        C.hint_begin(...entry, seed);
        exact = C.hint_truth();
        C.hint_run(plain_samples);
        plain_variance = C.hint_variance();
        guess().set(mine);
        ticks = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8].filter((v) => v > exact * 0.6 && v < exact * 1.4);
        restart();
    };
    const restart = () => {
        C.hint_begin(...entry, seed);
        trace = [];
        f.changed();
    };
    const fill = (value) => {
        const to = guess();
        for (let i = 0; i < cells * cells; i++) to[i] = value(i);
        restart();
    };
    const paint = (i, j) => {
        const to = guess();
        let change = false;
        for (let b = -1; b <= 1; b++)
            for (let a = -1; a <= 1; a++) {
                const x = i + a,
                    y = j + b;
                if (x < 0 || y < 0 || x >= cells || y >= cells || Math.abs(a) + Math.abs(b) > 1)
                    continue;
                change = change || to[y * cells + x] !== Math.fround(level);
                to[y * cells + x] = level;
            }
        if (change) restart();
    };

    const places = () => {
        const wide = f.w >= 760,
            side = wide ? Math.min(0.3 * f.w, f.h - 64) : (f.w - 36) / 2;
        const left = { x: 12, y: 40, side },
            right = { x: 24 + side, y: 40, side };
        const box = wide
            ? { x: right.x + side + 76, y: 52, w: f.w - right.x - side - 100, h: f.h - 112 }
            : { x: 56, y: side + 84, w: f.w - 72, h: f.h - side - 140 };
        return { left, right, box };
    };
    // Brightness as a colour: the same scale for the light and its guess; zero is a cross.
    const shade = (v) => {
        const t = Math.pow(clamp(v / 4, 0, 1), 0.45);
        const rgb = [40 + 215 * t, 27 + 198 * t ** 1.4, 24 + 130 * t ** 2.4].map(Math.round);
        return "rgb(" + rgb + ")";
    };
    const draw_map = (g, c, p, data, title) => {
        const s = p.side / cells,
            k = map.getContext("2d");
        for (let i = 0; i < cells * cells; i++) {
            k.fillStyle = data[i] === 0 ? c.bad : shade(data[i]);
            k.fillRect(i % cells, Math.floor(i / cells), 1, 1);
        }
        g.imageSmoothingEnabled = false;
        g.drawImage(map, p.x, p.y, p.side, p.side);
        for (let i = 0; i < cells * cells; i++) {
            const x = p.x + (i % cells) * s,
                y = p.y + Math.floor(i / cells) * s;
            if (data[i] === 0)
                line(g, ["#fff", 1], [x + 0.25 * s, y + 0.25 * s], [x + 0.75 * s, y + 0.75 * s]);
        }
        write(g, title, p.x, p.y - 16, c.ink, "left", 13, 600);
        const ex = p.x + p.side * (0.5 + entry[0] / 3),
            ey = p.y + p.side * (0.5 + entry[1] / 3);
        dot(g, ex, ey, 6, "#fff", "#000");
        write(g, "entry", ex, ey + 18, "#fff", "center", 12, 600, "rgba(0, 0, 0, 0.7)");
    };

    f.height = (w) => (w >= 760 ? 0.3 * w + 92 : w / 2 + 330);
    return {
        work() {
            if (!exact) prepare();
            if (C.hint_count() >= most) return false;
            let left = clamp(Math.round(0.06 * C.hint_count()), 100, 1e5);
            spend(4, () => (C.hint_run(left > 0 ? Math.min(left, 250) : 0), (left -= 250)));
            const n = C.hint_count(),
                step = trace.length ? trace[trace.length - 1][0] * 1.08 : 0;
            if (n > step) trace.push([n, C.hint_mean(), C.hint_error()]);
        },
        draw(g, w, h) {
            const c = f.c,
                p = places();
            draw_map(g, c, p.left, light(), "the light");
            draw_map(
                g,
                c,
                p.right,
                guess(),
                p.right.side < 200 ? "paint your guess" : "your guess: paint here",
            );
            if (document.activeElement === f.canvas) {
                const s = p.right.side / cells;
                g.strokeStyle = c.accent;
                g.lineWidth = 3;
                g.strokeRect(
                    p.right.x + (cursor[0] - 1) * s,
                    p.right.y + (cursor[1] - 1) * s,
                    3 * s,
                    3 * s,
                );
            }
            // The mean as the samples come, with two standard errors.
            const q = plot(
                g,
                c,
                p.box,
                { from: 200, to: most, log: true, ticks: [1000, 100000], title: "samples" },
                {
                    from: exact * 0.6,
                    to: exact * 1.4,
                    ticks,
                    title: "mean, and two standard errors",
                },
            );
            g.save();
            g.beginPath();
            g.rect(p.box.x, p.box.y, p.box.w, p.box.h);
            g.clip();
            g.globalAlpha = 0.25;
            const above = trace.map(([n, v, e]) => q.at(n, v + 2 * e)),
                below = trace.map(([n, v, e]) => q.at(n, v - 2 * e));
            polygon(g, c.orange, ...above, ...below.reverse());
            g.globalAlpha = 1;
            line(g, [c.orange, 2.5], ...trace.map(([n, v]) => q.at(n, v)));
            g.restore();
            line(g, [c.blue, 2, [7, 5]], q.at(200, exact), q.at(most, exact));
            write(
                g,
                "truth",
                p.box.x + p.box.w,
                q.y(exact) - 12,
                c.blue,
                "right",
                13,
                600,
                c.panel,
            );
        },
        show() {
            const sigmas = Math.abs(C.hint_mean() - exact) / C.hint_error(),
                share = C.hint_mean() / exact - 1;
            const wrong = C.hint_count() > 20000 && sigmas > 5 && Math.abs(share) > 0.01;
            mean.set(fixed(C.hint_mean(), 4), wrong);
            truth.set(fixed(exact, 4));
            off.set((share < 0 ? "−" : "+") + fixed(Math.abs(100 * share), 1) + " %", wrong);
            variance.set(fixed(C.hint_variance(), 2));
            plain.set(fixed(plain_variance, 2));
        },
        grabs(x, y) {
            const p = places().right;
            return x >= p.x && x < p.x + p.side && y >= p.y && y < p.y + p.side;
        },
        drag(x, y) {
            const p = places().right;
            cursor = [
                Math.floor(((x - p.x) / p.side) * cells),
                Math.floor(((y - p.y) / p.side) * cells),
            ].map((v) => clamp(v, 0, cells - 1));
            paint(...cursor);
        },
        key(dx, dy, key) {
            if (dx || dy)
                cursor = [clamp(cursor[0] + dx, 0, cells - 1), clamp(cursor[1] + dy, 0, cells - 1)];
            else if (key === " ") paint(...cursor);
            else return false;
        },
        begin: restart(),
        handle() {
            const p = places().right;
            return [p.x + 0.6 * p.side, p.y + 0.7 * p.side];
        },
        state: () => ({ guess: Array.from(guess()) }),
    };
});
