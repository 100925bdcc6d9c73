#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The last day and the logs by slam-web's page. Run by tests/integration/in_namespace.

Usage: page_day_test.py BIN SOURCE OUT. Exit 77: no Chromium here."""
import signal
import sys
import time

sys.dont_write_bytecode = True  # into the sources

from browser import ARROW_RIGHT, HOME, wait_until
from page_maps_test import opened, press
from page_session import session

HAPPENED = "return document.getElementById('happened').textContent"
KINDS = "return window.slam.day.list.map((one) => one.kind + ' ' + one.name)"
NOTE = "return document.getElementById('day-note').textContent"


def tap_at(browser, one):
    """A true tap on the strip where this happened, by its kind and name."""
    browser.run("document.getElementById('day').scrollIntoView({block: 'center'})")
    time.sleep(0.4)
    at = browser.run(f"""const one = window.slam.day.list.findLast((o) => o.kind + ' ' + o.name === '{one}'), b = document.getElementById('band').getBoundingClientRect();
return [b.left + ((one.begin + one.end) / 2 - begins()) / (window.slam.day.hours * kHour) * b.width, b.top + (kLanes[one.kind] + 0.5) * b.height / 3]""")
    browser.point("down", at)
    browser.point("up", *([] if browser.touch else [at]))


def look(browser):
    browser.run("showDay()")
    return browser.run(KINDS)


def check_day(browser, robot, out):
    """A pulled plug, a drive and a mark are in it, with words and a place; also for who opens the page later."""
    robot.inject("lidar unplug 1")
    wait_until("the lidar is away", lambda: "device lidar" in look(browser))
    time.sleep(6)
    robot.inject("lidar unplug 0")
    wait_until("it is back", lambda: browser.run("return document.querySelector('.device.fault') === null"))
    press(browser, "keep")
    wait_until("the mark is in it", lambda: any(kind.startswith("mark ") for kind in look(browser)))
    if not list((robot.folder / "logs").glob("*/*.mark")):
        sys.exit("the log has no mark")
    browser.reload()
    wait_until("it outlives a reload", lambda: {"device lidar", "drive "} <= set(look(browser)))
    tap_at(browser, "device lidar")
    words = wait_until("a tap has words", lambda: browser.run(HAPPENED))
    print(f"a tap on the strip: \"{words}\"")
    if "idar" not in words or "port" not in words.lower():
        sys.exit(f"it does not name the problem: {words}")
    here = browser.run("const o = window.slam.day.chosen; return [o.x - window.slam.view.x, o.y - window.slam.view.y]")
    if max(map(abs, here)) > 0.01:
        sys.exit(f"the map does not show the place, by {here} m")
    browser.screenshot(out / "day-phone.png")
    tap_at(browser, "drive ")
    wait_until("a drive has its way", lambda: " m" in browser.run(HAPPENED))
    browser.run("document.getElementById('day').focus()")
    texts = set()
    for key in HOME + 4 * ARROW_RIGHT:
        browser.keys(key)
        texts.add(browser.run("return document.getElementById('day').getAttribute('aria-valuetext')"))
    if len(texts) < 3:
        sys.exit(f"arrow keys do not go from one to the next: {texts}")
    if "slam-web" not in browser.run(NOTE):
        sys.exit("it does not show since when slam-web watches")


def check_logs(browser, out):
    press(browser, "show-logs")
    rows = "return [...document.querySelectorAll('#log-table tr')].map((r) => [...r.cells].map((c) => c.textContent))"
    table = wait_until("the logs are listed", lambda: (lambda t: len(t) > 1 and t)(browser.run(rows)))
    browser.screenshot(out / "logs-phone.png")
    print(f"logs: {table}")
    if len(table[1]) != 5 or "MB" not in table[1][2] or "keep" not in table[1][3]:
        sys.exit("a log has no size or mark")
    begin = browser.run("return fetch(document.getElementById('all-logs').href).then((a) => a.arrayBuffer()).then((b) => new TextDecoder().decode(b.slice(0, 4)))")
    if begin != "PK\x03\x04":
        sys.exit(f"one zip of all logs begins with {begin!r}")
    size = browser.run("return fetch(document.querySelector('#log-table a').href).then((a) => a.arrayBuffer()).then((b) => b.byteLength)")
    if size < 1000:
        sys.exit(f"a log of {size} bytes was downloaded")
    browser.run("document.querySelector('#logs .close').click()")


def check_silence(browser, robot):
    """slamd that is away, and slam-web that began later."""
    robot.slamd.send_signal(signal.SIGKILL)
    robot.slamd.wait()
    time.sleep(4)
    robot.start_slamd()
    wait_until("the silence is in it", lambda: "state silent" in look(browser))
    robot.web.send_signal(signal.SIGTERM)
    robot.web.wait()
    robot.start_web()
    wait_until("it begins anew", lambda: "state silent" not in look(browser) and browser.run(NOTE) != "")
    wait_until("marks are in the logs", lambda: any(kind.startswith("mark ") for kind in look(browser)))


def main():
    with session() as (chromium, robot, _, out):
        time.sleep(8)
        phone = opened(chromium, "phone")
        check_day(phone, robot, out)
        check_logs(phone, out)
        desktop = opened(chromium, "desktop", dark=True)
        desktop.run("document.getElementById('day').scrollIntoView({block: 'center'})")
        wait_until("there is a day", lambda: "device lidar" in look(desktop))
        tap_at(desktop, "device lidar")
        wait_until("a click has words", lambda: desktop.run(HAPPENED))
        desktop.screenshot(out / "day-desktop-dark.png")
        check_silence(phone, robot)
        phone.close()
        desktop.close()


if __name__ == "__main__":
    main()
