"""A small WebDriver client: Chromium without a display, for the test of the page and its stills.

SPDX-License-Identifier: MIT
"""

import base64
import json
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
]


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Browser:
    def __init__(self):
        self.profile = tempfile.mkdtemp()
        port = free_port()
        self.base = f"http://127.0.0.1:{port}"
        self.driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        for _ in range(100):
            try:
                self.call("GET", "/status")
                break
            except (urllib.error.URLError, ConnectionError):
                time.sleep(0.1)
        options = {"args": FLAGS + [f"--user-data-dir={self.profile}"]}
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        }
        answer = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self.session = "/session/" + answer["sessionId"]
        self.open("about:blank")
        time.sleep(0.5)
        self.log("performance")  # what the first tab asked for is not the page's

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(
            self.base + path, data, {"Content-Type": "application/json"}, method=method
        )
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from error

    def post(self, path, body):
        return self.call("POST", self.session + path, body)

    def devtools(self, command, **parameters):
        return self.post("/goog/cdp/execute", {"cmd": command, "params": parameters})

    def run(self, script, *arguments):
        """The value that the script returns in the page."""
        return self.post("/execute/sync", {"script": script, "args": list(arguments)})

    def view(self, width, height, dark=False, scripts=True, scale=1, touch=False):
        self.devtools(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=scale,
            mobile=touch,
        )
        self.devtools("Emulation.setTouchEmulationEnabled", enabled=touch)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.devtools("Emulation.setEmulatedMedia", features=[scheme])
        self.devtools("Emulation.setScriptExecutionDisabled", value=not scripts)

    def open(self, url):
        self.post("/url", {"url": url})

    def log(self, kind):
        return self.post("/se/log", {"type": kind})

    def picture(self, file, x, y, width, height):
        shot = self.devtools(
            "Page.captureScreenshot",
            captureBeyondViewport=False,
            clip={"x": x, "y": y, "width": width, "height": height, "scale": 1},
        )
        with open(file, "wb") as out:
            out.write(base64.b64decode(shot["data"]))

    # Input, in pixels of the view.
    def pointer(self, points, kind="mouse"):
        """Presses at the first point, moves along the others, lets go."""
        moves = [
            {"type": "pointerMove", "duration": 30, "x": round(x), "y": round(y)} for x, y in points
        ]
        actions = (
            moves[:1]
            + [{"type": "pointerDown", "button": 0}]
            + moves[1:]
            + [{"type": "pointerUp", "button": 0}]
        )
        self.post(
            "/actions",
            {
                "actions": [
                    {
                        "type": "pointer",
                        "id": kind,
                        "parameters": {"pointerType": kind},
                        "actions": actions,
                    }
                ]
            },
        )

    def keys(self, *keys):
        """Presses keys, given as characters of WebDriver's table."""
        actions = []
        for key in keys:
            actions += [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        self.post("/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": actions}]})

    def close(self):
        try:
            self.call("DELETE", self.session)
        finally:
            self.driver.terminate()
            self.driver.wait()
            shutil.rmtree(self.profile, ignore_errors=True)
