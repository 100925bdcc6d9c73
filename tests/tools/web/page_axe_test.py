#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""slam-web's page by the rules of axe-core: both sizes, light and dark, each dialog. Run by tests/integration/in_namespace.

Usage: page_axe_test.py BIN SOURCE OUT AXE, the folder that install_axe has filled. Exit 77: no Chromium, or no axe-core."""
import pathlib
import sys
import time

sys.dont_write_bytecode = True  # into the sources

from browser import wait_until
from page_access import check_contrast, check_targets
from page_maps_test import opened
from page_session import SKIPPED, session
from page_test import SHOWS_A_MAP

AUDIT = """return axe.run(document, {rules: {"target-size": {enabled: true}}}).then((r) => r.violations.flatMap((v) =>
  v.nodes.map((n) => v.id + " (" + v.impact + "): " + n.html.slice(0, 140) + " | " + n.failureSummary.replace(/\\s+/g, " ").slice(0, 220))))"""
RULES = "return axe.run(document, {rules: {'target-size': {enabled: true}}}).then((r) => r.passes.length)"

STATES = {
    "the page": ("document.querySelectorAll('details').forEach((d) => { d.open = true; })", "true"),
    "a happening": ("const d = document.getElementById('day'); d.focus(); d.dispatchEvent(new KeyboardEvent('keydown', {key: 'End'}))",
                    "document.getElementById('happened').textContent !== ''"),
    "the maps": ("document.getElementById('show-maps').click()", "document.querySelector('#map-list li')"),
    "another name": ("[...document.querySelectorAll('#map-list .acts button')].find((b) => b.ariaLabel.startsWith('Rename') || b.ariaLabel.startsWith('Umb')).click()",
                     "document.querySelector('#map-list form')"),
    "the logs": ("document.getElementById('maps').close(); document.getElementById('show-logs').click()", "document.querySelector('#log-table td')"),
    "editing": ("document.getElementById('logs').close(); document.getElementById('edit-map').click()", "document.body.classList.contains('editing')"),
    "a place": ("document.querySelector('#tools [value=place]').click()", "!document.getElementById('edit-name').hidden"),
}


def audit(name, browser):
    findings = browser.run(AUDIT)
    if browser.run(RULES) < 10:
        sys.exit(f"{name}: axe-core has looked at nothing")
    return [f"{name}: {finding}" for finding in findings]


def main():
    source = pathlib.Path(sys.argv[4]) / "node_modules/axe-core/axe.min.js"
    if not source.exists():
        print("skipped: axe-core is not there; npm gets it where there is a network (install_axe)")
        return SKIPPED
    findings, looks = [], 0
    with session() as (chromium, _, _, out):
        time.sleep(8)
        for size in ("phone", "desktop"):
            for dark in (False, True):
                browser = opened(chromium, size, dark, "de" if dark else "en")
                browser.run(source.read_text())
                browser.run("return ask({verb: 'save', name: 'copy'})")
                wait_until("there is a history", lambda: browser.run("return window.slam.day.now > 0 && window.slam.day.list.length > 0"))
                for state, (begin, there) in STATES.items():
                    browser.run(begin)
                    wait_until(state, lambda: browser.run(f"return Boolean({there})"))
                    name = f"{size}, {'dark' if dark else 'light'}, {state}"
                    findings += audit(name, browser)
                    looks += 1
                    if not browser.run("return [...document.querySelectorAll('dialog[open]')].every((d) => d.scrollWidth <= d.clientWidth)"):
                        sys.exit(f"{name}: wider than its dialog")
                    check_contrast(name, browser)
                    if browser.touch:
                        check_targets(browser)
                    browser.screenshot(out / f"{name.replace(', ', '-').replace(' ', '_')}.png")
                browser.run("sessionStorage.clear()")
                browser.reload()
                wait_until("the map is drawn without the token", lambda: browser.run(SHOWS_A_MAP))
                browser.run(source.read_text())
                findings += audit(f"{size}, {'dark' if dark else 'light'}, without the token", browser)
                looks += 1
                browser.close()
    print(f"axe-core: {len(findings)} findings in {looks} looks")
    if findings:
        sys.exit("\n".join(findings))
    return 0


if __name__ == "__main__":
    sys.exit(main())
