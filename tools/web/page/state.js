// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- how the robot is, in words -----------------------------------------------------------------------------------

const kLevels = { localised: "good", degraded: "warning", initialising: "warning", lost: "fault" };
const kLongestLine = 80;  // characters of the line over the map
const kSilent = 3;        // [s] of slamd, or of the link

/// Metres as people read them: centimetres below one.
const length = (metres) => metres >= 0.995 ? number(metres, 1) + " m" : Math.max(1, Math.round(100 * metres)) + " cm";
const sigma = (pose) => Math.sqrt(Math.max(0, pose.cov[0], pose.cov[2]));
const degrees = (radians) => number(radians * 180 / Math.PI, 1) + "\u00b0";
const isValid = (pose) => pose.state === "localised" || pose.state === "degraded";

function duration(seconds) {
  const s = Math.round(seconds);
  return s < 120 ? s + " s" : s < 7200 ? Math.round(s / 60) + " min" : number(s / 3600, 1) + " h";
}

function showPose() {
  const p = robot.pose;
  if (!p) return;
  showFacts($("pose"), [
    ["x,\u00a0y", number(p.x, 2) + "; " + number(p.y, 2) + " m"], [t("heading"), degrees(p.theta)],
    [t("sigma"), length(sigma(p)) + "; " + degrees(Math.sqrt(Math.max(0, p.cov[3])))],
    [t("speed"), number(p.speed, 2) + " m/s; " + degrees(p.turn) + "/s"],
    [t("quality"), Math.round(100 * p.quality) + " %"],
  ]);
}

/// The most important problem first: faults, in the order of the devices; what a pose that is not valid waits for; warnings.
function worstProblem() {
  const devices = robot.devices.map((device) => device.name);
  const rank = (p) => (p.level === "fault" || (p.device === "pose" && !isValid(robot.pose)) ? 0 : 1000) +
    (devices.includes(p.device) ? devices.indexOf(p.device) : p.device === "pose" ? 100 : 200);
  return [...robot.problems].sort((a, b) => rank(a) - rank(b))[0];
}

/// How the robot is, in one line, and how bad that is.
function headline() {
  if (robot.locked) return [t("locked"), "unknown"];
  const p = robot.pose;
  if (!p) return [t("waiting"), "unknown"];
  const worst = worstProblem(), level = kLevels[p.state] || "unknown";
  const clock = robot.since && robot.since.toLocaleTimeString(language, { hour: "2-digit", minute: "2-digit", hourCycle: "h23" });
  const state = named("", p.state);
  const how = isValid(p) ? t("to", state, length(sigma(p))) : clock ? t("since", state, clock) : state;
  if (!worst) return [how, level];
  const about = named("device", worst.device), isDevice = robot.devices.some((device) => device.name === worst.device);
  if (worst.level === "fault" && worst.device !== "pose")
    return [(isDevice ? t("no", about) : about) + ": " + shortCause(worst), p.state === "localised" ? "warning" : "fault"];
  const cause = named("line", worst.id) !== worst.id ? named("line", worst.id) : shortCause(worst);
  return [worst.device === "pose" ? how + ": " + cause : t("and", how, about + ": " + cause), p.state === "localised" ? "warning" : level];
}

function showState() {
  const away = performance.now() - link.heard;
  const silent = link.silence + away / 1000;
  let words = "", line = "";
  if (!robot.locked && !link.open && away > 1000 * kSilent) {
    line = t("noWeb");
    words = t("noWebLong", Math.round(away / 1000));
  } else if (!robot.locked && silent > kSilent) {
    line = t("noSlamd");
    words = t("noSlamdLong", Math.round(silent));
  }
  $("banner").hidden = words === "";
  $("banner").textContent = words;
  if (robot.silent !== (words !== "")) redraw();  // the mark shows it, too
  robot.silent = words !== "";
  const [text, level] = words ? [line, "fault"] : headline(), short = shortened(text, kLongestLine);
  if ($("headline").textContent !== short) $("headline").textContent = short;  // else it is read out again
  $("badge").title = text;
  $("badge").className = "badge " + level;
}

/// Words in place of an ellipse that does not fit. @param sigma_m [m] empty: it fits
function showWithin(sigma_m) {
  const words = sigma_m ? t("within", length(sigma_m)) : "";
  if ($("within").textContent !== words) $("within").textContent = words;
  $("within").hidden = words === "";
}

const panes = new Map();  // of the devices, by name: what is unfolded stays so

function wordsIn(problems) {
  return problems.flatMap((problem) => {
    const { cause, meanwhile, fix } = wordsOf(problem);
    return [element("p", cause, "reason"), ...[meanwhile, fix].filter(Boolean).map((words) => element("p", words, "advice"))];
  });
}

function showDevice(device) {
  let pane = panes.get(device.name);
  if (!pane) {
    pane = element("details");
    pane.append(element("summary"));
    panes.set(device.name, pane);
  }
  if (pane.dataset.level !== device.level) pane.open = device.level !== "good";
  pane.dataset.level = device.level;
  pane.className = "device " + device.level;
  const age = device.age < 0 ? t("noData") : t("old", device.age > 2 ? duration(device.age) : Math.round(1000 * device.age) + " ms");
  const words = device.level === "good" ? t("good") : t(device.state);
  pane.firstChild.replaceChildren(element("i", ""), element("b", named("device", device.name)), element("span", `${words}, ${number(device.rate, 1)} Hz`));
  const own = robot.problems.filter((problem) => problem.device === device.name);
  const lines = own.length > 0 ? wordsIn(own) : device.reason ? [element("p", device.reason, "reason")] : [];
  pane.replaceChildren(pane.firstChild, ...lines, element("p", t("rates", age, number(device.expected, 1), device.rejects), "advice"));
  return pane;
}

/// Maps that look alike: who knows in which the robot is says so. They stay as they are while the maps are the same.
function showFloors(alike) {
  const names = alike ? [alike.texts[0], alike.texts[1], ...alike.texts[2].split(", ").slice(1)] : [], key = [language, ...names].join(" ");
  if ($("floors").dataset.names === key) return;
  $("floors").dataset.names = key;
  $("floors").replaceChildren(...(alike ? [element("span", t("whichFloor"))] : []), ...names.map((name) => {
    const made = element("button", name);
    made.type = "button";
    made.onclick = () => unlocked ? command({ verb: "load", name }) : askForToken();
    return made;
  }));
}

function showHealth(health) {
  robot.health = health;
  robot.problems = health.problems;
  robot.devices = health.devices;
  $("summary").textContent = health.summary;
  const shown = health.devices.map(showDevice);
  if (shown.length !== $("devices").childElementCount || shown.some((pane, i) => $("devices").children[i] !== pane))
    $("devices").replaceChildren(...shown);
  const others = health.problems.filter((problem) => !panes.has(problem.device));
  $("problems-card").hidden = others.length === 0;
  $("problems").replaceChildren(...others.flatMap((problem) => wordsIn([problem])));
  showFloors(others.find((problem) => problem.id === "floors_alike"));
  showState();
  showStages(health.stages);
  showComputer(health);
}

function showStages(stages) {
  const rows = [[t("stage"), "p50", "p99", "max"]];
  for (const s of stages)
    if (s.count > 0 && !s.name.endsWith(".work") && !s.name.endsWith(".late"))
      rows.push([s.name.replace(/_/g, " "), ...[s.p50_us, s.p99_us, s.max_us].map((us) => number(us / 1000, 2))]);
  $("stages").replaceChildren(...rows.map((row, i) => {
    const tr = element("tr");
    tr.append(...row.map((cell) => element(i === 0 ? "th" : "td", cell)));
    return tr;
  }));
}

function showComputer(health) {
  const c = health.counters;
  const facts = [[t("up"), duration(health.uptime)], [t("cpu"), t("ofACore", number(100 * health.cpu, 1))],
    [t("memory"), Math.round(health.memory_mb) + " MB"],
    [t("disk"), health.disk_free_mb < 0 ? t("noDisk") : number(health.disk_free_mb / 1000, 1) + " GB"]];
  if ("loop_closures" in c) facts.push([t("closures"), c.loop_closures]);
  if (c.lost > 0 || c.relocalised > 0) facts.push([t("lostFound"), `${c.lost}, ${c.relocalised}`]);
  for (const [name, value] of Object.entries(c))
    if (name === "log.running") facts.push([t("log"), t("log" + value)]);
    else if (name.startsWith("log.") || name.startsWith("record.")) facts.push([name.replace(/[._]/g, " "), value]);
  if (c["base.battery_mv"] > 0) facts.push([t("battery"), number(c["base.battery_mv"] / 1000, 1) + " V"]);
  showFacts($("computer"), facts);
}

function showMap() {
  if (!robot.meta) return;
  showFacts($("map-facts"), [[t("keyframes"), robot.meta.keyframes], [t("tiles"), robot.meta.tiles],
    [t("resolution"), number(100 * robot.meta.resolution, 1) + " cm"]]);
}

/// All words anew, as in another language.
function showAll() {
  showPose();
  showMap();
  if (robot.health) showHealth(robot.health);
  showState();
  showStop();
  if (edit.on) showEdit();
  showDay();
}
