#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""slam-web's page in a real browser, with slamd and a simulated robot. Run by tests/integration/in_namespace.

Usage: page_test.py BIN SOURCE OUT: programs, the repository, and a folder for screenshots. Exit 77: no Chromium here.
With SLAMD_WRITE_DOCS=1 it makes docs/web.png and no more.
"""
import os
import pathlib
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # into the sources

from browser import ARROW_LEFT, TAB, Browser, wait_until
from page_drive import PAGE, TOKEN, Drives, check_drive, check_drive_by_keys, check_drive_rights

SIZES = {"desktop": (1280, 800, 1), "phone": (390, 844, 2)}


class Robot:
    """slam-sim, slamd and slam-web."""

    def __init__(self, programs, source, folder):
        self.programs, self.folder = programs, folder
        self.devices = folder / "devices"
        os.environ["SLAM_SIM_DEVICES"] = str(self.devices)
        os.environ["LD_LIBRARY_PATH"] = str(programs / "../lib/openni2")
        self.config = ["--config", str(source / "config/sim.toml")]
        (folder / "logs/run").mkdir(parents=True)
        (folder / "logs/run/0001.lcm").write_bytes(b"a log")
        self.sim = self.start("slam-sim", "--scene", "meeting-room", "--speed", "0.3", "--seconds", "600",
                              "--devices", self.devices)
        wait_until("the simulator's devices", (self.devices / "board").exists)
        self.start_slamd()
        self.start_web()

    def start(self, program, *arguments):
        with open(self.folder / f"{program}.txt", "a") as log:
            return subprocess.Popen([self.programs / program, *map(str, arguments)], stdout=log, stderr=log)

    def start_slamd(self):
        settings = {"lidar.port": self.devices / "lidar", "base.port": self.devices / "board",
                    "output.map": self.folder / "map", "store.directory": self.folder / "maps"}
        pairs = [f"{key}='{value}'" for key, value in settings.items()] + ["lcm.commands=true", "base.speed_commands=true"]
        self.slamd = self.start("slamd", *self.config, *(word for pair in pairs for word in ("--set", pair)))

    def start_web(self):
        self.web = self.start("slam-web", *self.config, "--set", "web.commands=true", "--set", f"web.token='{TOKEN}'",
                              "--set", "base.speed_commands=true", "--logs", self.folder / "logs")

    def start_locked_web(self):
        """A second one, which is read with the token alone."""
        return self.start("slam-web", *self.config, "--port", 8081, "--set", "web.read='token'",
                          "--set", f"web.token='{TOKEN}'")

    def inject(self, fault):
        with open(self.devices / "faults", "w") as faults:
            faults.write(fault + "\n")

    def stop(self):
        for process in (self.web, self.slamd, self.sim):
            process.kill()
            process.wait()


# Whether walls (dark) and free space (light) are drawn.
SHOWS_A_MAP = """
const c = document.getElementById("map"), d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
let dark = 0, light = 0;
for (let i = 0; i < d.length; i += 4) {
  if (d[i] < 80 && d[i + 1] < 80 && d[i + 2] < 90) dark++;
  if (d[i] > 240 && d[i + 1] > 240 && d[i + 2] > 240) light++;
}
return dark > 200 && light > 5000;
"""
HAS_A_POSE = "return window.slam.robot.pose !== null"  # whether it is localised is slamd's matter
WORDS = "return document.getElementById('banner').hidden ? '' : document.getElementById('banner').textContent"


def check_size(name, chromium, out, dark=False, language="en"):
    width, height, ratio = SIZES[name]
    browser = Browser(chromium, width, height, ratio, dark, language)
    name += "-dark" if dark else ""
    browser.open(PAGE)
    wait_until(f"{name}: the map is drawn", lambda: browser.run(SHOWS_A_MAP))
    wait_until(f"{name}: the robot is drawn", lambda: browser.run(HAS_A_POSE))
    visible = browser.run("return window.slam.firstTile")
    time.sleep(4)
    lags = browser.run("return window.slam.lag")
    print(f"{name}: first tiles {visible:.0f} ms after the page was asked for, pose lag "
          f"{statistics.median(lags):.0f} ms, largest of {len(lags)}: {max(lags):.0f} ms")
    inside = browser.run("return [document.documentElement.scrollWidth, window.innerWidth, window.innerHeight]")
    if inside[0] > inside[1] or inside[1:] != [width, height]:
        sys.exit(f"{name}: the page is {inside[0]} px wide in a window of {inside[1]} x {inside[2]}")
    browser.screenshot(out / f"web-{name}.png")
    return browser


def check_layers(browser):
    sizes = "return window.slam.robot.map.tiles.map((t) => t.size)"
    if browser.run(sizes)[1:] != [0, 0]:
        sys.exit("layers were loaded that nobody looks at")
    browser.run("document.querySelector('[data-layer=\"2\"]').click()")
    wait_until("the layers are loaded", lambda: min(browser.run(sizes)) > 0)
    pictures = []
    for layer in range(3):
        browser.run(f"document.querySelector('[data-layer=\"{layer}\"]').click()")
        time.sleep(0.3)
        pictures.append(browser.run("return document.getElementById('map').toDataURL()"))
    browser.run("document.querySelector('[data-layer=\"0\"]').click()")
    if len(set(pictures)) != 3:
        sys.exit("the layers look alike")


LINE = "return document.getElementById('headline').textContent"


def check_line(browser, robot, out):
    """The line over the map names a pulled plug while the robot goes on, and says afterwards how well it knows its place."""
    wait_until("line and badge are good", lambda: browser.run(LINE).startswith("Localised to ") and
               browser.run("return document.querySelector('.badge.good') !== null"))
    began = time.monotonic()
    robot.inject("lidar unplug 1")
    line = wait_until("the line names the lidar", lambda: (lambda text: "lidar" in text and text)(browser.run(LINE)))
    print(f"a pulled plug: \"{line}\" after {time.monotonic() - began:.1f} s")
    browser.screenshot(out / "web-unplugged.png")
    if len(line) > 80:
        sys.exit("the line is longer than 80 characters: " + line)
    if not browser.run("return [...document.querySelectorAll('.device.fault')].some((d) => d.open)"):
        sys.exit("the lidar's details are folded away")
    robot.inject("lidar unplug 0")
    wait_until("the line is good again", lambda: browser.run(LINE).startswith("Localised to "))


# Lines made of data, whatever the robot does meanwhile; each problem's words fit.
LINES = """
const kept = { ...robot }, lines = {};
const line = (state, cov, problems, since) => {
  Object.assign(robot, { pose: { ...kept.pose, state, cov: [cov, 0, cov, 0.01] }, problems, since: since ? new Date(2026, 0, 1, 14, 2) : null });
  return shortened(headline()[0], kLongestLine);
};
const problem = (device, id, cause, more) => ({ device, id, cause, fix: "", meanwhile: "", level: "fault", numbers: [1, 2, 3, 4], texts: [], ...more });
lines.good = line("localised", 0.0004, []);
lines.metres = line("degraded", 0.9999, []);
lines.lost = line("lost", 1, [problem("base", "slow", "slow", { level: "warning" }), problem("pose", "lost", "no pose", { level: "warning" })], true);
lines.order = line("localised", 0.0004, [problem("pose", "next_scan", "waits", { level: "warning" }), problem("base", "port_gone", "gone"),
  problem("lidar", "port_in_use", "the port is in use by another program")]);
lines.warned = line("localised", 0.0004, [problem("memory", "memory_refused", "memory is not locked: a limit", { level: "warning" })]);
lines.secret = line("localised", 0.0004, [problem("depth", "camera_name_missing", "there is no camera 1d27/0601@1/4 (depth.uri)",
  { texts: ["1d27/0601@1/4"] })]);
lines.longest = "";
for (const id of Object.keys(window.kGerman || {})) {
  const made = line("initialising", 0.01, [problem("depth", id, "", { texts: ["a name of a device", "another name", "a third"] })]);
  if (made.length > lines.longest.length) lines.longest = made;
}
Object.assign(robot, kept);
return lines;
"""


def check_lines(browser, wanted):
    lines = browser.run(LINES)
    wrong = {name: lines[name] for name, line in wanted.items() if lines[name] != line}
    if wrong or len(lines["longest"]) > 80:
        sys.exit(f"wrong lines: {wrong}; longest: {lines['longest']}")


ENGLISH_LINES = {
    "good": "Localised to 2 cm", "metres": "Degraded to 1.0 m",
    "lost": "Lost since 14:02: waits to recognise something; drive slowly where it has been",
    "order": "No lidar: the port is in use by another program", "warned": "Localised to 2 cm \u00b7 memory: memory is not locked: a limit",
    "secret": "No depth camera: there is no camera (depth.uri)",
}
GERMAN_LINES = {
    "good": "Lokalisiert auf 2 cm", "metres": "Unsicher auf 1,0 m",
    "lost": "Verloren seit 14:02: sucht Bekanntes; langsam fahren, wo er schon war",
    "order": "Lidar fehlt: ein anderes Programm benutzt den Anschluss", "secret": "Tiefenkamera fehlt: keine Kamera (depth.uri)",
}


def check_keys(browser):
    view = "const v = window.slam.view; return [v.x, v.y, v.scale, v.follow]"
    browser.run("document.getElementById('map').focus()")
    before = browser.run(view)
    browser.keys(ARROW_LEFT + "+")
    moved = browser.run(view)
    if not (moved[0] < before[0] and moved[2] > before[2]):
        sys.exit(f"arrow and plus changed the view from {before} to {moved}")
    browser.keys("f")
    if not browser.run(view)[3] or browser.run("return document.getElementById('follow').ariaPressed") != "true":
        sys.exit("F does not follow the robot")
    browser.keys("0")
    names = "const e = document.activeElement; return e.id || e.getAttribute('aria-label') || e.textContent"
    reached, wanted = set(), {"zoom-in", "zoom-out", "fit", "follow", "stick", "stop", "language", "save",
                               "set-pose", "localise", "slam", "mark-text"}
    for _ in range(60):
        browser.keys(TAB)
        reached.add(browser.run(names))
    if wanted - reached:
        sys.exit(f"the Tab key does not reach {sorted(wanted - reached)}")
    unnamed = browser.run("""return [...document.querySelectorAll("button, input, select, canvas, a, [tabindex], [role=application]")].filter(
        (e) => !(e.ariaLabel || e.getAttribute("aria-label") || e.textContent.trim())).map((e) => e.outerHTML)""")
    if unnamed:
        sys.exit(f"without a name for a screen reader: {unnamed}")


# Least contrast of the texts that are shown, by the formula of WCAG 2.1.
CONTRAST = """
const parse = (c) => c.match(/[\\d.]+/g).map(Number);
const level = (c) => { const f = (v) => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  return 0.2126 * f(c[0]) + 0.7152 * f(c[1]) + 0.0722 * f(c[2]); };
const ground = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor);
  if (c.length === 3 || c[3] > 0.9) return c; } return [255, 255, 255]; };
let worst = [21, ""];
for (const e of document.querySelectorAll("body *")) {
  if (e.disabled || !e.checkVisibility() || ![...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim())) continue;
  const a = level(parse(getComputedStyle(e).color)), b = level(ground(e));
  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (ratio < worst[0]) worst = [ratio, e.outerHTML.slice(0, 100)];
}
return worst;
"""


def check_contrast(name, browser):
    ratio, where = browser.run(CONTRAST)
    print(f"{name}: contrast {ratio:.1f} at least")
    if ratio < 4.5:
        sys.exit(f"{name}: too little contrast: {where}")


def check_targets(browser):
    small = browser.run("""return [...document.querySelectorAll("button, input, select, summary, .links a")].filter((e) =>
        e.checkVisibility() && e.getBoundingClientRect().height < 44).map((e) => e.outerHTML)""")
    if small:
        sys.exit(f"lower than a finger: {small}")


UNLOCK = "document.getElementById('token').value = '%s'; document.querySelector('#login button').click()"


def check_commands(browser, robot):
    shown = "return document.getElementById('result').textContent"
    browser.run(UNLOCK % "a wrong token")
    wait_until("a wrong token is refused", lambda: "web.token" in browser.run(shown))
    browser.run(UNLOCK % TOKEN)
    wait_until("the token opens the commands",
               lambda: browser.run("return !document.getElementById('actions').hidden"))
    browser.run("document.getElementById('save').click()")
    wait_until("the map is saved", lambda: browser.run(shown) not in ("", "\u2026"))
    if not list((robot.folder / "maps").glob("*/000001")):
        sys.exit("no map in the store after \"save\": " + browser.run(shown))
    # An arrow is drawn: the robot is where it was put.
    browser.run("""
const c = document.getElementById("map"), p = window.slam.robot.pose, v = window.slam.view;
document.getElementById("set-pose").click();
const send = (type, x, y) => c.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: x, clientY: y }));
c.setPointerCapture = () => {};
const box = c.getBoundingClientRect(), r = window.devicePixelRatio;
const x = box.left + ((p.x - v.x) * v.scale + c.width / 2) / r, y = box.top + ((v.y - p.y) * v.scale + c.height / 2) / r;
send("pointerdown", x, y);
send("pointermove", x + 50 * Math.cos(p.theta), y - 50 * Math.sin(p.theta));
send("pointerup", x + 50 * Math.cos(p.theta), y - 50 * Math.sin(p.theta));
""")
    wait_until("the pose is set", lambda: browser.run(shown) == "pose set")


def check_german(browser, robot, out):
    """The phone speaks German by its own; the switch and a problem's words are in the language, too."""
    wait_until("the line is German", lambda: browser.run(LINE).startswith("Lokalisiert auf "))
    robot.inject("lidar unplug 1")
    line = wait_until("a problem is in German", lambda: (lambda text: text.startswith("Lidar fehlt: ") and text)(browser.run(LINE)))
    print(f"in German: \"{line}\"")
    if "Anschluss" not in browser.run("return document.getElementById('devices').textContent"):
        sys.exit("the device's details are not German")
    browser.screenshot(out / "web-phone-unplugged.png")
    robot.inject("lidar unplug 0")
    wait_until("the German line is good again", lambda: browser.run(LINE).startswith("Lokalisiert auf "))
    switch = "const s = document.getElementById('language'); s.value = '%s'; s.dispatchEvent(new Event('change'));"
    browser.run(switch % "en")
    if browser.run("return document.documentElement.lang") != "en" or not browser.run(LINE).startswith("Localised to "):
        sys.exit("the switch does not change the language")
    browser.run(switch % "de")


def check_locked(browser, robot):
    """A page that is read with the token alone."""
    locked = robot.start_locked_web()
    try:
        wait_until("the locked slam-web answers", lambda: socket.socket().connect_ex(("127.0.0.1", 8081)) == 0)
        browser.open("http://127.0.0.1:8081/")
        browser.run("sessionStorage.clear()")
        browser.reload()
        wait_until("the page is locked", lambda: "token" in browser.run(LINE))
        if browser.run(HAS_A_POSE):
            sys.exit("a locked page has a pose")
        browser.run(f"document.getElementById('token').value = '{TOKEN}'; document.querySelector('#login button').click()")
        wait_until("the token opens the map", lambda: browser.run(SHOWS_A_MAP))
        browser.complaints()  # of the refusals
    finally:
        locked.terminate()
        locked.wait()


def check_shell(browser, robot):
    """The page opens where slam-web is not reached."""
    wait_until("the page is kept", lambda: browser.run("return navigator.serviceWorker.controller !== null"))
    robot.web.send_signal(signal.SIGTERM)
    robot.web.wait()
    browser.reload()
    words = wait_until("it opens without slam-web", lambda: browser.run(WORDS))
    if "slam-web" not in words:
        sys.exit("without slam-web it shows: " + words)
    browser.complaints()
    robot.start_web()
    wait_until("it is live again", lambda: browser.run(WORDS) == "")


def check_restarts(browser, robot, out):
    browser.reload()
    wait_until("after a reload the map is drawn", lambda: browser.run(SHOWS_A_MAP))
    robot.slamd.send_signal(signal.SIGKILL)
    robot.slamd.wait()
    words = wait_until("the page says that slamd is silent", lambda: browser.run(WORDS))
    if "slamd is silent" not in words:
        sys.exit("said when slamd is dead: " + words)
    browser.screenshot(out / "web-silent.png")
    robot.start_slamd()
    wait_until("slamd is heard again", lambda: browser.run(WORDS) == "")
    wait_until("its map is drawn", lambda: browser.run(SHOWS_A_MAP))
    robot.web.send_signal(signal.SIGTERM)
    if robot.web.wait() != 0:
        sys.exit("slam-web's exit code is not 0")
    words = wait_until("the page says that slam-web is away", lambda: browser.run(WORDS))
    if "No answer from slam-web" not in words:
        sys.exit("said when slam-web is away: " + words)
    browser.complaints()  # of the lost connection: the rest must be silent
    robot.start_web()
    wait_until("the page finds slam-web again", lambda: browser.run(WORDS) == "")
    wait_until("and draws the map", lambda: browser.run(SHOWS_A_MAP))


def main():
    programs, source, out = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not chromium or not driver:
        print("skipped: install chromium and chromium-driver")
        return 77
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        with open(folder / "driver.txt", "w") as log:
            webdriver = subprocess.Popen([driver, "--port=9515"], stdout=log, stderr=log)
        robot = Robot(programs, source, folder)
        try:
            if os.environ.get("SLAMD_WRITE_DOCS"):  # the picture in docs/robot.md: most of a lap
                time.sleep(88)
                browser = check_size("desktop", chromium, out)
                browser.run(UNLOCK % TOKEN)
                wait_until("the stick is shown", lambda: browser.run("return !document.getElementById('stick').hidden"))
                browser.run("document.activeElement.blur()")
                browser.screenshot(source / "docs/web.png")
                browser.close()
                return 0
            time.sleep(8)  # something to look at
            browser = check_size("desktop", chromium, out)
            check_layers(browser)
            check_line(browser, robot, out)
            check_lines(browser, ENGLISH_LINES)
            check_commands(browser, robot)
            drives = Drives()
            check_drive_rights(drives)
            check_drive(browser, drives)
            check_drive_by_keys(browser, drives)
            browser.screenshot(out / "web-desktop-drive.png")
            check_keys(browser)
            check_contrast("light", browser)
            check_restarts(browser, robot, out)
            check_shell(browser, robot)
            phone = check_size("phone", chromium, out, dark=True, language="de")
            phone.run(UNLOCK % TOKEN)
            wait_until("the token opens the stick", lambda: phone.run("return !document.getElementById('stick').hidden"))
            check_drive(phone, drives)
            check_german(phone, robot, out)
            check_lines(phone, GERMAN_LINES)
            phone.screenshot(out / "web-phone-drive.png")
            check_contrast("dark", phone)
            check_targets(phone)
            check_locked(browser, robot)
            problems = [words for b in (browser, phone) for words in b.complaints()
                        if "net::ERR" not in words and "409" not in words]  # a press that a busy machine has ended
            if problems:
                sys.exit("the browser complains: " + "\n".join(problems))
            browser.close()
            phone.close()
        finally:
            robot.stop()
            webdriver.terminate()
            webdriver.wait()
            for log in folder.glob("*.txt"):
                shutil.copy(log, out / log.name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
