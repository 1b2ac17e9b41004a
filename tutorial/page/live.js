// live.js - what all live figures share: the frame around a canvas, controls, input, the clock.
// Plain JavaScript; the builder joins it with figures/*.js and the compiled header.
// SPDX-License-Identifier: MIT
//
// A figure is define(name, make). make(f) adds controls and numbers to f. It returns what the clock
// calls:
//   work(seconds)     once a frame while the figure is seen and not paused; false when it is done
//   draw(g, w, h)     after work, or when something changed; in CSS pixels
//   show()            ten times a second: writes the live numbers
//   grabs(x, y)       whether a drag may begin here; drag(x, y, first) then follows it
//   key(dx, dy, key)  arrow keys (dx, dy) and others
// All of them but draw may be missing.

const live = { figures: {}, makers: [], C: null };
window.live = live;

const define = (name, make) => live.makers.push([name, make]);
const still_eyes = matchMedia("(prefers-reduced-motion: reduce)").matches;

// ---- Numbers as people read them

const fixed = (x, digits) => (Number.isFinite(x) ? x.toFixed(digits) : "–");
const thousands = (x) =>
    Math.round(x)
        .toString()
        .replace(/\B(?=(\d{3})+$)/g, " ");
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

// ---- What C keeps in its memory; views are made anew, as memory may grow

const floats = (at, count) => new Float32Array(live.C.memory.buffer, at, count);
const doubles = (at, count) => new Float64Array(live.C.memory.buffer, at, count);
const bytes = (at, count) => new Uint8ClampedArray(live.C.memory.buffer, at, count);

// The probes and hits of the last run of a figure.
const probes_drawn = () => {
    const data = floats(live.C.probe_data(), 6 * live.C.probe_count()),
        list = [];
    for (let i = 0; i < data.length; i += 6) list.push(Array.from(data.subarray(i, i + 6)));
    return list;
};
const hits_drawn = () => {
    const data = floats(live.C.hit_data(), 6 * live.C.hit_count()),
        list = [];
    for (let i = 0; i < data.length; i += 6)
        list.push({
            x: data[i],
            y: data[i + 1],
            z: data[i + 2],
            r: data[i + 3],
            weight: data[i + 4],
            probe: data[i + 5],
        });
    return list;
};

// ---- Small things to draw with

const element = (tag, inside, attributes) => {
    const e = document.createElement(tag);
    Object.entries(attributes || {}).forEach(([key, value]) => e.setAttribute(key, value));
    if (inside) inside.append(e);
    return e;
};
// A line through points, each [x, y], by a pen: [colour, width, dashes].
const line = (g, [colour, width, dash], ...points) => {
    g.beginPath();
    points.forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
    g.strokeStyle = colour;
    g.lineWidth = width || 1;
    g.setLineDash(dash || []);
    g.stroke();
    g.setLineDash([]);
};
const polygon = (g, colour, ...points) => {
    g.beginPath();
    points.forEach(([x, y]) => g.lineTo(x, y));
    g.fillStyle = colour;
    g.fill();
};
const dot = (g, x, y, radius, colour, edge) => {
    g.beginPath();
    g.arc(x, y, Math.max(radius, 0.1), 0, 2 * Math.PI);
    if (colour) {
        g.fillStyle = colour;
        g.fill();
    }
    if (edge) {
        g.strokeStyle = edge;
        g.lineWidth = 1.5;
        g.stroke();
    }
};
const fonts = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
const write = (g, text, x, y, colour, align, size, weight, halo) => {
    g.font = (weight || 400) + " " + (size || 13) + "px " + fonts;
    g.textAlign = align || "left";
    g.textBaseline = "middle";
    if (halo) {
        g.strokeStyle = halo;
        g.lineWidth = 4;
        g.lineJoin = "round";
        g.strokeText(text, x, y);
    }
    g.fillStyle = colour;
    g.fillText(text, x, y);
};
// What a hand can take hold of looks the same everywhere.
const handle = (g, x, y, c) => {
    dot(g, x, y, 15, c.grip);
    dot(g, x, y, 7, c.accent, c.paper);
};

// An area of the canvas with axes in it: at(x, y) gives pixels. `log` axes take powers of ten.
const plot_places = (box, x, y) => {
    const value = (axis, v) =>
        axis.log
            ? Math.log(Math.max(v, 1e-30) / axis.from) / Math.log(axis.to / axis.from)
            : (v - axis.from) / (axis.to - axis.from);
    const px = (v) => box.x + box.w * value(x, v),
        py = (v) => box.y + box.h * (1 - value(y, v));
    return { x: px, y: py, at: (a, b) => [px(a), py(b)] };
};
const plot = (g, c, box, x, y) => {
    const q = plot_places(box, x, y),
        px = q.x,
        py = q.y;
    (y.ticks || []).forEach((v) => {
        line(g, [c.rule, 1], [box.x, py(v)], [box.x + box.w, py(v)]);
        write(g, String(v), box.x - 6, py(v), c.soft, "right", 12);
    });
    (x.ticks || []).forEach((v) =>
        write(g, String(v) + (x.unit || ""), px(v), box.y + box.h + 13, c.soft, "center", 12),
    );
    line(g, [c.soft, 1], [box.x, box.y + box.h], [box.x + box.w, box.y + box.h]);
    if (x.title) write(g, x.title, box.x + box.w, box.y + box.h + 30, c.soft, "right", 12);
    if (y.title) write(g, y.title, box.x - 6 - (y.shift || 0), box.y - 14, c.soft, "left", 12);
    return q;
};

// The weights of hits over their distance. The dots stay on a canvas of their own, so that each is
// drawn once.
const weight_cloud = (f, farthest) => {
    const canvas = document.createElement("canvas");
    const x = {
        from: 0.003,
        to: farthest,
        log: true,
        ticks: [0.01, 0.1, 1],
        title: "distance from the entry",
    };
    const y = {
        from: 0.1,
        to: 1000,
        log: true,
        ticks: [0.1, 1, 10, 100, 1000],
        title: "weight of a hit",
    };
    return {
        clear() {
            canvas.width = canvas.width;
        },
        // look(hit) is the radius and the colour of a dot. What is too heavy for the plot lies on
        // its upper edge.
        add(hits, box, look) {
            const w = Math.round(f.w * f.scale),
                h = Math.round(f.h * f.scale);
            if (canvas.width !== w || canvas.height !== h)
                Object.assign(canvas, { width: w, height: h });
            const g = canvas.getContext("2d"),
                q = plot_places(box, x, y);
            g.setTransform(f.scale, 0, 0, f.scale, 0, 0);
            g.globalAlpha = 0.5;
            hits.forEach((hit) => {
                const [px, py] = q.at(hit.r, hit.weight);
                if (px > box.x && px < box.x + box.w && py < box.y + box.h)
                    dot(g, px, Math.max(py, box.y), ...look(hit));
            });
        },
        draw(g, box) {
            const q = plot(g, f.c, box, x, y);
            g.drawImage(canvas, 0, 0, f.w, f.h);
            return q;
        },
    };
};

// ---- The frame around a figure

const read_colours = () => {
    const style = getComputedStyle(document.documentElement),
        c = {};
    [
        "ink",
        "soft",
        "rule",
        "paper",
        "panel",
        "accent",
        "grip",
        "blue",
        "orange",
        "green",
        "bad",
        "wax",
        "waxdeep",
        "air",
        "glow",
    ].forEach((name) => (c[name] = style.getPropertyValue("--" + name).trim()));
    return c;
};

class Frame {
    constructor(name, box) {
        this.name = name;
        this.box = box;
        this.dirty = true;
        this.seen = false;
        this.done = false;
        this.paused = false;
        this.cost = []; // milliseconds of work and drawing, the last 600 frames
        this.head = element("div", box, { class: "head" });
        this.canvas = element("canvas", element("div", box, { class: "stage" }), { tabindex: "0" });
        this.g = this.canvas.getContext("2d");
        this.controls = element("div", box, { class: "controls" });
        this.list = element("dl", box, { class: "numbers" });
        this.height = (w) => (w < 560 ? w : 0.5 * w);
    }

    title(text, say, keys) {
        element("h3", this.head).textContent = text;
        element("p", this.head).textContent = say;
        this.canvas.setAttribute("aria-label", text + ". " + say + " " + (keys || ""));
        this.canvas.setAttribute("role", keys ? "application" : "img");
        if (keys) element("p", this.head, { class: "keys" }).textContent = keys;
    }

    changed() {
        this.dirty = true;
        this.done = false;
    }

    // A slider; with `log` equal ways along it are equal factors.
    slider(label, from, to, value, options) {
        const o = Object.assign({ log: false, digits: 2, unit: "", change: () => {} }, options);
        const box = element("label", this.controls, { class: "slider" });
        element("span", box).textContent = label;
        const out = element("output", box);
        const input = element("input", box, { type: "range", min: 0, max: 1000, step: "any" });
        const control = {
            input,
            get value() {
                const t = input.value / 1000;
                return o.log ? from * Math.pow(to / from, t) : from + (to - from) * t;
            },
            set value(v) {
                input.value =
                    1000 *
                    (o.log ? Math.log(v / from) / Math.log(to / from) : (v - from) / (to - from));
                write_value();
            },
        };
        const write_value = () => {
            out.textContent = o.text
                ? o.text(control.value)
                : fixed(control.value, o.digits) + o.unit;
            input.setAttribute("aria-valuetext", out.textContent);
        };
        input.addEventListener("keydown", (e) => {
            // without steps the browser's keys would go too far
            const step = { ArrowLeft: -20, ArrowDown: -20, ArrowRight: 20, ArrowUp: 20 }[e.key];
            if (!step) return;
            e.preventDefault();
            input.value = Number(input.value) + step;
            input.dispatchEvent(new Event("input"));
        });
        input.addEventListener("input", () => {
            write_value();
            o.change();
            this.changed();
        });
        control.value = value;
        return control;
    }

    button(label, press) {
        const b = element("button", this.controls, { type: "button" });
        b.textContent = label;
        b.addEventListener("click", () => {
            press(b);
            this.changed();
        });
        return b;
    }

    check(label, on, change) {
        const box = element("label", this.controls, { class: "check" });
        const input = element("input", box, { type: "checkbox" });
        element("span", box).textContent = label;
        input.checked = on;
        input.addEventListener("change", () => {
            change(input);
            this.changed();
        });
        return input;
    }

    // One of several: [[value, label], ...].
    choice(label, options, value, change) {
        const box = element("fieldset", this.controls, { class: "choice" }),
            group = this.name + label;
        element("legend", box).textContent = label;
        const control = { value, inputs: {} };
        options.forEach(([v, text]) => {
            const one = element("label", box);
            const input = element("input", one, { type: "radio", name: group, value: v });
            element("span", one).textContent = text;
            control.inputs[v] = input;
            input.checked = v === value;
            input.addEventListener("change", () => {
                control.value = v;
                change();
                this.changed();
            });
        });
        return control;
    }

    number(label, colour) {
        const box = element("div", this.list);
        element("dt", box).textContent = label;
        const dd = element("dd", box);
        if (colour) box.classList.add(colour);
        return {
            box,
            dd,
            set(text, bad) {
                if (dd.textContent !== text) dd.textContent = text;
                box.classList.toggle("bad", Boolean(bad));
            },
        };
    }

    pause_button() {
        this.paused = still_eyes;
        const b = this.button("", () => {
            this.paused = !this.paused;
            label();
        });
        const label = () => (b.textContent = this.paused ? "Run" : "Pause");
        label();
        return b;
    }

    resize() {
        const w = this.canvas.parentNode.clientWidth,
            h = Math.round(this.height(w));
        const scale = Math.min(window.devicePixelRatio || 1, 2);
        if (w === this.w && h === this.h && scale === this.scale) return;
        Object.assign(this, { w, h, scale });
        this.canvas.style.height = h + "px";
        this.canvas.width = Math.round(w * scale);
        this.canvas.height = Math.round(h * scale);
        this.dirty = true;
    }

    listen() {
        const place = (e) => {
            const r = this.canvas.getBoundingClientRect();
            return [e.clientX - r.left, e.clientY - r.top];
        };
        const grabs = (x, y) => this.parts.drag && (!this.parts.grabs || this.parts.grabs(x, y));
        let held = false;
        const drag = (e, first) => {
            this.parts.drag(...place(e), first);
            this.changed();
        };
        this.canvas.addEventListener("pointerdown", (e) => {
            if (e.button || !grabs(...place(e))) return;
            held = true;
            this.canvas.setPointerCapture(e.pointerId);
            drag(e, true);
        });
        this.canvas.addEventListener("pointermove", (e) => {
            if (held) drag(e, false);
            else this.canvas.style.cursor = grabs(...place(e)) ? "grab" : "";
        });
        ["pointerup", "pointercancel"].forEach((end) =>
            this.canvas.addEventListener(end, () => (held = false)),
        );
        // A finger on a handle drags; elsewhere it scrolls the page.
        this.canvas.addEventListener(
            "touchstart",
            (e) => {
                if (grabs(...place(e.touches[0]))) e.preventDefault();
            },
            { passive: false },
        );
        const ways = {
            ArrowLeft: [-1, 0],
            ArrowRight: [1, 0],
            ArrowUp: [0, -1],
            ArrowDown: [0, 1],
        };
        this.canvas.addEventListener("keydown", (e) => {
            const [dx, dy] = ways[e.key] || [0, 0];
            if (!this.parts.key || e.ctrlKey || e.metaKey || e.altKey) return;
            if (this.parts.key(dx, dy, e.key) === false) return;
            e.preventDefault();
            this.changed();
        });
    }

    tick(seconds, now) {
        const begin = performance.now();
        if (this.parts.work && !this.paused && !this.done) {
            this.done = this.parts.work(seconds) === false;
            this.dirty = true;
        }
        if (!this.dirty || !this.w) return; // no width: the window is not laid out yet
        this.dirty = false;
        this.g.setTransform(this.scale, 0, 0, this.scale, 0, 0);
        this.g.clearRect(0, 0, this.w, this.h);
        this.g.lineJoin = this.g.lineCap = "round";
        this.parts.draw(this.g, this.w, this.h);
        if (this.parts.show && !(now - this.shown < 100)) {
            this.parts.show();
            this.shown = now;
        } else if (this.parts.show) this.dirty = true;
        this.cost.push(performance.now() - begin);
        if (this.cost.length > 600) this.cost.shift();
    }
}

// Calls step until the time for this frame is used up.
const spend = (milliseconds, step) => {
    const end = performance.now() + milliseconds;
    do step();
    while (performance.now() < end);
};

// ---- The clock

const start = async (code) => {
    const binary = Uint8Array.from(atob(code), (letter) => letter.charCodeAt(0));
    live.C = (await WebAssembly.instantiate(binary, {})).instance.exports;
    live.C.ball_begin();

    const all = [];
    live.makers.forEach(([name, make]) => {
        const box = document.getElementById("live-" + name);
        if (!box) return;
        box.classList.add("running");
        const f = new Frame(name, box);
        f.c = read_colours();
        f.parts = make(f);
        f.listen();
        f.resize();
        live.figures[name] = f;
        all.push(f);
    });

    const size = new ResizeObserver(() => all.forEach((f) => f.resize()));
    const sight = new IntersectionObserver((list) =>
        list.forEach((entry) => {
            const f = all.find((one) => one.box === entry.target);
            f.seen = entry.isIntersecting;
            f.dirty = f.dirty || f.seen;
        }),
    );
    all.forEach((f) => {
        size.observe(f.canvas.parentNode);
        sight.observe(f.box);
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () =>
        all.forEach((f) => {
            f.c = read_colours();
            f.dirty = true;
        }),
    );

    let before = performance.now();
    const tick = (now) => {
        requestAnimationFrame(tick); // first, so that an error in one figure stops no other
        const seconds = clamp((now - before) / 1000, 0, 0.1);
        before = now;
        all.forEach((f) => f.seen && f.tick(seconds, now));
    };
    requestAnimationFrame(tick);
};
