# SPDX-License-Identifier: BSD-3-Clause
"""Driving by slam-web's page: what moves the robot, and all that stops it. Part of page_test.py."""
import socket
import struct
import sys
import threading
import time
import urllib.error
import urllib.request

from browser import ARROW_UP, ENTER, wait_until

PAGE = "http://127.0.0.1:8080/"
TOKEN = "a-token-for-tests"
# What a busy machine may take; the gaps are printed, and drive_relay_test has 250 ms.
LONGEST_GAP = 1.5  # [s]
TRIES, PRESS = 5, 3  # [1], [s] of a press that drives


class Drives(threading.Thread):
    """The speeds that slam-web sends: SLAM_DRIVE over LCM."""

    def __init__(self):
        super().__init__(daemon=True)
        self.all = []  # (time [s], forwards [m/s], turn [rad/s])
        self.lcm = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.lcm.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.lcm.bind(("239.255.76.67", 7667))
        self.lcm.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, bytes((239, 255, 76, 67, 127, 0, 0, 1)))
        self.start()

    def run(self):
        while True:
            channel, _, message = self.lcm.recv(65536)[8:].partition(b"\0")
            if channel == b"SLAM_DRIVE":
                _, forwards, _, turn = struct.unpack_from(">qddd", message, 8)
                self.all.append((time.monotonic(), forwards, turn))

    def begin(self):
        self.all.clear()

    def drives(self):
        return bool(self.all) and self.all[-1][1:] != (0.0, 0.0)

    def stands(self):
        return bool(self.all) and self.all[-1][1:] == (0.0, 0.0)


def refused(speed, token):
    """@return the status of a request that must not drive"""
    request = urllib.request.Request(PAGE + "api/v1/drive", speed.encode(), {
        "Content-Type": "application/json", "Authorization": "Bearer " + token}, method="POST")
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def check_drive(browser, drives):
    """Holding drives; letting go, Stop, a second finger, a hidden page and a lost link stop."""
    x, y = browser.place_of("stick")
    ahead = (x, y - 60)

    def release():
        browser.point("up", *([] if browser.touch else [ahead]))

    def hold():
        for _ in range(TRIES):  # a busy machine may end a press by a gap
            drives.begin()
            browser.point("down", (x, y))
            browser.point("move", ahead)
            end = time.monotonic() + PRESS
            while time.monotonic() < end and len(drives.all) <= 5:
                time.sleep(0.05)
            if not all(0.0 <= forwards <= 1.0 and abs(turn) <= 2.0 for _, forwards, turn in drives.all):
                sys.exit(f"driven out of the limits: {drives.all}")
            if len(drives.all) > 5 and drives.drives():
                return
            release()
            time.sleep(0.5)
        sys.exit(f"the stick does not drive: {drives.all}")

    def stopped(how):
        wait_until(how + " stops", drives.stands)
        times = [when for when, *_ in drives.all]
        gap = times[-1] - [when for when, *speed in drives.all if speed != [0.0, 0.0]][-1]
        print(f"{'touch' if browser.touch else 'mouse'}: {how} stops {1000 * gap:.0f} ms behind the last speed")
        if gap > LONGEST_GAP:
            sys.exit(how + " stops too late")
        time.sleep(0.5)
        if not drives.stands():
            sys.exit("driven on behind: " + how)

    hold()
    release()
    stopped("letting go")
    for how, script in {
            "a hidden page": "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
                             "document.dispatchEvent(new Event('visibilitychange')); delete document.hidden",
            "another window": "window.dispatchEvent(new Event('blur'))",
            "leaving the page": "window.dispatchEvent(new Event('pagehide'))",
            "a second finger": "document.body.dispatchEvent(new PointerEvent('pointerdown',"
                               "{pointerId: 77, bubbles: true}))",
            "Stop": "document.getElementById('stop').click()"}.items():
        hold()
        browser.run(script)
        stopped(how)
        release()
    if browser.touch:  # a true one
        hold()
        browser.point("down", ahead, (x + 200, y - 150))
        stopped("another finger")
        browser.point("up")
    hold()
    browser.go_offline(True)
    stopped("a lost link")
    browser.go_offline(False)
    time.sleep(0.5)
    if not drives.stands():
        sys.exit("driven on when the link is back")
    release()


def check_drive_by_keys(browser, drives):
    browser.run("document.getElementById('stick').focus()")
    drives.begin()
    browser.hold_key(ARROW_UP, True)
    wait_until("an arrow key drives", lambda: len(drives.all) > 3 and drives.drives())
    browser.hold_key(ARROW_UP, False)
    wait_until("its release stops", drives.stands)
    drives.begin()
    browser.run("document.getElementById('stop').focus()")
    browser.keys(ENTER)
    wait_until("Stop by a key stops", drives.stands)


def check_drive_rights(drives):
    drives.begin()
    ahead = '{"vx": 0.2, "omega": 0, "hold": 5}'
    statuses = {"a wrong token": (refused(ahead, "a wrong token"), 401)}
    for speed in ('{"vx": 1e300, "omega": 0, "hold": 5}', '{"vx": NaN, "omega": 0, "hold": 5}', '{"vx": "1", "omega": 0, "hold": 5}',
                  '{"vx": 0.2, "omega": 0}', "[]"):
        statuses[speed] = (refused(speed, TOKEN), 400)
    wrong = {what: got for what, got in statuses.items() if got[0] != got[1]}
    time.sleep(0.3)
    if wrong or drives.all:
        sys.exit(f"not refused: {wrong}, driven: {drives.all}")
