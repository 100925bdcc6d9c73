#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""slam-web's page in a real browser, with slamd and a simulated robot. Run by tests/integration/in_namespace.

Usage: page_test.py BIN SOURCE OUT: programs, the repository, and a folder for screenshots. Exit 77: no Chromium here.
With SLAMD_WRITE_DOCS=1 it makes docs/web.png and no more.
"""
import json
import os
import signal
import socket
import statistics
import sys
import time

sys.dont_write_bytecode = True  # into the sources

from browser import Browser, wait_until
from page_access import check_contrast, check_keys, check_targets
from page_drive import PAGE, TOKEN, Drives, check_drive, check_drive_by_keys, check_drive_rights
from page_session import UNLOCK, session
from page_words import ENGLISH_LINES, GERMAN_LINES, check_lines

# For the picture in docs/robot.md [m].
DRAWN = [{"kind": "room", "name": "Meeting room", "points": [[-1.5, -6.8], [7.5, -6.8], [7.5, 0.8], [-1.5, 0.8]]},
         {"kind": "zone", "points": [[5, -6.2], [7.4, -6.2], [7.4, -6.8], [5, -6.8]]},
         {"kind": "place", "name": "Dock", "points": [[0, 0]], "theta": 0}]
SIZES = {"desktop": (1280, 800, 1), "phone": (390, 844, 2)}


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


def check_weight(browser):
    """What a first look loads, without the robot's data."""
    files = browser.run("""
const own = (e) => !new URL(e.name).pathname.startsWith("/api/");
return [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")].filter(own)
  .map((e) => [new URL(e.name).pathname, e.decodedBodySize]);""")
    weight = sum(size for _, size in files)
    print(f"a first look loads {weight} bytes in {len(files)} files")
    if len(files) < 8 or not 40_000 < weight < 80_000:
        sys.exit(f"a first look is to load less than 80 000 bytes, and loads {weight}: {files}")


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
    wait_until("the line says how it is", lambda: browser.run(LINE).startswith("Localised to "))
    line, badge = browser.run("return [document.getElementById('headline').textContent, document.getElementById('badge').className]")
    if ("good" in badge) == ("\u00b7" in line):  # a busy machine has warnings
        sys.exit(f"the badge of \"{line}\" is: {badge}")
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
        browser.run("sessionStorage.clear()")
        browser.open(f"http://127.0.0.1:8081/?again#token={TOKEN}")  # as a QR code has it
        wait_until("the address opens the map", lambda: browser.run(SHOWS_A_MAP))
        if browser.run("return location.href") != "http://127.0.0.1:8081/":
            sys.exit("the address shows the token")
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
    with session() as (chromium, robot, source, out):
        if os.environ.get("SLAMD_WRITE_DOCS"):  # the picture in docs/robot.md: most of a lap
            time.sleep(88)
            browser = check_size("desktop", chromium, out)
            browser.run(UNLOCK % TOKEN)
            wait_until("the stick is shown", lambda: browser.run("return !document.getElementById('stick').hidden"))
            for edit in DRAWN:
                browser.run(f"return ask({{verb: 'map_edit', edit: {json.dumps(edit)}}})")
            wait_until("what is drawn is shown", lambda: browser.run("return window.slam.robot.edits.length") == len(DRAWN))
            wait_until("the robot is well", lambda: browser.run("return document.querySelector('.badge.good') !== null"), 120)
            browser.screenshot(source / "docs/web.png")
            browser.close()
            return 0
        time.sleep(8)  # something to look at
        browser = check_size("desktop", chromium, out)
        check_weight(browser)
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
        for name, dark in (("desktop", True), ("phone", False)):
            other = check_size(name, chromium, out, dark)
            check_contrast(f"{name}, {'dark' if dark else 'light'}", other)
            other.close()
        check_locked(browser, robot)
        problems = [words for b in (browser, phone) for words in b.complaints()
                    if "net::ERR" not in words and "409" not in words]  # a press that a busy machine has ended
        if problems:
            sys.exit("the browser complains: " + "\n".join(problems))
        browser.close()
        phone.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
