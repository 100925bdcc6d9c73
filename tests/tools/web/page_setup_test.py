#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A set-up by its page on a phone, from the address to a checked configuration. Run by tests/integration/in_namespace.

Usage: page_setup_test.py BIN SOURCE OUT. Exit 77: no Chromium here."""
import os
import re
import subprocess
import sys
import time

sys.dont_write_bytecode = True  # into the sources

from browser import Browser, wait_until
from page_access import check_contrast, check_targets
from page_drive import Drives
from page_session import session

SIZE = (390, 844, 2)
SHOWN = "return document.getElementById('question').hidden ? '' : setup.question ? setup.question.id : ''"
TEXT = "return document.getElementById('%s').textContent"
# The robot's, of tests' simulated one; others take their default.
TYPED = {"lidar.x": "0.06"}


class SetUp:
    """slam-sim and slamctl setup --web."""

    def __init__(self, programs, _, folder):
        self.folder, self.config = folder, folder / "slamd.toml"
        devices = folder / "devices"
        os.environ["SLAM_SIM_DEVICES"] = str(devices)
        self.sim = self.start("slam-sim", programs, "--scene", "meeting-room", "--seconds", "600", "--obey", "--devices", devices)
        wait_until("the simulator's devices", (devices / "board").exists)
        (folder / "answers").write_text(f"runtime.socket = {folder / 'socket'}\n")
        self.setup = self.start("slamctl", programs, "--config", self.config, "setup", "--web", "--web-port", "0", "--drive", "25",
                                "--answers", folder / "answers", "--port", devices / "lidar", "--port", devices / "board")
        found = wait_until("the address", lambda: re.search(r"http://[^ :]+:(\d+)/(#token=\w+)", (folder / "slamctl.txt").read_text()))
        self.page = f"http://127.0.0.1:{found[1]}/"
        self.secret = found[2]

    def start(self, program, programs, *arguments):
        with open(self.folder / f"{program}.txt", "w") as log:
            return subprocess.Popen([programs / program, *map(str, arguments)], stdout=log, stderr=log)

    def stop(self):
        for process in (self.setup, self.sim):
            process.kill()
            process.wait()


def tap(browser, selector):
    """A true tap on what a person would find there."""
    browser.run(f"document.querySelector(`{selector}`).scrollIntoView({{block: 'center'}})")
    time.sleep(0.4)
    at = browser.run(f"const b = document.querySelector(`{selector}`).getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]")
    browser.point("down", at)
    browser.point("up")


def next_question(browser, before=""):
    return wait_until("the next question", lambda: (lambda now: now != before and now)(browser.run(SHOWN)))


def answer(browser, id):
    """@return the question behind it"""
    if browser.run("return !document.getElementById('answer').hidden"):
        browser.run(f"document.getElementById('typed').value = '{TYPED.get(id, '')}'")
        tap(browser, "#answer button")
    else:
        tap(browser, "#choices button")  # the first: yes
    return next_question(browser, id)


def check_questions(browser, other, out):
    """Each question to that of the joystick; a reload and a second phone show the same one."""
    asked, now = [], next_question(browser)
    while now != "joystick":
        asked.append(now)
        if now == "lidar.x":
            check_contrast("a question", browser)
            check_targets(browser)
            browser.screenshot(out / "setup-question.png")
            browser.run("document.getElementById('typed').value = 'far'")
            tap(browser, "#answer button")
            wait_until("a value that cannot be is refused", lambda: browser.run(TEXT % "error"))
            browser.reload()
            wait_until("a reload shows the same question", lambda: browser.run(SHOWN) == now)
            wait_until("so does another phone", lambda: other.run(SHOWN) == now)
            if "Lidar vor dem Drehpunkt" not in other.run(TEXT % "question-text"):
                sys.exit("the question is not asked in German: " + other.run(TEXT % "question-text"))
            other.screenshot(out / "setup-question-de.png")
        now = answer(browser, now)
    print("asked:", ", ".join(asked))
    if not {"lidar.x", "lidar.yaw", "calibrate"} <= set(asked):
        sys.exit("not all was asked")
    stale = other.run("setup.question = {number: 1, id: 'x'}; return reply('1').then(() => document.getElementById('refusal').textContent)")
    if "schon beantwortet" not in stale:
        sys.exit("an answer to an old question is not refused: " + stale)


def hold(browser, dx, dy, seconds):
    x, y = browser.place_of("stick")
    browser.point("down", (x, y))
    browser.point("move", (x + dx, y + dy))
    time.sleep(seconds)
    browser.point("up")


def check_drive(browser, drives, out):
    answer_first = "document.querySelector('#choices button').click()"
    browser.run(answer_first)
    wait_until("the stick is there", lambda: browser.run("return !document.getElementById('drive').hidden"))
    browser.run("document.getElementById('driving').scrollIntoView({block: 'center'})")
    hold(browser, 0, -60, 1.5)
    wait_until("letting go stops", drives.stands)
    gap = drives.all[-1][0] - [when for when, *speed in drives.all if speed != [0.0, 0.0]][-1]
    print(f"letting go stops {1000 * gap:.0f} ms behind the last speed")
    if max(forwards for _, forwards, _ in drives.all) > 0.3 or gap > 1.0:
        sys.exit(f"driven too fast, or stopped too late: {drives.all}")
    x, y = browser.place_of("stick")
    browser.point("down", (x, y))
    browser.point("move", (x, y - 50))
    wait_until("it drives again", drives.drives)
    browser.run("window.dispatchEvent(new Event('blur'))")
    wait_until("another window stops", drives.stands)
    browser.point("up")
    hold(browser, -60, 0, 4)
    browser.screenshot(out / "setup-drive.png")
    hold(browser, 60, 0, 4)
    hold(browser, -40, -40, 2)
    hold(browser, 40, 40, 2)
    hold(browser, -60, 0, 3)


def main():
    with session(SetUp) as (chromium, robot, _, out):
        browser, other = Browser(chromium, *SIZE), Browser(chromium, *SIZE, dark=True, language="de")
        browser.open(robot.page)
        wait_until("without its token the page shows nothing", lambda: "#" in browser.run(TEXT % "banner"))
        browser.open("about:blank")
        for phone in (browser, other):
            phone.open(robot.page + robot.secret)
        drives = Drives()
        check_questions(browser, other, out)
        check_drive(browser, drives, out)
        wait_until("the drive is calibrated", lambda: browser.run(SHOWN) in ("write", "again"), 90)
        if browser.run(SHOWN) != "write":
            sys.exit("not calibrated: " + browser.run(TEXT % "open"))
        wait_until("scans and map are drawn", lambda: browser.run("return [...document.querySelectorAll('figure img')].every((i) => i.naturalWidth > 50)"))
        browser.run("document.getElementById('calibration').scrollIntoView()")
        browser.screenshot(out / "setup-calibration.png")
        browser.run("scrollTo(0, 0)")
        browser.screenshot(out / "setup-write.png")
        if robot.config.exists():
            sys.exit("written before a yes")
        answer(browser, "write")
        wait_until("doctor is content", lambda: browser.run(TEXT % "verdict") == "doctor: all good")
        check_contrast("the end", browser)
        browser.run("scrollTo(0, 0)")
        browser.screenshot(out / "setup-end.png")
        width = browser.run("return document.documentElement.scrollWidth")
        if width > SIZE[0]:
            sys.exit(f"the page is {width} px wide")
        tap(browser, "#choices button")
        if robot.setup.wait(timeout=20) != 0 or not robot.config.exists():
            sys.exit("the set-up did not end well: " + (robot.folder / "slamctl.txt").read_text())
        wait_until("the page shows the end", lambda: "ended" in browser.run(TEXT % "banner"))
        complaints = [words for words in browser.complaints() if "401" not in words and "favicon" not in words]
        if complaints:
            sys.exit(f"the browser complains: {complaints}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
