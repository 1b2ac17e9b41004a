// Figure 5: chords cross a patch as often however it is turned, so all their hits weigh the same.
define("chord", (f) => {
    const C = live.C,
        degree = Math.PI / 180,
        size = 0.26,
        most = 3e6;
    let place = [0.15, 0.1],
        angle = 25,
        lines = [[], []],
        rate = [0, 0],
        seen = [0, 0],
        entry = 0.62,
        seed = 1,
        wait = 0;
    let spike = [
        { probes: [], hits: [] },
        { probes: [], hits: [] },
    ];
    const cloud = weight_cloud(f, 3);

    f.title(
        "Chords cross a patch equally often",
        "Move the patch and turn it. The chords cross it equally often, wherever it is and " +
            "however it is turned. Parallel lines miss it when it turns away. So on " +
            "a spike every hit of a chord weighs 2, and a hit of a disk may weigh hundreds.",
        "Keys: arrows move the patch or the entry, the comma and the full stop turn the patch.",
    );
    const tab = f.choice(
        "show",
        [
            ["patch", "a patch in a ball"],
            ["spike", "a spike"],
        ],
        "patch",
        () => restart(),
    );
    const turn = f.slider("turn the patch", -90, 90, angle, {
        digits: 0,
        unit: "°",
        change: () => ((angle = turn.value), restart()),
    });
    const width = f.slider("width of the spike", 0.08, 0.8, 0.2, {
        log: true,
        change: () => restart(),
    });
    f.pause_button();
    const numbers = {
        a: f.number("", "blue"),
        b: f.number("", "orange"),
        c: f.number("", "blue"),
        d: f.number("", "orange"),
    };
    const is_patch = () => tab.value === "patch";

    const restart = () => {
        lines = [[], []];
        rate = [0, 0];
        seen = [0, 0];
        cloud.clear();
        C.spike_begin(width.value, entry, seed);
        const label = is_patch()
            ? ["chords: crossings over expected", "parallel lines: over those facing", "", ""]
            : ["chords: largest weight", "disks: largest weight", "chords: mean", "disks: mean"];
        Object.values(numbers).forEach((n, i) => {
            n.box.firstChild.textContent = label[i];
            n.box.hidden = !label[i];
        });
        turn.input.parentNode.hidden = !is_patch();
        width.input.parentNode.hidden = is_patch();
        wait = 0;
        f.changed();
    };

    // Crossings of the patch: many to count, some to draw. Of all chords of the unit ball the part
    // A / (2 pi) crosses a patch of area A; of parallel lines the part A / pi, if it faces them.
    const count_patch = (way) => {
        const n = [Math.sin(angle * degree), Math.cos(angle * degree)];
        C.patch_begin(seed++);
        C.patch_run(4000, way, ...place, ...n, size);
        const fresh = (C.patch_rate() * (way ? 1 : 2)) / (size * size);
        rate[way] = (rate[way] * seen[way] + fresh * 4000) / (seen[way] + 4000);
        seen[way] = Math.min(seen[way] + 4000, most);
        C.patch_run(3, way, ...place, ...n, size);
        const hit = new Set(hits_drawn().map((one) => one.probe));
        probes_drawn().forEach((ends, i) => lines[way].push({ ends, crosses: hit.has(i) }));
        while (lines[way].length > 110) lines[way].shift();
    };

    const places = () => {
        const wide = f.w >= 640,
            half = f.w / 2;
        if (is_patch())
            return [0, 1].map((i) => ({
                x: half * (i + 0.5),
                y: 0.46 * f.h,
                r: Math.min(0.44 * half, 0.38 * f.h),
            }));
        const w = wide ? 0.27 * f.w : half,
            h = wide ? f.h : 0.95 * f.w;
        const all = [0, 1].map((i) => ({ x: w * (i + 0.5), y: h / 2, r: 0.43 * h, w, h }));
        all.box = wide
            ? { x: 2 * w + 62, y: 40, w: f.w - 2 * w - 84, h: f.h - 96 }
            : { x: 48, y: h + 40, w: f.w - 64, h: f.h - h - 90 };
        return all;
    };
    // Where the patch or the entry is in one of the two panels.
    const entry_at = (p) => {
        const [x, z] = is_patch() ? place : [width.value * Math.sqrt(1 - entry * entry), entry];
        return [p.x + x * p.r, p.y - z * p.r];
    };

    const draw_patch = (g, c, p, way) => {
        const colour = way ? c.orange : c.blue,
            at = (x, z) => [p.x + x * p.r, p.y - z * p.r];
        dot(g, p.x, p.y, p.r, c.air, c.rule);
        g.save();
        g.beginPath();
        g.arc(p.x, p.y, p.r, 0, 2 * Math.PI);
        g.clip();
        lines[way].forEach(({ ends, crosses }) => {
            g.globalAlpha = crosses ? 1 : 0.28;
            line(
                g,
                [crosses ? colour : c.soft, crosses ? 1.8 : 0.8],
                at(ends[0], ends[2]),
                at(ends[3], ends[5]),
            );
        });
        g.globalAlpha = 1;
        g.restore();
        const tx = Math.cos(angle * degree) * size,
            tz = -Math.sin(angle * degree) * size;
        line(g, [c.ink, 5], at(place[0] - tx, place[1] - tz), at(place[0] + tx, place[1] + tz));
        handle(g, ...entry_at(p), c);
        const [x, y] = at(
            place[0] + 0.3 * Math.sin(angle * degree),
            place[1] + 0.3 * Math.cos(angle * degree),
        );
        line(g, [c.accent, 2], at(...place), [x, y]);
        dot(g, x, y, 5, c.paper, c.accent);
        write(g, way ? "parallel lines" : "chords", p.x, p.y - p.r - 16, colour, "center", 14, 700);

        const bar = 1.4 * p.r,
            x0 = p.x - bar / 2,
            y0 = p.y + p.r + 24;
        g.fillStyle = colour;
        g.fillRect(x0, y0 - 7, (bar * clamp(rate[way], 0, 1.15)) / 1.15, 14);
        line(g, [c.ink, 1.5], [x0 + bar / 1.15, y0 - 12], [x0 + bar / 1.15, y0 + 12]);
        write(
            g,
            fixed(rate[way], 2) +
                (p.r < 120 ? " ×" : way ? " × what crosses if it faces them" : " × expected"),
            p.x,
            y0 + 22,
            c.ink,
            "center",
            13,
            600,
        );
    };
    const draw_spike = (g, c, p, way) => {
        const at = (x, z) => [p.x + x * p.r, p.y - z * p.r],
            colour = way ? c.orange : c.blue;
        g.save();
        g.beginPath();
        g.rect(p.x - p.w / 2, 0, p.w, p.h);
        g.clip();
        g.fillStyle = c.air;
        g.fillRect(p.x - p.w / 2 + 1, 0, p.w - 2, p.h);
        g.beginPath();
        g.ellipse(p.x, p.y, width.value * p.r, p.r, 0, 0, 2 * Math.PI);
        g.fillStyle = c.wax;
        g.fill();
        g.strokeStyle = c.ink;
        g.lineWidth = 1.5;
        g.stroke();
        spike[way].probes.forEach(([ax, , az, bx, , bz]) =>
            line(g, [c.soft, 0.7], at(ax, az), at(bx, bz)),
        );
        g.globalAlpha = 0.8;
        spike[way].hits.forEach((hit) =>
            dot(g, ...at(hit.x, hit.z), clamp(3 * Math.sqrt(hit.weight), 1.5, 50), colour, c.paper),
        );
        g.globalAlpha = 1;
        handle(g, ...entry_at(p), c);
        write(g, way ? "disks" : "chords", p.x - p.w / 2 + 12, 20, colour, "left", 14, 700, c.air);
        g.restore();
    };

    f.height = (w) => (w >= 640 ? 0.52 * w : is_patch() ? 0.72 * w : 0.95 * w + 320);
    return {
        work(seconds) {
            f.resize();
            if (is_patch()) {
                count_patch(0);
                count_patch(1);
                return;
            }
            if (C.spike_count(0) >= 400000) return false;
            wait -= seconds;
            [0, 1].forEach((way) => {
                C.spike_run(way ? 1500 : 200, way ? 0 : 1);
                const hits = hits_drawn();
                cloud.add(hits, places().box, () => [1.4, way ? f.c.orange : f.c.blue]);
                if (wait <= 0)
                    spike[way] = {
                        probes: probes_drawn().slice(0, 22),
                        hits: hits.filter((hit) => hit.probe < 22),
                    };
            });
            if (wait <= 0) wait = 0.9;
        },
        draw(g, w, h) {
            const c = f.c,
                p = places();
            if (is_patch()) return [0, 1].forEach((way) => draw_patch(g, c, p[way], way));
            [0, 1].forEach((way) => draw_spike(g, c, p[way], way));
            const q = cloud.draw(g, p.box);
            write(
                g,
                "chords: always 2",
                p.box.x + 8,
                q.y(2) - 14,
                c.blue,
                "left",
                13,
                600,
                c.panel,
            );
            write(g, "disks", p.box.x + p.box.w - 4, q.y(120), c.orange, "right", 13, 600, c.panel);
        },
        show() {
            if (is_patch()) {
                numbers.a.set(fixed(rate[0], 3));
                numbers.b.set(fixed(rate[1], 3));
                return;
            }
            numbers.a.set(fixed(C.spike_largest(1), 2));
            numbers.b.set(fixed(C.spike_largest(0), C.spike_largest(0) < 100 ? 1 : 0));
            numbers.c.set(fixed(C.spike_mean(1), 3));
            numbers.d.set(fixed(C.spike_mean(0), 3));
        },
        grabs(x, y) {
            return places().some((p) => {
                const [ex, ey] = entry_at(p);
                return Math.hypot(x - ex, y - ey) < 50;
            });
        },
        drag(x, y, first) {
            const list = places(),
                p = list[first ? (x < (list[0].x + list[1].x) / 2 ? 0 : 1) : this.panel];
            const px = (x - p.x) / p.r,
                pz = (p.y - y) / p.r;
            if (first) {
                this.panel = list.indexOf(p);
                this.turns =
                    is_patch() &&
                    Math.hypot(
                        px - place[0] - 0.3 * Math.sin(angle * degree),
                        pz - place[1] - 0.3 * Math.cos(angle * degree),
                    ) *
                        p.r <
                        18;
            }
            if (!is_patch()) entry = clamp(pz, -0.9, 0.97);
            else if (this.turns) {
                const a = Math.atan2(px - place[0], pz - place[1]) / degree;
                angle = a > 90 ? a - 180 : a < -90 ? a + 180 : a;
                turn.value = angle;
            } else {
                const k = Math.min(1, 0.72 / Math.hypot(px, pz));
                place = [px * k, pz * k];
            }
            restart();
        },
        key(dx, dy, key) {
            if (key === "," || key === ".")
                turn.value = angle = clamp(angle + (key === "," ? -5 : 5), -90, 90);
            else if (!dx && !dy) return false;
            else if (is_patch()) {
                const to = [place[0] + 0.05 * dx, place[1] - 0.05 * dy],
                    k = Math.min(1, 0.72 / Math.hypot(...to));
                place = to.map((x) => x * k);
            } else entry = clamp(entry - 0.05 * dy + 0.05 * dx, -0.9, 0.97);
            restart();
        },
        begin: restart(),
        handle: () => entry_at(places()[0]),
        state: () => ({ place, angle, entry }),
    };
});
