"""Draws the stills of the live figures anew, from build/page/index.html: make page-stills.

Chapters show the stills where there is no JavaScript. SPDX-License-Identifier: MIT
"""

import os
import subprocess
import time

from browser import Browser

SECONDS = 6  # that a figure runs before its picture is taken
HERO = 0.5  # its sun moves: later it stands in front, where the three balls look alike

browser = Browser()
try:
    browser.view(1000, 900)
    browser.open("file://" + os.path.abspath("build/page/index.html"))
    time.sleep(1)
    for name in browser.run("return Object.keys(live.figures)"):
        browser.run(
            "document.documentElement.style.scrollBehavior = 'auto';"
            "live.figures[arguments[0]].canvas.scrollIntoView({block: 'center'})",
            name,
        )
        time.sleep(HERO if name == "hero" else SECONDS)
        x, y, w, h = browser.run(
            "const r = live.figures[arguments[0]].canvas.getBoundingClientRect();"
            "return [r.x + scrollX, r.y + scrollY, r.width, r.height]",
            name,
        )
        png = f"build/page/{name}.png"
        browser.picture(png, x, y, w, h)
        subprocess.run(
            [
                "cwebp",
                "-quiet",
                "-q",
                "72",
                "-m",
                "6",
                png,
                "-o",
                f"tutorial/page/still/{name}.webp",
            ],
            check=True,
        )
        print(f"tutorial/page/still/{name}.webp")
finally:
    browser.close()
