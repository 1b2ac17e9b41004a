// Figure 8: share and choose. Four ways to render one bear, each with the same time.
define("share", (f) => {
    const C = live.C,
        side = C.bear_side(),
        degree = Math.PI / 180,
        names = ["plain", "resampled", "shared", "volume"];
    const says = [
        "one probe, one exit",
        "picks one of M by weight",
        "one exit serves a tile",
        "walks, no flat profile",
    ];
    let turn = 205,
        spent = [0, 0, 0, 0],
        noise = [0, 0, 0, 0],
        chosen = 0;
    const pictures = names.map(() =>
        Object.assign(document.createElement("canvas"), { width: side, height: side }),
    );

    f.title(
        "Share and choose",
        "One bear, four ways to render it, and equal time for each. Drag the sun around " +
            "it, make it thinner, or let light travel farther: where the flat profile is too " +
            "far off, sss_plan_for turns to a walk through the volume. Its choice is framed.",
        "Keys: left and right move the sun, up and down change the thickness.",
    );
    const thickness = f.slider("thickness", 0.08, 1, 0.6, { log: true, change: () => restart() });
    const dmfp = f.slider("how far light travels", 0.02, 4, 0.8, {
        log: true,
        change: () => restart(),
    });
    const tolerance = f.slider("tolerated model error", 0.01, 0.5, 0.1, {
        log: true,
        text: (v) => fixed(100 * v, 0) + " %",
        change: () => choose(),
    });
    const cost = f.slider("shadow rays an exit", 1, 32, 2, {
        log: true,
        text: (v) => fixed(v, 0),
        change: () => restart(),
    });
    f.pause_button();
    const plan = f.number("sss_plan_for says"),
        error = f.number("flat profile against volume"),
        gain = f.number("time that sharing saves");
    plan.dd.style.fontSize = "1rem";

    const choose = () => {
        const [bits, m, exits, colours, tile] = new Int32Array(
            C.memory.buffer,
            C.bear_advice(thickness.value, tolerance.value),
            5,
        );
        const what =
            { 0: "default mix", 1: "one disk", 16: "walk", 32: "Lambert, no probes" }[bits] ||
            "techniques " + bits;
        plan.set(
            [
                what,
                bits === 32
                    ? ""
                    : m +
                      (bits === 16 ? (m > 1 ? " walks" : " path") : m > 1 ? " probes" : " probe"),
                exits > 1 ? exits + " exits" : "",
                colours ? "an exit for each colour" : "",
                tile > 1 ? "tiles of " + tile + " × " + tile : "",
            ]
                .filter(Boolean)
                .join(", "),
        );
        chosen = bits === 16 ? 3 : bits === 32 ? -1 : tile > 1 ? 2 : m > 1 ? 1 : 0;
        return m;
    };
    const restart = () => {
        const a = turn * degree;
        C.bear_begin(
            thickness.value,
            dmfp.value,
            Math.round(cost.value),
            0.9 * Math.sin(a),
            0.42,
            0.9 * Math.cos(a),
        );
        const m = choose();
        C.bear_candidates(1, m);
        C.bear_candidates(2, m);
        C.bear_candidates(3, 1);
        spent = [0, 0, 0, 0];
        f.changed();
    };

    const places = () => {
        const across = f.w >= 640 ? 4 : 2,
            gap = 12,
            s = (f.w - gap * (across + 1)) / across,
            tall = s + 70;
        return names.map((_, i) => ({
            x: gap + (i % across) * (s + gap),
            y: 34 + Math.floor(i / across) * tall,
            s,
        }));
    };
    f.height = (w) => (w >= 640 ? (w - 60) / 4 + 88 : w - 36 + 158);
    return {
        work() {
            if (C.bear_samples(3) > 400) return false;
            spend(8, () => {
                // whoever has had the least time is next
                const way = spent.indexOf(Math.min(...spent)),
                    begin = performance.now();
                C.bear_run(way, 3);
                spent[way] += performance.now() - begin;
            });
        },
        draw(g, w, h) {
            const c = f.c;
            places().forEach((p, way) => {
                const data = new ImageData(
                    new Uint8ClampedArray(bytes(C.bear_picture(way), 4 * side * side)),
                    side,
                    side,
                );
                pictures[way].getContext("2d").putImageData(data, 0, 0);
                g.fillStyle = "#17161b";
                g.fillRect(p.x, p.y, p.s, p.s);
                g.imageSmoothingEnabled = false;
                g.drawImage(pictures[way], p.x, p.y, p.s, p.s);
                if (way === chosen) {
                    g.strokeStyle = c.accent;
                    g.lineWidth = 4;
                    g.strokeRect(p.x, p.y, p.s, p.s);
                }
                write(
                    g,
                    names[way] + (way === chosen ? ": the plan" : ""),
                    p.x,
                    p.y - 14,
                    way === chosen ? c.accent : c.ink,
                    "left",
                    14,
                    700,
                );
                write(g, says[way], p.x, p.y + p.s + 15, c.soft, "left", 12);
                write(
                    g,
                    (noise[way] > 0 ? "noise " + fixed(100 * noise[way], 1) + " %, " : "") +
                        fixed(C.bear_samples(way), 0) +
                        " spp",
                    p.x,
                    p.y + p.s + 33,
                    c.ink,
                    "left",
                    13,
                    600,
                );
            });
            // Where the sun stands, seen from above: the eye is below.
            const p = places()[0],
                x = p.x + p.s - 22,
                y = p.y + 22,
                a = turn * degree;
            dot(g, x, y, 12, null, "#8a857d");
            dot(g, x, y, 3, "#8a857d");
            dot(g, x + 12 * Math.sin(a), y + 12 * Math.cos(a), 5, "#ffe7b3");
        },
        show() {
            noise = names.map((_, way) => C.bear_noise(way));
            if (Math.min(...names.map((_, way) => C.bear_samples(way))) < 3) return;
            const mean = (way) => C.bear_mean(way, 0) + C.bear_mean(way, 1) + C.bear_mean(way, 2);
            const off = mean(1) / mean(3) - 1;
            error.set(
                (off < 0 ? "−" : "+") + fixed(100 * Math.abs(off), 0) + " %",
                Math.abs(off) > tolerance.value,
            );
            gain.set(fixed(Math.pow(noise[1] / noise[2], 2), 1) + " ×");
        },
        grabs: (x, y) => places().some((p) => x > p.x && x < p.x + p.s && y > p.y && y < p.y + p.s),
        drag(x, y, first) {
            if (first) this.from = [x, turn];
            turn = (this.from[1] + 0.6 * (x - this.from[0]) + 360) % 360;
            restart();
        },
        key(dx, dy) {
            if (!dx && !dy) return false;
            if (dx) turn = (turn + 6 * dx + 360) % 360;
            else thickness.value = clamp(thickness.value * Math.pow(1.1, -dy), 0.08, 1);
            restart();
        },
        begin: restart(),
        state: () => ({ turn, thickness: thickness.value }),
    };
});
