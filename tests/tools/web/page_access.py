# SPDX-License-Identifier: BSD-3-Clause
"""Whether slam-web's page can be used by keys, by fingers and by who sees little. Part of page_test.py."""
import sys

from browser import ARROW_LEFT, TAB


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
        (e) => !(e.ariaLabel || e.ariaHidden || e.getAttribute("aria-labelledby") || e.getAttribute("aria-label") || e.textContent.trim())).map((e) => e.outerHTML)""")
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
