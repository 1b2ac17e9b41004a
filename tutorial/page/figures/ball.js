// Figure 2: a ball from Lambert to wax, without noise.
define("ball", (f) => {
    const C = live.C, sky = 0.05, degree = Math.PI / 180;
    const materials = {
        wax: { albedo: [0.86, 0.56, 0.27], reach: [1, 0.16, 0.06] },
        skin: { albedo: [0.78, 0.5, 0.38], reach: [1, 0.13, 0.06] },
        jade: { albedo: [0.4, 0.8, 0.55], reach: [0.12, 1, 0.2] },
        milk: { albedo: [0.92, 0.9, 0.84], reach: [1, 0.8, 0.42] },
    };
    let sun = [-0.86, 0.5]; // from the ball's centre; its rim, at 1, is 90 degrees from the eye
    const picture = document.createElement("canvas");

    f.title("From plaster to wax", "Drag the sun around the ball, and let light travel farther. The edge of the " +
        "shadow softens, and the colour that travels farthest reaches deepest into it. There is no noise: the figure sums sss_within over rings.",
        "Keys: arrows move the sun.");
    const material = f.choice("material", Object.keys(materials).map((m) => [m, m]), "wax", () => set());
    const dmfp = f.slider("how far light travels (dmfp)", 0.02, 16, 2.6, {
        log: true, text: (v) => (v < 0.0201 ? "0: Lambert" : v.toFixed(2) + " radii"), change: () => set(),
    });
    const lambert = f.check("beside it: Lambert", false, () => {});
    const names = [f.number("red, 20° into the shadow"), f.number("green"), f.number("blue")];
    const set = () => {
        const m = materials[material.value], d = dmfp.value < 0.0201 ? 0 : dmfp.value;
        C.set_burley(2, ...m.albedo, ...m.reach.map((k) => k * d));
        C.ball_set();
    };
    set();

    const direction = () => {
        const far = Math.hypot(...sun), angle = (far < 1 ? 90 * far : 90 + 170 * (far - 1)) * degree, k = far > 0 ? Math.sin(angle) / far : 0;
        return [sun[0] * k, sun[1] * k, Math.cos(angle)];
    };
    // Places: the ball's square, and the plot beside or below it.
    const places = () => {
        const wide = f.w >= 640, side = wide ? f.h : f.w;
        const plot_box = wide ? { x: side + 56, y: 34, w: f.w - side - 80, h: f.h - 90 }
            : { x: 44, y: side + 34, w: f.w - 60, h: f.h - side - 84 };
        return { side, cx: side / 2, cy: side / 2, radius: 0.35 * side, plot_box };
    };
    const paint = (g, p) => {
        const pixels = Math.min(Math.round(2.1 * p.radius * f.scale), 520), radius = pixels / 2.1;
        const data = bytes(C.ball_render(pixels, radius, ...direction(), sky), 4 * pixels * pixels);
        picture.width = picture.height = pixels;
        picture.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(data), pixels, pixels), 0, 0);
        const s = 2.1 * p.radius;
        g.drawImage(picture, p.cx - s / 2, p.cy - s / 2, s, s);
    };

    f.height = (w) => (w >= 640 ? 0.52 * w : w + 250);
    return {
        draw(g, w, h) {
            const c = f.c, p = places(), [sx, sy, sz] = direction();
            g.fillStyle = "#17161b";
            g.fillRect(0, 0, p.side, p.side);
            const x = p.cx + sun[0] * p.radius, y = p.cy - sun[1] * p.radius, behind = sz < 0;
            const glow = g.createRadialGradient(x, y, 0, x, y, 0.5 * p.side);
            glow.addColorStop(0, "rgba(255, 226, 170, 0.30)");
            glow.addColorStop(1, "rgba(255, 226, 170, 0)");
            g.fillStyle = glow;
            g.fillRect(0, 0, p.side, p.side);
            if (behind) dot(g, x, y, 11, "#ffe7b3");
            paint(g, p);
            if (lambert.checked) { // the half that the sun's arc cuts off below
                g.save();
                g.beginPath();
                g.rect(0, p.cy, p.side, p.side / 2);
                g.clip();
                const m = materials[material.value];
                C.set_burley(2, ...m.albedo, 0, 0, 0);
                C.ball_set();
                paint(g, p);
                set();
                g.restore();
                line(g, [[p.cx - 1.15 * p.radius, p.cy], [p.cx + 1.15 * p.radius, p.cy]], "#fff", 1);
                write(g, "Lambert", p.cx, p.cy + p.radius + 18, "#fff", "center", 13, 600);
                write(g, material.value, p.cx, p.cy - p.radius - 18, "#fff", "center", 13, 600);
            }
            dot(g, x, y, 17, "rgba(255, 231, 179, 0.25)");
            dot(g, x, y, 10, behind ? "#b78d3e" : "#ffe7b3", "#fff");
            write(g, behind ? "sun, behind" : "sun", clamp(x, 50, p.side - 50), y + (sun[1] > 0 ? -28 : 28), "#fff", "center", 13, 600, "#17161b");

            const b = p.plot_box;
            const m = materials[material.value], top = 1;
            const q = plot(g, c, b, { from: 0, to: 180, ticks: [0, 45, 90, 135, 180], unit: "°",
                title: "angle from the sun" }, { from: 0, to: top, ticks: [0, 0.5, 1], title: "light that leaves" });
            line(g, [q.at(90, 0), q.at(90, top)], c.rule, 1.5, [2, 4]);
            write(g, "terminator", ...q.at(92, top - 0.03), c.soft, "left", 12);
            [[0, c.orange, [], "red"], [1, c.green, [9, 5], "green"], [2, c.blue, [2, 5], "blue"]].forEach(([k, colour, dash, name]) => {
                const flat = [], curve = [];
                for (let a = 0; a <= 180; a += 2) {
                    flat.push(q.at(a, m.albedo[k] * Math.max(0, Math.cos(a * degree))));
                    curve.push(q.at(a, C.ball_light(k, Math.cos(a * degree))));
                }
                g.globalAlpha = 0.45;
                line(g, flat, colour, 1.2);
                g.globalAlpha = 1;
                line(g, curve, colour, 2.5, dash);
                write(g, name, ...q.at(4, C.ball_light(k, 1) + 0.045), colour, "left", 13, 600, c.panel);
            });
            write(g, "thin: Lambert", b.x + b.w, b.y + 24, c.soft, "right", 12);
        },
        show() { names.forEach((n, k) => n.set(fixed(C.ball_light(k, Math.cos(110 * degree)), 3))); },
        grabs(x, y) {
            const p = places();
            return x < p.side && y < p.side && Math.hypot(x - p.cx - sun[0] * p.radius, y - p.cy + sun[1] * p.radius) < 60 ||
                Math.hypot(x - p.cx, y - p.cy) < p.radius;
        },
        drag(x, y) {
            const p = places(), far = Math.hypot(x - p.cx, y - p.cy) / p.radius, k = Math.min(1, 1.36 / far) / p.radius;
            sun = [(x - p.cx) * k, (p.cy - y) * k];
        },
        key(dx, dy) {
            if (!dx && !dy) return false;
            const to = [sun[0] + 0.06 * dx, sun[1] - 0.06 * dy], k = Math.min(1, 1.36 / Math.hypot(...to));
            sun = to.map((x) => x * k);
        },
        state: () => ({ sun }),
    };
});
