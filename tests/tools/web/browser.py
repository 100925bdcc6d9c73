# SPDX-License-Identifier: BSD-3-Clause
"""A window of Chromium, by the WebDriver protocol, for page_test.py."""
import base64
import json
import sys
import time
import urllib.error
import urllib.request

DRIVER = "http://127.0.0.1:9515"
# What a busy machine may take; the figures are printed, and are far below.
PATIENCE = 30  # [s]
ARROW_LEFT, ARROW_UP, ARROW_RIGHT, ARROW_DOWN = "\ue012", "\ue013", "\ue014", "\ue015"
TAB, ENTER, BACKSPACE, HOME = "\ue004", "\ue007", "\ue003", "\ue011"


def wait_until(what, condition, limit=PATIENCE):
    """@return what the condition gave"""
    end = time.monotonic() + limit
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            sys.exit(f"not so within {limit} s: {what}")
        time.sleep(0.1)


def call(method, url, body=None):
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)["value"]
    except urllib.error.HTTPError as error:
        sys.exit(f"WebDriver: {method} {url}: {error.read().decode()[:500]}")


class Browser:
    """A window of Chromium, by the WebDriver protocol."""

    def __init__(self, chromium, width, height, ratio, dark=False, language="en"):
        self.touch = ratio > 1
        options = {
            "binary": chromium,
            "args": ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                     f"--window-size={width},{height}", *(["--force-dark-mode"] if dark else [])],
            "prefs": {"intl.accept_languages": language},
        }
        if ratio > 1:
            options["mobileEmulation"] = {"deviceMetrics": {"width": width, "height": height, "pixelRatio": ratio,
                                                            "touch": True}}
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        session = call("POST", DRIVER + "/session", {"capabilities": {"alwaysMatch": wanted}})
        self.session = DRIVER + "/session/" + session["sessionId"]
        if ratio == 1:  # the inside of the window, not the window
            inner = self.run("return [window.innerWidth, window.innerHeight]")
            call("POST", self.session + "/window/rect", {"width": 2 * width - inner[0], "height": 2 * height - inner[1]})

    def open(self, url):
        call("POST", self.session + "/url", {"url": url})

    def reload(self):
        call("POST", self.session + "/refresh", {})

    def run(self, script):
        return call("POST", self.session + "/execute/sync", {"script": script, "args": []})

    def keys(self, text):
        """Presses keys, wherever the focus is."""
        actions = [{"type": kind, "value": key} for key in text for kind in ("keyDown", "keyUp")]
        call("POST", self.session + "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": actions}]})

    def point(self, kind, *places):
        """Presses, moves or releases ("down", "move", "up") at places in the window [px]: of a mouse, or of fingers where
        the window is a phone's."""
        if self.touch:
            kinds = {"down": "touchStart", "move": "touchMove", "up": "touchEnd"}
            self.devtools("Input.dispatchTouchEvent", type=kinds[kind], touchPoints=[
                {"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)])
        else:
            kinds = {"down": "mousePressed", "move": "mouseMoved", "up": "mouseReleased"}
            x, y = places[0]
            self.devtools("Input.dispatchMouseEvent", type=kinds[kind], x=x, y=y, button="left", buttons=1, clickCount=1)

    def devtools(self, command, **parameters):
        call("POST", self.session + "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def hold_key(self, key, down):
        call("POST", self.session + "/actions", {"actions": [
            {"type": "key", "id": "keyboard", "actions": [{"type": "keyDown" if down else "keyUp", "value": key}]}]})

    def place_of(self, element):
        """@return the middle of an element in the window [px]"""
        return self.run(f"const b = document.getElementById('{element}').getBoundingClientRect();"
                        "return [Math.round(b.x + b.width / 2), Math.round(b.y + b.height / 2)]")

    def go_offline(self, offline):
        call("POST", self.session + "/chromium/network_conditions", {"network_conditions": {
            "offline": offline, "latency": 0, "download_throughput": -1, "upload_throughput": -1}})

    def screenshot(self, file):
        file.write_bytes(base64.b64decode(call("GET", self.session + "/screenshot")))

    def complaints(self):
        return [entry["message"] for entry in call("POST", self.session + "/se/log", {"type": "browser"})
                if entry["level"] == "SEVERE"]

    def close(self):
        call("DELETE", self.session)
