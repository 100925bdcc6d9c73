# SPDX-License-Identifier: BSD-3-Clause
"""The line over slam-web's map, made of data. Part of page_test.py."""
import sys

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
lines.held = line("localised", 0.0004, [problem("lidar", "port_held", "the port is in use by another program (minicom, 1234)", { texts: ["minicom", "1234"] })]);
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
    "order": "No lidar: the port is in use by another program",
    "held": "No lidar: the port is in use by another program (minicom, 1234)", "warned": "Localised to 2 cm \u00b7 memory: memory is not locked: a limit",
    "secret": "No depth camera: there is no camera (depth.uri)",
}
GERMAN_LINES = {
    "good": "Lokalisiert auf 2 cm", "metres": "Unsicher auf 1,0 m",
    "lost": "Verloren seit 14:02: sucht Bekanntes; langsam fahren, wo er schon war",
    "order": "Lidar fehlt: ein anderes Programm benutzt den Anschluss",
    "held": "Lidar fehlt: ein anderes Programm benutzt den Anschluss (minicom, 1234)", "secret": "Tiefenkamera fehlt: keine Kamera (depth.uri)",
}
