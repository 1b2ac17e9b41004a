"""Draws the drawings of the chapters as SVG: draw.py [FOLDER], else into this folder.

Coordinates are pixels of a sheet 640 wide, y downwards. Colours are those of the page, with a set
for dark ones. SPDX-License-Identifier: MIT
"""

import math
import os
import random
import sys

STYLE = """
svg { color-scheme: light dark; }
text { font: 19px system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif; fill: #231f1a; }
.small { font-size: 16px; fill: #6b6257; }
.it { font-style: italic; }
.b { font-weight: 600; }
.ink { stroke: #231f1a; }
.soft { stroke: #9b9084; }
.blue { stroke: #00639c; }
.orange { stroke: #c65a00; }
.line { fill: none; stroke-width: 2; stroke-linecap: round; stroke-linejoin: round; }
.thin { stroke-width: 1.2; } .thick { stroke-width: 5; } .dash { stroke-dasharray: 5 5; }
.wax { fill: #f8e2bd; }
.f-ink { fill: #231f1a; }
.f-blue { fill: #00639c; }
.f-orange { fill: #c65a00; }
.f-soft { fill: #9b9084; }
.f-paper { fill: #fdfaf5; }
.pale { opacity: 0.25; }
.half { opacity: 0.6; }
@media (prefers-color-scheme: dark) {
text { fill: #ece5da; } .small { fill: #a89f93; }
.ink { stroke: #ece5da; }
.soft { stroke: #857c72; }
.blue { stroke: #6cbcf0; }
.orange { stroke: #f0a04b; }
.wax { fill: #5b3a1c; }
.f-ink { fill: #ece5da; }
.f-blue { fill: #6cbcf0; }
.f-orange { fill: #f0a04b; }
.f-soft { fill: #857c72; }
.f-paper { fill: #16151a; }
}
"""


class Sheet:
    def __init__(self, name, title, height=300):
        self.name, self.title, self.height, self.parts = name, title, height, []

    def path(self, points, look, closed=False):
        text = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points) + (" Z" if closed else "")
        self.parts.append(f'<path d="{text}" class="{look}"/>')

    def dot(self, at, radius, look):
        self.parts.append(
            f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius:.1f}" class="{look}"/>'
        )

    def box(self, x, y, w, h, look):
        self.parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" class="{look}"/>'
        )

    def text(self, x, y, words, look="", anchor="start"):
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" class="{look}" text-anchor="{anchor}">{words}</text>'
        )

    def arrow(self, a, b, colour, look="line", head=11):
        way = math.atan2(b[1] - a[1], b[0] - a[0])
        neck = (b[0] - 0.8 * head * math.cos(way), b[1] - 0.8 * head * math.sin(way))
        sides = [
            (b[0] - head * math.cos(way + k), b[1] - head * math.sin(way + k))
            for k in (0.42, -0.42)
        ]
        self.path([a, neck], f"{look} {colour}")
        self.path([sides[0], b, sides[1]], f"f-{colour}", closed=True)

    def save(self, folder):
        h, inside = self.height, "\n".join(self.parts)
        size = f'viewBox="0 0 640 {h}" width="640" height="{h}"'
        with open(os.path.join(folder, self.name + ".svg"), "w", encoding="utf-8") as file:
            file.write(f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">\n')
            file.write(f"<title>{self.title}</title>\n<style>{STYLE}</style>\n{inside}\n</svg>\n")


def sub(letter, below):
    return f"{letter}<tspan baseline-shift='sub' font-size='13'>{below}</tspan>"


def curve(f, x0, x1, steps=80):
    return [(x0 + (x1 - x0) * i / steps, f(x0 + (x1 - x0) * i / steps)) for i in range(steps + 1)]


def surface(s, f, x0=0, x1=640):
    """The object below a curve."""
    top = curve(f, x0, x1)
    s.path(top + [(x1, s.height), (x0, s.height)], "wax", closed=True)
    s.path(top, "line ink")


def between(a, b, t):
    return (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))


def points():
    s = Sheet(
        "points", "The camera path enters at x and leaves at y; light goes the same way back", 330
    )

    def top(x):
        return 165 - 26 * math.cos((x - 325) / 130)

    surface(s, top)
    x, y, eye, sun = (205, top(205)), (445, top(445)), (62, 46), (578, 52)

    # Inside, a walk that joins the two; what it does in there, the profile knows only in the mean.
    walk = [
        x,
        (226, 226),
        (262, 200),
        (290, 262),
        (338, 212),
        (362, 270),
        (405, 222),
        (420, 246),
        y,
    ]
    s.path(walk, "line blue")
    s.path([(px, py + 7) for px, py in walk[1:-1]], "line orange dash")
    s.arrow((eye[0] + 26, eye[1] + 12), (x[0] - 8, x[1] - 8), "blue")
    s.arrow((x[0] - 20, x[1] - 4), (eye[0] + 18, eye[1] + 26), "orange", "line dash")
    s.arrow((y[0] + 6, y[1] - 8), (sun[0] - 26, sun[1] + 12), "blue")
    s.arrow((sun[0] - 16, sun[1] + 24), (y[0] + 18, y[1] - 3), "orange", "line dash")

    s.box(eye[0] - 22, eye[1] - 14, 30, 26, "f-ink")
    s.path(
        [
            (eye[0] + 8, eye[1] - 4),
            (eye[0] + 20, eye[1] - 12),
            (eye[0] + 20, eye[1] + 10),
            (eye[0] + 8, eye[1] + 2),
        ],
        "f-ink",
        closed=True,
    )
    s.dot(sun, 15, "f-orange")
    for i in range(12):
        c, q = math.cos(i * math.pi / 6), math.sin(i * math.pi / 6)
        s.path(
            [(sun[0] + 19 * c, sun[1] + 19 * q), (sun[0] + 26 * c, sun[1] + 26 * q)], "line orange"
        )
    for at in (x, y):
        s.dot(at, 6, "f-ink")
    s.text(x[0] - 10, x[1] + 48, "x, the entry", "b", "end")
    s.text(y[0] + 10, y[1] + 48, "y, the exit", "b")
    s.text(320, 26, "camera path: in at x, out at y", "b f-blue", "middle")
    s.text(320, 48, "light: in at y, out at x", "b f-orange", "middle")
    s.text(
        320,
        318,
        "The profile depends only on the distance |y - x|.",
        "small",
        "middle",
    )
    return s


def shadow():
    s = Sheet(
        "shadow", "A piece of surface casts a shadow on the disk that is its size times the cosine"
    )
    x = (215, 110)

    def top(px):
        return x[1] + 0.0016 * (px - x[0]) ** 2

    surface(s, top)
    a, b = 400, 455
    slope = 0.0032 * (0.5 * (a + b) - x[0])
    s.path([(a, x[1]), (b, x[1]), (b, top(b)), (a, top(a))], "f-blue pale", closed=True)
    s.path([(30, x[1]), (570, x[1])], "line ink dash")
    s.path([(a, x[1]), (b, x[1])], "line thick blue")
    s.path(curve(top, a, b), "line thick blue")
    for px in (70, 120, 165, 190, 240, 262, 310, 350):
        s.path([(px, x[1] - 24), (px, top(px) + 24)], "line thin soft dash")
    s.arrow(x, (x[0], x[1] - 90), "ink")
    s.text(x[0] + 10, x[1] - 74, "n", "it b")
    m = (0.5 * (a + b), top(0.5 * (a + b)))
    k = 70 / math.hypot(1, slope)
    s.arrow(m, (m[0] + k * slope, m[1] - k), "ink")
    s.text(
        m[0] + k * slope + 8,
        m[1] - k + 4,
        sub("n", "y"),
        "it b",
    )
    s.dot(x, 6, "f-ink")
    s.text(x[0] - 12, x[1] + 26, "x", "it b", "end")
    s.text(570, x[1] - 14, "the disk", "", "end")
    s.text(
        0.5 * (a + b),
        x[1] - 18,
        f"|n·{sub('n', 'y')}| dS",
        "b f-blue",
        "middle",
    )
    s.text(m[0] - 24, m[1] + 30, "dS", "b f-blue", "end")
    return s


def radii():
    s = Sheet("radii", "r is the straight distance from x to y, r_a that from the axis through x")

    def top(x):
        return 70 + 0.0021 * (x - 160) ** 2

    surface(s, top)
    x, y = (160, top(160)), (388, top(388))
    s.path([(160, 12), (160, 292)], "line soft dash")
    s.path([x, y], "line blue")
    s.path([(160, y[1]), y], "line orange")
    s.path([(388, 12), y], "line thin ink dash")
    s.arrow((388, y[1] - 70), (388, y[1] - 9), "ink", "line thin")
    for at in (x, y):
        s.dot(at, 6, "f-ink")
    s.text(146, 62, "x", "it b", "end")
    s.text(404, y[1] - 2, "y", "it b")
    s.text(400, 28, "probe, along the axis")
    s.text(152, 286, "axis", "", "end")
    s.text(262, 112, "r", "it b f-blue", "end")
    s.text(280, y[1] + 22, sub("r", "a"), "it b f-orange")
    s.text(420, 78, "r: what the", "b f-blue")
    s.text(420, 101, "profile weighs", "b f-blue")
    s.text(420, 136, f"{sub('r', 'a')}: where the", "b f-orange")
    s.text(420, 159, "probe was drawn", "b f-orange")
    return s


def axes():
    s = Sheet(
        "axes", "In a crease the normal's probes graze the other wall, those of a tangent meet it"
    )
    edge, left, right = (300, 240), (40, 120), (392, 20)
    s.path([left, edge, (399, 0), (640, 0), (640, 300), (0, 300), (0, 102)], "wax", closed=True)
    s.path([(0, 101.5), edge, (399, 0)], "line ink")
    x = between(edge, left, 0.45)
    way = math.atan2(edge[1] - left[1], edge[0] - left[0])
    t, n = (math.cos(way), math.sin(way)), (math.sin(way), -math.cos(way))

    def go(o, d, k):
        return (o[0] + k * d[0], o[1] + k * d[1])

    # Along the normal nearly parallel to the wall, along the tangent nearly at right angles to it.
    wall = (right[0] - edge[0], right[1] - edge[1])
    for k in (-75, -35, 30, 60, 105):
        o = go(x, t, k)
        s.path([go(o, n, -70), go(o, n, 150)], "line thin orange dash")
        s.dot(o, 4.5, "f-orange")
    for k in (25, 60, 100):
        o = go(x, n, k)
        cross = (edge[0] - o[0]) * wall[1] - (edge[1] - o[1]) * wall[0]
        hit = go(o, t, cross / (t[0] * wall[1] - t[1] * wall[0]))
        s.path([go(o, t, -70), go(hit, t, 40)], "line thin blue")
        s.dot(hit, 5.5, "f-blue")
    s.arrow(x, go(x, n, 80), "ink")
    s.arrow(x, go(x, t, 80), "ink")
    s.dot(x, 6, "f-ink")
    s.dot(go(go(x, t, -16), n, -16), 9, "line ink")
    s.dot(go(go(x, t, -16), n, -16), 2.5, "f-ink")
    s.text(go(x, n, 88)[0] + 4, go(x, n, 88)[1] + 4, "n", "it b")
    s.text(go(x, t, 84)[0] - 4, go(x, t, 84)[1] + 20, "t", "it b")
    s.text(x[0] - 48, x[1] + 14, "b", "it b")
    s.text(426, 88, "along n: 1/2", "b f-orange")
    s.text(426, 111, "grazes the other wall")
    s.text(426, 151, "along t: 1/4", "b f-blue")
    s.text(426, 174, "meets it squarely")
    s.text(426, 214, "along b: 1/4", "b")
    s.text(426, 237, "out of the page")
    return s


def sphere():
    s = Sheet("sphere", "Lines in all directions through a point o at the depth h below the entry")

    def top(x):
        return 70 + 0.0011 * (x - 260) ** 2

    surface(s, top)
    x, o = (260, 70), (260, 170)

    def meet(angle):
        c, q, t = math.cos(angle), math.sin(angle), 0.0
        while 0 < o[0] + t * c < 640 and o[1] + t * q > top(o[0] + t * c):
            t += 0.25
        return (o[0] + t * c, o[1] + t * q)

    for i in range(18):
        angle = i * math.pi / 9 + 0.11
        s.path(
            [o, (o[0] + 520 * math.cos(angle), o[1] + 520 * math.sin(angle))], "line thin soft pale"
        )
    a, b = meet(-0.46), meet(-0.33)
    y = meet(-0.395)
    s.path([o, a, b], "f-blue pale", closed=True)
    s.path([o, y], "line blue")
    s.path([a, b], "line thick blue")
    s.path([x, o], "line orange")
    slope = 0.0022 * (y[0] - 260)
    k = 60 / math.hypot(1, slope)
    s.arrow(y, (y[0] + k * slope, y[1] - k), "ink")
    s.text(
        y[0] + k * slope + 8,
        y[1] - k + 6,
        sub("n", "y"),
        "it b",
    )
    s.arrow(x, (260, 12), "ink")
    s.text(268, 24, "n", "it b")
    s.dot(x, 6, "f-ink")
    s.dot(o, 6, "f-ink")
    s.text(246, 60, "x", "it b", "end")
    s.text(246, 186, "o", "it b", "end")
    s.text(250, 126, "h", "it b f-orange", "end")
    s.text(y[0] - 12, y[1] - 14, "y", "it b", "end")
    s.text(396, 160, "ω", "it b f-blue")
    s.text(
        404,
        216,
        f"|{sub('n', 'y')}·ω| dS / |y - o|²",
        "b f-blue",
    )
    s.text(404, 240, "is the solid angle of dS", "small")
    return s


def chord():
    s = Sheet(
        "chord",
        "Chords of a sphere about the entry cross a piece of surface as often however it is turned",
        320,
    )
    centre, rho = (165, 165), 140
    dice = random.Random(5)

    def top(x):
        return 165 + 0.0016 * (x - 165) ** 2

    surface(s, top)
    s.dot(centre, rho, "line soft")

    def on():
        z, turn = 1 - 2 * dice.random(), 2 * math.pi * dice.random()
        rim = math.sqrt(1 - z * z)
        return (centre[0] + rho * rim * math.cos(turn), centre[1] + rho * z)

    for _ in range(34):
        s.path([on(), on()], "line thin soft pale")
    a, b = (centre[0] - 62, centre[1] - 125.5), (centre[0] + 131, centre[1] + 49.5)
    t = next(
        k / 1000
        for k in range(1000)
        if between(a, b, k / 1000)[1] > top(between(a, b, k / 1000)[0])
    )
    y = between(a, b, t)
    s.path([a, b], "line blue")
    for at in (a, b):
        s.dot(at, 5, "f-blue")
    s.path([centre, (centre[0] - rho * 0.94, centre[1] + rho * 0.342)], "line orange")
    s.text(centre[0] - 70, centre[1] + 50, "ρ", "it b f-orange")
    s.dot(centre, 6, "f-ink")
    s.text(centre[0] - 12, centre[1] - 12, "x", "it b", "end")
    s.dot(y, 6, "f-ink")
    s.text(y[0] + 12, y[1] - 8, "y", "it b")
    s.text(340, 60, "Two uniform points of", "")
    s.text(340, 84, "the sphere, joined.", "")
    s.text(340, 124, "It crosses a piece dS", "b f-blue")
    s.text(340, 148, "with the probability", "b f-blue")
    s.text(340, 172, "dS / (2π ρ²), wherever", "b f-blue")
    s.text(340, 196, "and however it lies.", "b f-blue")
    return s


def reservoir():
    s = Sheet(
        "reservoir",
        "A reservoir holds one candidate; each new one takes its place with probability w / W",
        250,
    )
    weights, taken, at, total, held = [2.0, 0.6, 3.2, 1.0, 1.6], [1, 0, 1, 0, 0], 60, 0.0, 0
    s.text(24, 34, "candidates, one after the other: the area is w", "b")
    for i, (w, take) in enumerate(zip(weights, taken)):
        r = 17 * math.sqrt(w)
        total += w
        held = i if take else held
        s.dot((at, 84), r, "f-orange" if take else "f-blue half")
        s.text(at, 132, f"w = {w:g}", "", "middle")
        s.text(at, 156, f"W = {total:.1f}", "", "middle")
        s.text(at, 178, f"chance {round(100 * w / total)} %", "small", "middle")
        s.dot((at, 212), 13, "line ink")
        s.text(at, 217, str(held + 1), "b", "middle")
        if i:
            s.arrow((at - 124 + 20, 212), (at - 20, 212), "soft", "line thin")
        s.text(
            at,
            242,
            "takes its place" if take and i else "held" if i == 0 else "stays",
            "small",
            "middle",
        )
        at += 124
    return s


def tile():
    s = Sheet("tile", "The exits of a tile of pixels serve every lookup of the tile", 340)
    dice, entries = random.Random(3), []
    for j in range(4):
        for i in range(4):
            corner = [
                (60 + 62 * (i + u) + 20 * (j + v), 70 + 50 * (j + v))
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            s.path(corner, "wax", closed=True)
            s.path(corner + corner[:1], "line thin soft")
            u, v = 0.25 + 0.5 * dice.random(), 0.25 + 0.5 * dice.random()
            entries.append((60 + 62 * (i + u) + 20 * (j + v), 70 + 50 * (j + v)))
    y = (450, 178)
    for e in entries:
        s.path([y, e], "line thin orange half")
    own = entries[9]
    s.path([own, y], "line blue")
    for e in entries:
        s.dot(e, 4, "f-ink")
    s.dot(own, 6, "f-blue")
    s.dot(y, 9, "f-orange")
    s.text(60, 40, "the entries of a tile of pixels", "b")
    s.text(466, 172, "y, one exit:", "b f-orange")
    s.text(466, 196, "shaded once,", "b f-orange")
    s.text(466, 220, "weighed for all", "b f-orange")
    s.text(60, 302, "blue: the entry whose lookup found y", "b f-blue")
    s.text(60, 326, "Every entry weighs y by its own profile.", "small")
    return s


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    for drawing in (points, shadow, radii, axes, sphere, chord, reservoir, tile):
        drawing().save(folder)


main()
