// Figure 2: a ball from Lambert to wax, without noise. And three of them at the top of the page.

// A direction from a place about a ball's centre, in radii: its rim is 90 degrees from the eye.
const towards = ([x, y]) => {
    const far = Math.hypot(x, y),
        angle = ((far < 1 ? 90 * far : 90 + 170 * (far - 1)) * Math.PI) / 180;
    const k = far > 0 ? Math.sin(angle) / far : 0;
    return [x * k, y * k, Math.cos(angle)];
};
// Light changes so slowly over a ball that a picture with fewer pixels than the canvas will do.
const paint_ball = (g, picture, ball, x, y, radius, scale, sun) => {
    const s = 2.1 * radius,
        side = Math.round(Math.min(0.8 * s * scale, 480));
    const data = bytes(live.C.ball_render(ball, side, side / 2.1, ...sun), 4 * side * side);
    if (picture.width !== side) picture.width = picture.height = side;
    picture
        .getContext("2d")
        .putImageData(new ImageData(new Uint8ClampedArray(data), side, side), 0, 0);
    g.drawImage(picture, x - s / 2, y - s / 2, s, s);
};

define("hero", (f) => {
    const C = live.C,
        picture = document.createElement("canvas"),
        reach = [0, 0.9, 2.8];
    let turn = 2.4,
        held = null;
    f.head.remove();
    f.controls.remove();
    f.list.remove();
    f.canvas.setAttribute(
        "aria-label",
        "Three balls in a sun that moves: plaster, and two of wax that light reaches deeper into",
    );
    f.canvas.setAttribute("role", "img");
    f.canvas.tabIndex = -1;
    reach.forEach((d, i) => {
        C.set_burley(11 + i, 0.86, 0.56, 0.27, d, 0.16 * d, 0.06 * d);
        C.ball_set(1 + i, 0.03);
    });
    f.height = (w) => clamp(0.36 * w, 150, 340);
    f.canvas.addEventListener("pointermove", (e) => {
        const r = f.canvas.getBoundingClientRect();
        held = [
            (e.clientX - r.left - f.w / 2) / (0.3 * f.w),
            (f.h / 2 - e.clientY + r.top) / (0.5 * f.h),
        ];
        f.changed();
    });
    f.canvas.addEventListener("pointerleave", () => (held = null));
    return {
        work(seconds) {
            if (still_eyes) return false;
            if (!held) turn += 0.35 * seconds;
        },
        draw(g, w, h) {
            const sun = held || [Math.cos(turn), 0.35 + 0.25 * Math.sin(0.7 * turn)],
                step = Math.min(w / 3, 1.25 * h);
            const way = towards([clamp(sun[0], -1.25, 1.25), clamp(sun[1], -0.8, 0.8)]);
            g.fillStyle = "#17161b";
            g.fillRect(0, 0, w, h);
            reach.forEach((d, i) =>
                paint_ball(
                    g,
                    picture,
                    1 + i,
                    w / 2 + (i - 1) * step,
                    h / 2,
                    Math.min(0.38 * h, 0.42 * step),
                    f.scale,
                    way,
                ),
            );
        },
    };
});
define("ball", (f) => {
    const C = live.C,
        sky = 0.03,
        degree = Math.PI / 180;
    const materials = {
        wax: { albedo: [0.86, 0.56, 0.27], reach: [1, 0.16, 0.06] },
        skin: { albedo: [0.78, 0.5, 0.38], reach: [1, 0.13, 0.06] },
        jade: { albedo: [0.4, 0.8, 0.55], reach: [0.12, 1, 0.2] },
        milk: { albedo: [0.92, 0.9, 0.84], reach: [1, 0.8, 0.42] },
    };
    let sun = [-0.86, 0.5]; // from the ball's centre; its rim, at 1, is 90 degrees from the eye
    const picture = document.createElement("canvas");

    f.title(
        "From plaster to wax",
        "Drag the sun around the ball, and let light travel farther. The edge of the " +
            "shadow softens, and the colour that travels farthest reaches deepest into it. " +
            "There is no noise: sss_within is summed over rings.",
        "Keys: arrows move the sun.",
    );
    const material = f.choice(
        "material",
        Object.keys(materials).map((m) => [m, m]),
        "wax",
        () => set(),
    );
    const dmfp = f.slider("how far light travels (dmfp)", 0.02, 16, 2.6, {
        log: true,
        text: (v) => (v < 0.0201 ? "0: Lambert" : v.toFixed(2) + " radii"),
        change: () => set(),
    });
    const lambert = f.check("beside it: Lambert", false, () => {});
    const names = [f.number("red, 20° into the shadow"), f.number("green"), f.number("blue")];
    const set = () => {
        const m = materials[material.value],
            d = dmfp.value < 0.0201 ? 0 : dmfp.value;
        C.set_burley(10, ...m.albedo, ...m.reach.map((k) => k * d));
        C.ball_set(0, sky);
    };
    set();

    const direction = () => towards(sun);
    // Places: the ball's square, and the plot beside or below it.
    const places = () => {
        const wide = f.w >= 640,
            side = wide ? f.h : f.w;
        const plot_box = wide
            ? { x: side + 56, y: 34, w: f.w - side - 80, h: f.h - 90 }
            : { x: 44, y: side + 34, w: f.w - 60, h: f.h - side - 84 };
        return { side, cx: side / 2, cy: side / 2, radius: 0.35 * side, plot_box };
    };
    const paint = (g, p) => paint_ball(g, picture, 0, p.cx, p.cy, p.radius, f.scale, direction());

    f.height = (w) => (w >= 640 ? 0.52 * w : w + 250);
    return {
        draw(g, w, h) {
            const c = f.c,
                p = places(),
                [sx, sy, sz] = direction();
            g.fillStyle = "#17161b";
            g.fillRect(0, 0, p.side, p.side);
            const x = p.cx + sun[0] * p.radius,
                y = p.cy - sun[1] * p.radius,
                behind = sz < 0;
            const glow = g.createRadialGradient(x, y, 0, x, y, 0.5 * p.side);
            glow.addColorStop(0, "rgba(255, 226, 170, 0.30)");
            glow.addColorStop(1, "rgba(255, 226, 170, 0)");
            g.fillStyle = glow;
            g.fillRect(0, 0, p.side, p.side);
            if (behind) dot(g, x, y, 11, "#ffe7b3");
            paint(g, p);
            if (lambert.checked) {
                // the half that the sun's arc cuts off below
                g.save();
                g.beginPath();
                g.rect(0, p.cy, p.side, p.side / 2);
                g.clip();
                const m = materials[material.value];
                C.set_burley(10, ...m.albedo, 0, 0, 0);
                C.ball_set(0, sky);
                paint(g, p);
                set();
                g.restore();
                line(
                    g,
                    ["#fff", 1],
                    [p.cx - 1.15 * p.radius, p.cy],
                    [p.cx + 1.15 * p.radius, p.cy],
                );
                write(g, "Lambert", p.cx, p.cy + p.radius + 18, "#fff", "center", 13, 600);
                write(g, material.value, p.cx, p.cy - p.radius - 18, "#fff", "center", 13, 600);
            }
            dot(g, x, y, 17, "rgba(255, 231, 179, 0.25)");
            dot(g, x, y, 10, behind ? "#b78d3e" : "#ffe7b3", "#fff");
            write(
                g,
                behind ? "sun, behind" : "sun",
                clamp(x, 50, p.side - 50),
                y + (sun[1] > 0 ? -28 : 28),
                "#fff",
                "center",
                13,
                600,
                "#17161b",
            );

            const b = p.plot_box;
            const m = materials[material.value],
                top = 1;
            const q = plot(
                g,
                c,
                b,
                {
                    from: 0,
                    to: 180,
                    ticks: [0, 45, 90, 135, 180],
                    unit: "°",
                    title: "angle from the sun",
                },
                { from: 0, to: top, ticks: [0, 0.5, 1], title: "light that leaves" },
            );
            line(g, [c.rule, 1.5, [2, 4]], q.at(90, 0), q.at(90, top));
            write(g, "terminator", ...q.at(92, top - 0.03), c.soft, "left", 12);
            [
                [0, c.orange, [], "red"],
                [1, c.green, [9, 5], "green"],
                [2, c.blue, [2, 5], "blue"],
            ].forEach(([k, colour, dash, name]) => {
                const flat = [],
                    curve = [];
                for (let a = 0; a <= 180; a += 2) {
                    flat.push(q.at(a, m.albedo[k] * Math.max(0, Math.cos(a * degree))));
                    curve.push(q.at(a, C.ball_light(0, k, Math.cos(a * degree))));
                }
                g.globalAlpha = 0.45;
                line(g, [colour, 1.2], ...flat);
                g.globalAlpha = 1;
                line(g, [colour, 2.5, dash], ...curve);
                write(
                    g,
                    name,
                    ...q.at(4, C.ball_light(0, k, 1) + 0.045),
                    colour,
                    "left",
                    13,
                    600,
                    c.panel,
                );
            });
            write(g, "thin: Lambert", b.x + b.w, b.y + 24, c.soft, "right", 12);
        },
        show() {
            names.forEach((n, k) => n.set(fixed(C.ball_light(0, k, Math.cos(110 * degree)), 3)));
        },
        grabs(x, y) {
            const p = places();
            return (
                (x < p.side &&
                    y < p.side &&
                    Math.hypot(x - p.cx - sun[0] * p.radius, y - p.cy + sun[1] * p.radius) < 60) ||
                Math.hypot(x - p.cx, y - p.cy) < p.radius
            );
        },
        drag(x, y) {
            const p = places(),
                far = Math.hypot(x - p.cx, y - p.cy) / p.radius,
                k = Math.min(1, 1.36 / far) / p.radius;
            sun = [(x - p.cx) * k, (p.cy - y) * k];
        },
        key(dx, dy) {
            if (!dx && !dy) return false;
            const to = [sun[0] + 0.06 * dx, sun[1] - 0.06 * dy],
                k = Math.min(1, 1.36 / Math.hypot(...to));
            sun = to.map((x) => x * k);
        },
        places,
        state: () => ({ sun }),
    };
});
