# SPDX-License-Identifier: BSD-3-Clause
"""Which of several maps that look alike is the floor. Part of page_maps_test.py."""
import sys

from browser import wait_until

# The daemon's next message takes the problem away again, and its buttons with it.
FLOORS = """
showHealth({ ...robot.health, problems: [{ device: "map", id: "floors_alike", level: "warning", cause: "two maps look alike", fix: "", meanwhile: "",
  numbers: [], texts: ["%s", "%s", ""] }] });
const made = [...document.querySelectorAll("#floors button")], words = document.getElementById("floors").textContent;
showUnlocked(false);
made[0].click();
const focused = document.activeElement.id;
showUnlocked(true);
made[0].click();
return [words, focused];
"""


def check_floors(phone, names):
    """Maps that look alike are asked for by name, of who may load one."""
    present, other = names
    words, focused = phone.run(FLOORS % (other, present))
    if not all(name in words for name in ("Welche Etage?", other, present)) or focused != "token":
        sys.exit(f"which floor: {words}, without a token: {focused}")
    wait_until("the named map is loaded",
               lambda: phone.run("return document.getElementById('result').textContent").startswith(other + " ist geladen"))
    wait_until("nothing is asked any more", lambda: phone.run("return document.getElementById('floors').childElementCount") == 0)
