#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Maps and their edits by slam-web's page, by fingers and by keys. Run by tests/integration/in_namespace.

Usage: page_maps_test.py BIN SOURCE OUT. Exit 77: no Chromium here."""
import math
import sys
import time

sys.dont_write_bytecode = True  # into the sources

from browser import ARROW_DOWN, ARROW_RIGHT, BACKSPACE, ENTER, Browser, wait_until
from page_drive import PAGE, TOKEN
from page_floors import check_floors
from page_session import UNLOCK, session
from page_test import HAS_A_POSE, SHOWS_A_MAP, SIZES

EDITS = "return window.slam.robot.edits.map((e) => [e.kind, e.name, e.points.length])"
HINT = "return document.getElementById('edit-hint').textContent"


def opened(chromium, name, dark=False, language="en"):
    """@return a window with the page, unlocked"""
    return unlocked(Browser(chromium, *SIZES[name], dark, language))


def unlocked(browser):
    """Opens the page, as far as its commands. @return the window"""
    browser.open(PAGE)
    wait_until("the map is drawn", lambda: browser.run(SHOWS_A_MAP))
    wait_until("the robot is drawn", lambda: browser.run(HAS_A_POSE))
    browser.run(UNLOCK % TOKEN)
    wait_until("the token opens the commands", lambda: browser.run("return !document.getElementById('actions').hidden"))
    return browser


def press(browser, element, dragged=True):
    """A true tap or click on what has this id, where a person would find it. @param dragged before it"""
    browser.run(f"document.getElementById('{element}').scrollIntoView({{block: 'center'}})")
    if browser.touch and dragged:
        time.sleep(0.4)  # at once behind a drag, Chromium takes a tap for the end of a fling
    at = browser.place_of(element)
    browser.point("down", at)
    browser.point("up", *([] if browser.touch else [at]))


def choose(browser, tool):
    browser.run(f"document.querySelector('#tools [value=\"{tool}\"]').click()")


def on_screen(browser, x, y):
    """@return where a place of the map [m] lies in the window [px]"""
    return browser.run(f"""const c = document.getElementById('map').getBoundingClientRect(), r = window.devicePixelRatio;
return [c.left + px({x}) / r, c.top + py({y}) / r]""")


def draw(browser, places):
    """One finger along places of the map [m]."""
    points = [on_screen(browser, x, y) for x, y in places]
    browser.point("down", points[0])
    for a, b in zip(points, points[1:]):
        for i in range(1, 5):
            browser.point("move", (a[0] + (b[0] - a[0]) * i / 4, a[1] + (b[1] - a[1]) * i / 4))
    browser.point("up", *([] if browser.touch else [points[-1]]))


def tap(browser, x, y):
    at = on_screen(browser, x, y)
    browser.point("down", at)
    browser.point("up", *([] if browser.touch else [at]))


def applied(browser, what, wanted):
    """Presses Apply. @return the edits, once there are so many"""
    before = len(browser.run(EDITS))
    press(browser, "apply")
    edits = wait_until(f"{what} is on the robot's map", lambda: (lambda e: len(e) == before + wanted and e)(browser.run(EDITS)))
    answered(browser)
    return edits


def answered(browser):
    wait_until("the answer is shown", lambda: not browser.run("return window.slam.edit.busy"))


def check_first_edit(chromium, out):
    """@return the window of a phone that has drawn a no-go zone, from its start"""
    phone = Browser(chromium, *SIZES["phone"], False, "de")
    began = time.monotonic()
    unlocked(phone)
    press(phone, "edit-map", dragged=False)
    wait_until("the map may be edited", lambda: phone.run("return document.body.classList.contains('editing')"))
    ready = time.monotonic()
    choose(phone, "zone")
    x, y = phone.run("return [window.slam.robot.pose.x, window.slam.robot.pose.y]")
    draw(phone, [(x + 0.7 * math.cos(a / 2), y + 0.7 * math.sin(a / 2)) for a in range(13)])
    phone.screenshot(out / "edit-phone-draft.png")
    drawn = time.monotonic()
    edits = applied(phone, "the first edit", 1)
    stored = time.monotonic()  # what WebDriver's finger takes in between is no part of the page's time
    print(f"phone: from open to the first edit on the robot's map {ready - began + stored - drawn:.1f} s, "
          f"of which {ready - began:.1f} s until it can be drawn, and {drawn - ready:.1f} s more for drawing it: {edits}")
    if edits[0][0] != "zone" or not 4 < edits[0][2] < 180:
        sys.exit(f"the first edit is {edits}")
    return phone


def check_all_kinds(phone, robot, out):
    x, y = phone.run("return [window.slam.robot.pose.x, window.slam.robot.pose.y]")
    before = phone.run("return [window.slam.view.x, window.slam.view.scale]")
    a, b = on_screen(phone, x - 0.3, y), on_screen(phone, x + 0.3, y)
    phone.point("down", a)
    phone.point("down", a, b)
    for i in range(1, 6):
        phone.point("move", (a[0] - 4 * i, a[1] - 10 * i), (b[0] + 4 * i, b[1] - 10 * i))
    phone.point("up")
    if phone.run("return window.slam.edit.points.length") or phone.run("return window.slam.view.scale") <= before[1]:
        sys.exit("two fingers have drawn, or do not zoom")
    choose(phone, "wall")
    draw(phone, [(x - 0.5, y - 0.6), (x + 0.5, y - 0.6)])
    applied(phone, "a wall", 1)
    choose(phone, "free")
    for corner in ((x - 0.4, y + 0.2), (x + 0.4, y + 0.2), (x, y + 0.6)):
        tap(phone, *corner)
    applied(phone, "a free outline", 1)
    choose(phone, "room")
    draw(phone, [(x - 0.6, y - 0.5), (x + 0.6, y - 0.5), (x + 0.6, y + 0.5), (x - 0.6, y + 0.5)])
    if not phone.run("return document.getElementById('apply').disabled"):
        sys.exit("a room without a name can be sent")
    phone.run("const n = document.getElementById('edit-name'); n.value = 'K\u00fcche'; n.dispatchEvent(new Event('input'))")
    applied(phone, "a room", 1)
    choose(phone, "place")
    draw(phone, [(x, y), (x + 0.4, y + 0.4)])
    phone.run("const n = document.getElementById('edit-name'); n.value = 'dock'; n.dispatchEvent(new Event('input'))")
    edits = applied(phone, "a place", 1)
    phone.screenshot(out / "edit-phone.png")
    kinds = [kind for kind, *_ in edits]
    if kinds != ["zone", "wall", "free", "room", "place"] or edits[3][1] != "K\u00fcche":
        sys.exit(f"drawn: {edits}")
    theta = phone.run("return window.slam.robot.edits[4].theta")
    if abs(theta - math.pi / 4) > 0.2:
        sys.exit(f"the place looks to {theta} rad")
    press(phone, "undo")
    wait_until("the place is undone", lambda: len(phone.run(EDITS)) == 4)
    answered(phone)
    press(phone, "redo")
    wait_until("and back", lambda: len(phone.run(EDITS)) == 5)
    answered(phone)
    return edits


def check_removal(phone, out):
    """A tap on what was drawn, and Apply, take it back, whatever was drawn behind it."""
    choose(phone, "remove")
    x, y = phone.run("const w = window.slam.robot.edits.find((e) => e.kind === 'wall').points; return [w[0][0] * 0.8 + w[1][0] * 0.2, w[0][1]]")
    phone.run(f"Object.assign(window.slam.view, {{x: {x}, y: {y} - 0.8, scale: 200, moved: true}}); redraw()")
    time.sleep(0.2)
    tap(phone, x, y)
    phone.screenshot(out / "edit-phone-remove.png")
    press(phone, "apply")
    wait_until("the wall is gone", lambda: [e[0] for e in phone.run(EDITS)] == ["zone", "free", "room", "place"])
    answered(phone)
    press(phone, "undo")
    wait_until("and back", lambda: len(phone.run(EDITS)) == 5)
    answered(phone)


def check_brush(phone, out):
    """A ring by the brush: pieces without a hole, and nothing of its middle."""
    x, y = phone.run("return [window.slam.robot.pose.x, window.slam.robot.pose.y]")
    phone.run(f"Object.assign(window.slam.view, {{x: {x}, y: {y} - 0.8, scale: 200, moved: true}}); redraw()")
    choose(phone, "brush")
    time.sleep(0.2)
    draw(phone, [(x + 0.6 * math.cos(a / 3), y + 0.6 * math.sin(a / 3)) for a in range(20)])
    phone.screenshot(out / "edit-phone-brush.png")
    middle = phone.run(f"""const inside = ([x, y], o) => o.reduce((is, [x1, y1], i) => {{ const [x2, y2] = o[(i + 1) % o.length];
  return (y1 > y) !== (y2 > y) && x < (x2 - x1) * (y - y1) / (y2 - y1) + x1 ? !is : is; }}, false);
const outlines = outlinesOf(window.slam.edit.strokes);
return [outlines.length, outlines.filter((o) => inside([{x}, {y}], o)).length,
  outlines.filter((o) => inside([{x} + 0.6, {y}], o)).length, Math.max(...outlines.map((o) => o.length))]""")
    if middle[0] != 2 or middle[1] != 0 or middle[2] != 1 or middle[3] > 180:
        sys.exit(f"the brush's ring is {middle}: pieces, at its middle, at its rim, corners")
    applied(phone, "the brush", 2)
    for left in (6, 5):
        press(phone, "undo")
        wait_until("a piece is undone", lambda: len(phone.run(EDITS)) == left)
        answered(phone)


def check_refusals(phone, out):
    """slamd's reason against an edit is shown, and what was drawn stays."""
    x, y = phone.run("return [window.slam.robot.pose.x, window.slam.robot.pose.y]")
    phone.run("document.getElementById('fit').click()")
    choose(phone, "zone")
    time.sleep(0.2)
    for corner in ((x - 0.5, y - 0.5), (x + 0.5, y + 0.5), (x + 0.5, y - 0.5), (x - 0.5, y + 0.5)):
        tap(phone, *corner)
    press(phone, "apply")
    words = wait_until("the reason is shown", lambda: (lambda w: "kreuzt" in w and w)(phone.run(HINT)))
    if phone.run("return window.slam.edit.points.length") != 4:
        sys.exit("what was refused is gone")
    phone.screenshot(out / "edit-phone-refused.png")
    print(f"refused: \"{words}\"")
    press(phone, "drop")
    choose(phone, "erase")
    phone.run("document.getElementById('fit').click()")
    for corner in ((x - 20, y - 20), (x + 20, y - 20), (x + 20, y + 20), (x - 20, y + 20)):
        phone.run(f"window.slam.edit.points.push([{corner[0]}, {corner[1]}])")
    phone.run("showEdit()")
    press(phone, "apply")
    wait_until("an erase of all needs a second look", lambda: phone.run("return window.slam.edit.force"))
    press(phone, "drop")
    press(phone, "leave")
    if phone.run("return document.body.classList.contains('editing')"):
        sys.exit("Done does not leave")


ROW = "return [...document.querySelectorAll('#map-list b')].map((b) => b.textContent)"
PUSH = "[...document.querySelectorAll('%s')].find((b) => b.getAttribute('aria-label') === '%s').click()"


def check_maps(phone, robot, out):
    """List, picture, rename, delete, undo, load."""
    result = "return document.getElementById('maps-result').textContent"
    answer = phone.run("return ask({verb: 'save', name: 'copy'})")
    if not answer["ok"]:
        sys.exit(f"no copy: {answer}")
    press(phone, "show-maps")
    names = wait_until("the maps are listed", lambda: (lambda n: len(n) == 2 and n)(phone.run(ROW)))
    wait_until("with pictures", lambda: phone.run("return [...document.querySelectorAll('#map-list img')].every((i) => i.naturalWidth > 20)"))
    phone.screenshot(out / "maps-phone.png")
    present = names[0]
    phone.run(PUSH % ("#map-list button", "Ausrichten: " + present))
    wait_until("it is straightened", lambda: "gedreht" in phone.run(result))
    phone.run(PUSH % ("#map-list button", "Umbenennen: copy"))
    phone.run("const f = document.querySelector('#map-list form'); f.elements[0].value = 'house'; f.requestSubmit()")
    wait_until("it is renamed", lambda: "house" in phone.run(ROW))
    phone.run(PUSH % ("#map-list button", "L\u00f6schen: house"))
    wait_until("it is deleted", lambda: phone.run(ROW) == [present] and (robot.folder / "maps/.deleted/house").is_dir())
    phone.screenshot(out / "maps-phone-deleted.png")
    phone.run("document.querySelector('#maps-result button').click()")
    wait_until("it is back", lambda: "house" in phone.run(ROW))
    phone.run(PUSH % ("#map-list button", "Laden: house"))
    wait_until("it is loaded", lambda: "house" in phone.run(result) and phone.run(ROW)[0] == "house")
    wait_until("its edits are shown", lambda: len(phone.run(EDITS)) == 5)
    refused = phone.run("return ask({verb: 'delete', name: 'house'})")
    if refused["ok"] or "offen" not in refused["words"]:
        sys.exit(f"the map that slamd has open: {refused}")
    phone.run("document.querySelector('#maps .close').click()")


def check_keys(chromium, count, out):
    """An edit by keys alone, on a desktop. @param count of the map's edits"""
    desktop = opened(chromium, "desktop", dark=True)
    desktop.run("document.getElementById('edit-map').click()")
    wait_until("the desktop's map may be edited", lambda: desktop.run("return document.body.classList.contains('editing')"))
    wait_until("the map's edits are shown", lambda: len(desktop.run(EDITS)) == count)
    choose(desktop, "zone")
    desktop.run("document.getElementById('map').focus({focusVisible: true})")
    for keys in (" ", ARROW_RIGHT, ARROW_RIGHT, " ", ARROW_DOWN, ARROW_DOWN, " ", BACKSPACE, " "):
        desktop.keys(keys)
    desktop.screenshot(out / "edit-desktop-dark.png")
    if desktop.run("return window.slam.edit.points.length") != 3:
        sys.exit("space draws no corners: " + str(desktop.run("return window.slam.edit.points")))
    desktop.keys(ENTER)
    wait_until("Enter applies", lambda: len(desktop.run(EDITS)) == count + 1)
    answered(desktop)
    desktop.run("document.dispatchEvent(new Event('x')); document.getElementById('map').dispatchEvent("
                "new KeyboardEvent('keydown', {key: 'z', ctrlKey: true, bubbles: true, cancelable: true}))")
    wait_until("Ctrl+Z undoes", lambda: len(desktop.run(EDITS)) == count)
    desktop.run("document.getElementById('leave').click()")
    desktop.run("document.getElementById('show-maps').click()")
    wait_until("the maps are listed", lambda: len(desktop.run(ROW)) >= 2)
    wait_until("with pictures", lambda: desktop.run("return [...document.querySelectorAll('#map-list img')].every((i) => i.naturalWidth > 20)"))
    desktop.screenshot(out / "maps-desktop-dark.png")
    return desktop


def check_rights(browser):
    """Who has no token changes nothing."""
    for verb in ("map_undo", "restore", "delete", "load", "map_straighten"):
        answer = browser.run(f"return fetch('/api/v1/command', {{method: 'POST', headers: {{'Content-Type': 'application/json', Authorization: 'Bearer wrong token'}},"
                             f"body: JSON.stringify({{verb: '{verb}', name: 'house'}})}}).then((a) => a.status)")
        if answer not in (401, 429):
            sys.exit(f"{verb} without the token: {answer}")


def main():
    with session() as (chromium, robot, _, out):
        time.sleep(8)  # something to edit
        phone = check_first_edit(chromium, out)
        check_all_kinds(phone, robot, out)
        check_removal(phone, out)
        check_brush(phone, out)
        check_refusals(phone, out)
        check_maps(phone, robot, out)
        check_floors(phone, phone.run(ROW)[:2])
        desktop = check_keys(chromium, len(phone.run(EDITS)), out)
        check_rights(desktop)
        problems = [words for b in (phone, desktop) for words in b.complaints() if not any(code in words for code in ("400", "409", "401", "429"))]
        if problems:
            sys.exit("the browser complains: " + "\n".join(problems))
        phone.close()
        desktop.close()


if __name__ == "__main__":
    main()
