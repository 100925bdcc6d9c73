// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- what is known of the robot -----------------------------------------------------------------------------------

const kLongestTrail = 8000;  // numbers: x and y in turn [cm]
const kFlash = 3000;         // [ms] that a new loop closure is shown by a growing ring

const robot = {
  session: null, pose: null, scan: [], depth: [], trail: [], closures: [],
  map: { id: null, version: 0, wanted: 0, layers: false, resolution: 0.05, side: 64, tiles: [new Map(), new Map(), new Map()] },
};
robot.problems = [];
robot.since = null;  // when the page saw the present state begin
const link = { open: false, heard: performance.now(), silence: 0 };
const view = { x: 0, y: 0, scale: 40, follow: false, moved: false, layer: 0 };  // centre [m], [pixel/m]
const place = { armed: false, from: null, to: null };  // a pose that is being drawn as an arrow [m]
// For tests and curious people.
window.slam = { robot, view, firstTile: null, lag: [] };

const $ = (id) => document.getElementById(id);
const canvas = $("map");
const paint = canvas.getContext("2d");

// ---- tiles --------------------------------------------------------------------------------------------------------

// Colour of each occupancy [percent]; 255 is unknown.
const kColours = new Uint32Array(256);
for (let percent = 0; percent <= 100; percent++) {
  const grey = percent < 50 ? 255 - percent * 0.9 : 210 - (percent - 50) * 3.8;
  const level = Math.max(24, Math.round(grey));
  kColours[percent] = (255 << 24) | ((level + (percent > 50 ? 6 : 0)) << 16) | (level << 8) | level;
}

function beginMap(id) {
  for (const tiles of robot.map.tiles) tiles.clear();
  robot.map.id = id;
  robot.map.version = 0;
  view.moved = view.follow;  // a new map is shown as a whole, unless the robot is followed
}

function takeTiles(buffer) {
  const bytes = new DataView(buffer);
  if (bytes.byteLength < 32 || bytes.getUint32(0, false) !== 0x534c4d54) throw new Error("not a map");
  const id = bytes.getInt32(12, true);
  if (id !== robot.map.id) beginMap(id);
  robot.map.resolution = bytes.getFloat64(16, true);
  const side = robot.map.side = bytes.getInt32(24, true);
  const count = bytes.getInt32(28, true);
  for (let i = 0, at = 32; i < count; i++, at += 12 + side * side) {
    const layer = bytes.getInt32(at, true), column = bytes.getInt32(at + 4, true), row = bytes.getInt32(at + 8, true);
    const cells = new Uint8Array(buffer, at + 12, side * side);
    const key = column + "," + row;
    let tile = robot.map.tiles[layer].get(key);
    if (!tile) {
      const picture = document.createElement("canvas");
      picture.width = picture.height = side;
      tile = { column, row, picture };
      robot.map.tiles[layer].set(key, tile);
    }
    const context = tile.picture.getContext("2d");
    const image = context.createImageData(side, side);
    const pixels = new Uint32Array(image.data.buffer);
    tile.left = tile.bottom = side, tile.right = tile.top = 0;  // of its known cells
    for (let r = 0; r < side; r++) {  // the first row of a tile is its lowest
      for (let c = 0; c < side; c++) {
        const percent = cells[r * side + c];
        pixels[(side - 1 - r) * side + c] = kColours[percent];
        if (percent > 100) continue;
        tile.left = Math.min(tile.left, c), tile.right = Math.max(tile.right, c + 1);
        tile.bottom = Math.min(tile.bottom, r), tile.top = Math.max(tile.top, r + 1);
      }
    }
    context.putImageData(image, 0, 0);
  }
  robot.map.version = bytes.getFloat64(4, true);
  if (count > 0 && window.slam.firstTile === null) window.slam.firstTile = performance.now();
  if (!view.moved && !view.follow && robot.map.tiles[0].size > 0) fit();  // also as it grows
  redraw();
}

let fetching = false;
async function fetchTiles() {
  if (fetching || robot.map.wanted <= robot.map.version) return;
  fetching = true;
  try {
    const since = robot.map.version, layers = robot.map.layers;
    const answer = await fetch("/api/v1/map?since=" + since + (layers ? "&layers=1" : ""));
    if (answer.ok) {
      const buffer = await answer.arrayBuffer();
      // Else the map began anew meanwhile, or more of it is wanted.
      if (since === robot.map.version && layers === robot.map.layers) takeTiles(buffer);
    }
  } catch (error) { /* the stream of events breaks, too, and asks again */ }
  fetching = false;
  if (robot.map.wanted > robot.map.version && link.open) setTimeout(fetchTiles, 300);
}

// ---- events -------------------------------------------------------------------------------------------------------

function points(data) {
  const text = atob(data.p), list = new Float32Array(text.length / 2);
  const word = (i) => {
    const value = text.charCodeAt(2 * i) | text.charCodeAt(2 * i + 1) << 8;
    return value > 32767 ? value - 65536 : value;
  };
  for (let i = 0; i < list.length; i += 2) {
    list[i] = (data.x + word(i)) / 100;
    list[i + 1] = (data.y + word(i + 1)) / 100;
  }
  return list;
}

const takers = {
  hello(data) {
    if (robot.session !== null && robot.session !== data.session) beginMap(null);
    robot.session = data.session;
    $("version").textContent = data.version;
    $("commands").hidden = !data.commands;
    link.silence = data.silence;
  },
  trail(data) {
    robot.trail = data.cm;
    robot.closures = data.closures.map((c) => ({ ...c, born: -kFlash }));
  },
  pose(data) {
    if (robot.pose && robot.pose.map !== data.map) robot.trail = [], robot.closures = [], robot.scan = [], robot.depth = [];
    if (robot.pose && robot.pose.state !== data.state) robot.since = new Date();
    robot.pose = data;
    link.silence = 0;
    const lag = Date.now() - data.utime / 1000;
    window.slam.lag.push(lag);
    if (window.slam.lag.length > 600) window.slam.lag.shift();
    if (data.state === "localised" || data.state === "degraded") {
      const x = Math.round(100 * data.x), y = Math.round(100 * data.y), n = robot.trail.length;
      if (n === 0 || Math.hypot(x - robot.trail[n - 2], y - robot.trail[n - 1]) >= 5) robot.trail.push(x, y);
      if (robot.trail.length > kLongestTrail) robot.trail.splice(0, 2);
    }
    showPose();
    redraw();
  },
  scan(data) { robot.scan = points(data); redraw(); },
  depth(data) { robot.depth = points(data); redraw(); },
  closure(data) {
    robot.closures.push({ ...data, born: performance.now() });
    if (robot.closures.length > 100) robot.closures.shift();
    redraw();
  },
  map(data) {
    if (robot.map.id !== data.id) beginMap(data.id);
    robot.map.wanted = data.version;
    showFacts($("map-facts"), [["Keyframes", data.keyframes], ["Tiles", data.tiles],
      ["Resolution", (100 * data.resolution).toFixed(1) + " cm"]]);
    fetchTiles();
  },
  health: showHealth,
  beat(data) { link.silence = data.silence; },
};

function connect() {
  const events = new EventSource("/api/v1/events");
  for (const [name, take] of Object.entries(takers)) {
    events.addEventListener(name, (event) => {
      link.open = true;
      link.heard = performance.now();
      take(JSON.parse(event.data));
    });
  }
  events.onerror = () => {
    link.open = false;
    if (events.readyState !== EventSource.CLOSED) return;  // the browser tries again by itself
    setTimeout(connect, 2000);
  };
}

// ---- words --------------------------------------------------------------------------------------------------------

function showFacts(list, facts) {
  list.replaceChildren(...facts.flatMap(([name, value]) => {
    const dt = document.createElement("dt"), dd = document.createElement("dd");
    dt.textContent = name;
    dd.textContent = value;
    return [dt, dd];
  }));
}

const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1");  // no -0.00
const length = (metres) =>
  metres >= 1 ? metres.toFixed(1) + " m" : (100 * metres).toFixed(metres < 0.1 ? 1 : 0) + " cm";
const sigma = (pose) => Math.sqrt(Math.max(0, pose.cov[0], pose.cov[2]));
const degrees = (radians) => fixed(radians * 180 / Math.PI, 1) + "\u00b0";

function showPose() {
  const p = robot.pose, tt = p.cov[3];
  showFacts($("pose"), [
    ["x, y", fixed(p.x, 2) + ", " + fixed(p.y, 2) + " m"], ["Heading", degrees(p.theta)],
    ["Sigma", length(sigma(p)) + ", " + degrees(Math.sqrt(Math.max(0, tt)))],
    ["Speed", fixed(p.speed, 2) + " m/s, " + degrees(p.turn) + "/s"],
    ["Scan on the map", Math.round(100 * p.quality) + " %"],
  ]);
}

const kLevels = { localised: "good", degraded: "warning", initialising: "warning", lost: "fault" };
const kLongestLine = 80;  // characters of the line over the map

const shortened = (text) => text.length <= kLongestLine ? text : text.slice(0, kLongestLine - 1).trimEnd() + "\u2026";

/// How the robot is, in one line, and how bad that is.
function headline() {
  const p = robot.pose;
  if (!p) return ["Waiting for the robot\u2019s first pose", "unknown"];
  const since = robot.since ? " since " + robot.since.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" }) : "";
  const worst = robot.problems.find((problem) => problem.level === "fault") ||
    robot.problems.find((problem) => problem.device === "pose") || robot.problems[0];
  const localised = p.state === "localised";
  const level = worst && worst.level === "fault" && !localised ? "fault" : worst && localised ? "warning" : kLevels[p.state] || "unknown";
  if (worst && worst.device !== "pose")
    return [(worst.level === "fault" && panes.has(worst.device) ? "No " : "") + worst.device + ": " + worst.cause, level];
  if (localised) return [worst ? worst.cause : "Localised to " + (sigma(p) < 1 ? Math.max(1, Math.round(100 * sigma(p))) + " cm" : length(sigma(p))), level];
  const state = p.state[0].toUpperCase() + p.state.slice(1) + since;
  return [worst ? state + ": " + (worst.fix || worst.cause) : state, level];
}

function showState() {
  const lost = performance.now() - link.heard;
  const silent = link.silence + lost / 1000;
  let words = "", line = "";
  if (!link.open && lost > 3000) {
    line = "No answer from slam-web";
    words = `No answer from slam-web for ${Math.round(lost / 1000)} s; the page keeps trying. Is the robot on, and in this network?`;
  } else if (silent > 3) {
    line = "slamd is silent";
    words = `slamd is silent since ${Math.round(silent)} s; the page shows its last state. On the robot: systemctl status slamd`;
  }
  $("banner").hidden = words === "";
  if (words) $("banner").textContent = words;
  robot.silent = words !== "";
  const [text, level] = words ? [line, "fault"] : headline();
  if ($("headline").textContent !== shortened(text)) $("headline").textContent = shortened(text);  // else it is read out again
  $("badge").title = text;
  $("badge").className = "badge " + level;
}

function duration(seconds) {
  const s = Math.round(seconds);
  return s < 120 ? s + " s" : s < 7200 ? Math.round(s / 60) + " min" : (s / 3600).toFixed(1) + " h";
}

function element(tag, text, className) {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

const panes = new Map();  // of the devices, by name: what is unfolded stays so

function showDevice(device) {
  let pane = panes.get(device.name);
  if (!pane) {
    pane = document.createElement("details");
    pane.append(document.createElement("summary"));
    panes.set(device.name, pane);
  }
  if (pane.dataset.level !== device.level) pane.open = device.level !== "good";
  pane.dataset.level = device.level;
  pane.className = "device " + device.level;
  const age = device.age < 0 ? "no data yet" : device.age > 2 ? duration(device.age) + " old" : Math.round(1000 * device.age) + " ms old";
  const words = device.level === "good" ? "good" : device.state.toLowerCase();
  pane.firstChild.replaceChildren(element("i", ""), element("b", device.name), element("span", `${words}, ${device.rate.toFixed(1)} Hz`));
  const lines = [device.reason && element("p", device.reason, "reason"),
    device.level !== "good" && device.advice && element("p", device.advice, "advice"),
    element("p", `${age}; ${device.expected.toFixed(1)} Hz expected; ${device.rejects} refused`, "advice")];
  pane.replaceChildren(pane.firstChild, ...lines.filter(Boolean));
  return pane;
}

function showHealth(health) {
  $("summary").textContent = health.summary;
  robot.problems = health.problems;
  const shown = health.devices.map(showDevice);
  if (shown.length !== $("devices").childElementCount || shown.some((pane, i) => $("devices").children[i] !== pane))
    $("devices").replaceChildren(...shown);
  showState();
  const rows = [["", "p50", "p99", "max"]];
  for (const s of health.stages)
    if (s.count > 0 && !s.name.endsWith(".work") && !s.name.endsWith(".late"))
      rows.push([s.name.replace(/_/g, " "), ...[s.p50_us, s.p99_us, s.max_us].map((us) => (us / 1000).toFixed(2))]);
  $("stages").replaceChildren(...rows.map((row, i) => {
    const tr = document.createElement("tr");
    tr.append(...row.map((cell) => element(i === 0 ? "th" : "td", cell)));
    return tr;
  }));
  const c = health.counters;
  const facts = [["Up", duration(health.uptime)], ["CPU", (100 * health.cpu).toFixed(1) + " % of a core"],
    ["Memory", Math.round(health.memory_mb) + " MB"],
    ["Disk free", health.disk_free_mb < 0 ? "nothing is written" : (health.disk_free_mb / 1000).toFixed(1) + " GB"]];
  if ("loop_closures" in c) facts.push(["Loop closures", c.loop_closures]);
  if (c.lost > 0 || c.relocalised > 0) facts.push(["Lost, found again", `${c.lost}, ${c.relocalised}`]);
  for (const [name, value] of Object.entries(c))
    if (name === "log.running") facts.push(["Log", ["stopped", "is being written", "cannot be written"][value]]);
    else if (name.startsWith("log.") || name.startsWith("record.")) facts.push([name.replace(/[._]/g, " "), value]);
  if (c["base.battery_mv"] > 0) facts.push(["Battery", (c["base.battery_mv"] / 1000).toFixed(1) + " V"]);
  showFacts($("computer"), facts);
}

// ---- drawing ------------------------------------------------------------------------------------------------------

let ground = "";  // colour beside the map
const dark = matchMedia("(prefers-color-scheme: dark)"), still = matchMedia("(prefers-reduced-motion: reduce)");
function takeColours() {
  ground = getComputedStyle(document.documentElement).getPropertyValue("--canvas").trim();
  redraw();
}
dark.addEventListener("change", takeColours);

let due = false;
function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(draw);
}

const px = (x) => (x - view.x) * view.scale + canvas.width / 2;
const py = (y) => (view.y - y) * view.scale + canvas.height / 2;
const mx = (x) => (x - canvas.width / 2) / view.scale + view.x;
const my = (y) => view.y - (y - canvas.height / 2) / view.scale;

function drawTiles(tiles, skip) {
  const size = robot.map.side * robot.map.resolution;
  for (const [key, tile] of tiles) {
    if (skip && skip.has(key)) continue;
    const left = px(tile.column * size), right = px((tile.column + 1) * size);
    const top = py((tile.row + 1) * size), bottom = py(tile.row * size);
    if (right < 0 || bottom < 0 || left > canvas.width || top > canvas.height) continue;
    // Whole pixels, so that no seam shows between tiles.
    const x = Math.round(left), y = Math.round(top);
    paint.drawImage(tile.picture, x, y, Math.round(right) - x, Math.round(bottom) - y);
  }
}

function drawPoints(list, colour, size) {
  paint.fillStyle = colour;
  for (let i = 0; i < list.length; i += 2) paint.fillRect(px(list[i]) - size / 2, py(list[i + 1]) - size / 2, size, size);
}

function drawTrail(ratio) {
  if (robot.trail.length < 4) return;
  paint.strokeStyle = "rgba(59, 130, 246, .75)";
  paint.lineWidth = 2 * ratio;
  paint.lineJoin = "round";
  paint.beginPath();
  for (let i = 0; i < robot.trail.length; i += 2) {
    const x = robot.trail[i] / 100, y = robot.trail[i + 1] / 100;
    const jump = i > 0 && Math.hypot(robot.trail[i] - robot.trail[i - 2], robot.trail[i + 1] - robot.trail[i - 1]) > 100;
    i === 0 || jump ? paint.moveTo(px(x), py(y)) : paint.lineTo(px(x), py(y));
  }
  paint.stroke();
}

function drawClosures(ratio) {
  const now = performance.now();
  let flashes = false;
  for (const closure of robot.closures) {
    const age = (now - closure.born) / kFlash;
    paint.strokeStyle = paint.fillStyle = "#8b5cf6";
    paint.beginPath();
    paint.arc(px(closure.x), py(closure.y), 3.5 * ratio, 0, 2 * Math.PI);
    paint.fill();
    if (age >= 1 || still.matches) continue;
    flashes = true;
    paint.globalAlpha = 1 - age;
    paint.lineWidth = 3 * ratio;
    paint.beginPath();
    paint.arc(px(closure.x), py(closure.y), (6 + 40 * (age * 2 % 1)) * ratio, 0, 2 * Math.PI);
    paint.stroke();
    paint.globalAlpha = 1;
  }
  if (flashes) redraw();
}

const kMarks = {  // colour, and how it is filled: never by colour alone
  localised: { colour: "#1a8f5a", fill: "solid" }, degraded: { colour: "#b26a00", fill: "hatched" },
  lost: { colour: "#66717c", fill: "dashed" }, initialising: { colour: "#66717c", fill: "dashed" },
};
let hatch = null;

function hatchOf(colour) {
  if (hatch) return hatch;
  const tile = document.createElement("canvas");
  tile.width = tile.height = 8;
  const context = tile.getContext("2d");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, 8, 8);
  context.strokeStyle = colour;
  context.lineWidth = 3;
  context.beginPath();
  for (const x of [-8, 0, 8]) context.moveTo(x, 8), context.lineTo(x + 8, 0);
  context.stroke();
  return hatch = paint.createPattern(tile, "repeat");
}

function drawRobot(ratio) {
  const p = robot.pose, [xx, xy, yy] = p.cov;
  const mark = robot.silent ? kMarks.lost : kMarks[p.state] || kMarks.lost;
  // Where it is with 95 %: half axes and direction of the covariance's ellipse. One larger than the screen is in words.
  const mean = (xx + yy) / 2, spread = Math.hypot((xx - yy) / 2, xy), k = 2.45;
  const a = k * Math.sqrt(Math.max(0, mean + spread)), b = k * Math.sqrt(Math.max(0, mean - spread));
  if (mark.fill !== "dashed" && a * view.scale < Math.max(canvas.width, canvas.height) / 2) {
    paint.strokeStyle = mark.colour;
    paint.lineWidth = ratio;
    paint.beginPath();
    paint.ellipse(px(p.x), py(p.y), Math.max(a * view.scale, 1), Math.max(b * view.scale, 1),
      -0.5 * Math.atan2(2 * xy, xx - yy), 0, 2 * Math.PI);
    paint.globalAlpha = 0.18;
    paint.fillStyle = mark.colour;
    paint.fill();
    paint.globalAlpha = 0.6;
    paint.stroke();
    paint.globalAlpha = 1;
  }
  drawArrow(p.x, p.y, p.theta, mark, ratio);
}

function drawArrow(x, y, theta, mark, ratio) {
  const r = Math.max(11 * ratio, 0.17 * view.scale);
  paint.save();
  paint.translate(px(x), py(y));
  paint.rotate(-theta);
  paint.beginPath();
  paint.moveTo(r, 0);
  paint.lineTo(-0.7 * r, 0.65 * r);
  paint.lineTo(-0.4 * r, 0);
  paint.lineTo(-0.7 * r, -0.65 * r);
  paint.closePath();
  paint.lineWidth = (mark.fill === "solid" ? 1.5 : 2) * ratio;
  paint.strokeStyle = mark.fill === "solid" ? "#fff" : mark.colour;
  paint.fillStyle = mark.fill === "hatched" ? hatchOf(mark.colour) : mark.colour;
  if (mark.fill === "dashed") paint.setLineDash([4 * ratio, 3 * ratio]);
  else paint.fill();
  paint.stroke();
  paint.restore();
}

function drawScale(ratio) {
  const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((m) => m * view.scale / ratio > 50) || 200;
  $("scale").firstElementChild.style.width = metres * view.scale / ratio + "px";
  $("scale").lastElementChild.textContent = metres + " m";
}

function draw() {
  due = false;
  const ratio = window.devicePixelRatio || 1;
  if (view.follow && robot.pose && !place.armed) {
    view.x = robot.pose.x;
    view.y = robot.pose.y;
  }
  paint.setTransform(1, 0, 0, 1, 0, 0);
  paint.imageSmoothingEnabled = view.scale * robot.map.resolution < 1;
  paint.fillStyle = ground;
  paint.fillRect(0, 0, canvas.width, canvas.height);
  const [both, lidar] = robot.map.tiles;
  if (view.layer === 1) drawTiles(both, lidar);  // what the depth camera has not seen is the lidar's alone
  drawTiles(robot.map.tiles[view.layer]);
  drawTrail(ratio);
  if (view.layer !== 2) drawPoints(robot.scan, "rgba(229, 62, 68, .9)", 2.5 * ratio);
  if (view.layer !== 1) drawPoints(robot.depth, "rgba(217, 115, 13, .9)", 2.5 * ratio);
  drawClosures(ratio);
  if (robot.pose) drawRobot(ratio);
  if (place.from) {
    const theta = Math.atan2(place.to.y - place.from.y, place.to.x - place.from.x);
    paint.strokeStyle = "#1f6feb";
    paint.lineWidth = 2 * ratio;
    paint.beginPath();
    paint.moveTo(px(place.from.x), py(place.from.y));
    paint.lineTo(px(place.to.x), py(place.to.y));
    paint.stroke();
    drawArrow(place.from.x, place.from.y, theta, { colour: "#1f6feb", fill: "solid" }, ratio);
  }
  drawScale(ratio);
}

function resize() {
  const ratio = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
  canvas.width = Math.max(1, Math.round(box.width * ratio));
  canvas.height = Math.max(1, Math.round(box.height * ratio));
  if (!view.moved && !view.follow) fit();
  redraw();
}

/// Shows the whole map.
function fit() {
  const side = robot.map.side, ratio = window.devicePixelRatio || 1;
  let left = Infinity, right = -Infinity, bottom = Infinity, top = -Infinity;  // [cells]
  for (const tile of robot.map.tiles[0].values()) {
    left = Math.min(left, tile.column * side + tile.left), right = Math.max(right, tile.column * side + tile.right);
    bottom = Math.min(bottom, tile.row * side + tile.bottom), top = Math.max(top, tile.row * side + tile.top);
  }
  if (left >= right) return;
  const cell = robot.map.resolution, above = ($("top").offsetHeight + 22) * ratio, below = 48 * ratio, beside = 16 * ratio;  // for what lies over it
  view.scale = Math.min((canvas.width - 2 * beside) / ((right - left) * cell),
    (canvas.height - above - below) / ((top - bottom) * cell));
  view.x = (left + right) / 2 * cell;
  view.y = (bottom + top) / 2 * cell + (above - below) / 2 / view.scale;
  view.moved = false;
  setFollow(false);
}

function setFollow(on) {
  view.follow = on;
  view.moved ||= on;
  $("follow").setAttribute("aria-pressed", on);
  redraw();
}

function zoom(factor, x = canvas.width / 2, y = canvas.height / 2) {
  const at = { x: mx(x), y: my(y) };
  view.scale = Math.min(2000, Math.max(0.5, view.scale * factor));
  view.x += at.x - mx(x);
  view.y += at.y - my(y);
  view.moved = true;
  redraw();
}

// ---- mouse and fingers --------------------------------------------------------------------------------------------

const fingers = new Map();
const at = (event) => {
  const ratio = window.devicePixelRatio || 1;
  return { x: event.offsetX * ratio, y: event.offsetY * ratio };
};

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, at(event));
  if (place.armed && fingers.size === 1) {
    const p = at(event);
    place.from = place.to = { x: mx(p.x), y: my(p.y) };
  } else {
    canvas.classList.add("dragging");
  }
});

canvas.addEventListener("pointermove", (event) => {
  const before = fingers.get(event.pointerId), now = at(event);
  if (!before) return;
  if (place.from) {
    place.to = { x: mx(now.x), y: my(now.y) };
  } else if (fingers.size === 1) {
    view.x -= (now.x - before.x) / view.scale;
    view.y += (now.y - before.y) / view.scale;
    view.moved = true;
    if (view.follow) setFollow(false);
  } else {
    const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
    const middle = { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 };
    view.x -= (now.x - before.x) / 2 / view.scale;
    view.y += (now.y - before.y) / 2 / view.scale;
    const apart = Math.hypot(before.x - other.x, before.y - other.y);
    if (apart > 0) zoom(Math.hypot(now.x - other.x, now.y - other.y) / apart, middle.x, middle.y);
    if (view.follow) setFollow(false);
  }
  fingers.set(event.pointerId, now);
  redraw();
});

function letGo(event) {
  fingers.delete(event.pointerId);
  if (fingers.size === 0) canvas.classList.remove("dragging");
  if (!place.from) return;
  const { from, to } = place;
  arm(false);
  if (event.type === "pointerup")
    command({ verb: "set_pose", x: from.x, y: from.y, theta: Math.atan2(to.y - from.y, to.x - from.x) });
}
canvas.addEventListener("pointerup", letGo);
canvas.addEventListener("pointercancel", letGo);
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const p = at(event);
  zoom(Math.exp(-event.deltaY * 0.0015), p.x, p.y);
}, { passive: false });

// ---- keys ---------------------------------------------------------------------------------------------------------

const kKeyStep = 60, kKeyTurn = Math.PI / 36;  // [pixel of the screen], [rad]
const kArrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/// Moves or turns the pose that is being drawn: it stands in the middle of the map.
function placeByKey(event, arrow) {
  const from = { x: view.x, y: view.y };
  let theta = place.from ? Math.atan2(place.to.y - place.from.y, place.to.x - place.from.x) : 0;
  if (arrow && event.shiftKey) theta -= kKeyTurn * (arrow[0] || -arrow[1]);
  const ahead = 60 / view.scale;
  place.from = from;
  place.to = { x: from.x + ahead * Math.cos(theta), y: from.y + ahead * Math.sin(theta) };
  return theta;
}

canvas.addEventListener("keydown", (event) => {
  const arrow = kArrows[event.key], ratio = window.devicePixelRatio || 1;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (arrow && !(place.armed && event.shiftKey)) {
    view.x += arrow[0] * kKeyStep * ratio / view.scale;
    view.y += arrow[1] * kKeyStep * ratio / view.scale;
    view.moved = true;
    if (view.follow) setFollow(false);
  }
  if (place.armed && (arrow || event.key === "Enter")) {
    const theta = placeByKey(event, arrow), from = place.from;
    if (event.key === "Enter") {
      arm(false);
      command({ verb: "set_pose", x: from.x, y: from.y, theta });
    }
  } else if (event.key === "Escape") arm(false);
  else if (event.key === "+" || event.key === "=") zoom(1.4);
  else if (event.key === "-") zoom(1 / 1.4);
  else if (event.key === "0" || event.key === "Home") fit();
  else if (event.key === "f" || event.key === "F") setFollow(!view.follow);
  else if (!arrow) return;
  event.preventDefault();
  redraw();
});

$("zoom-in").onclick = () => zoom(1.4);
$("zoom-out").onclick = () => zoom(1 / 1.4);
$("fit").onclick = fit;
$("follow").onclick = () => setFollow(!view.follow);
for (const button of document.querySelectorAll("[data-layer]")) {
  button.onclick = () => {
    view.layer = Number(button.dataset.layer);
    for (const other of document.querySelectorAll("[data-layer]")) other.setAttribute("aria-pressed", other === button);
    if (view.layer > 0 && !robot.map.layers) {
      robot.map.layers = true;
      robot.map.version = 0;  // the layers of all tiles, once
      fetchTiles();
    }
    redraw();
  };
}

// ---- commands -----------------------------------------------------------------------------------------------------

let token = sessionStorage.getItem("slamd-token") || "";

function showResult(words, bad) {
  $("result").textContent = words;
  $("result").classList.toggle("bad", Boolean(bad));
}

async function unlock(given) {
  try {
    const answer = await fetch("/api/v1/allowed", { headers: { Authorization: "Bearer " + given } });
    if (!answer.ok) {
      sessionStorage.removeItem("slamd-token");
      return showResult(await answer.text(), true);
    }
  } catch (error) { return showResult("slam-web does not answer", true); }
  token = given;
  sessionStorage.setItem("slamd-token", given);
  $("login").hidden = true;
  $("actions").hidden = false;
  showResult("");
}

async function command(request) {
  showResult("\u2026");
  for (const button of $("actions").querySelectorAll("button")) button.disabled = true;
  try {
    const answer = await fetch("/api/v1/command", {
      method: "POST", body: JSON.stringify(request),
      headers: { "Content-Type": "application/json", Authorization: "Bearer " + token },
    });
    const text = await answer.text();
    let words = text;
    try { words = JSON.parse(text).message; } catch (error) { /* a refusal is plain text */ }
    showResult(words, !answer.ok);
  } catch (error) { showResult("slam-web does not answer", true); }
  for (const button of $("actions").querySelectorAll("button")) button.disabled = false;
}

/// The next drag draws a pose.
function arm(on) {
  place.armed = on;
  place.from = place.to = null;
  canvas.classList.toggle("placing", on);
  $("set-pose").setAttribute("aria-pressed", on);
  $("hint").hidden = !on;
  $("hint").textContent = "Press where the robot stands and drag to where it looks; or arrow keys, Shift with them to turn, Enter";
  if (on) canvas.focus();
  redraw();
}

$("login").onsubmit = (event) => { event.preventDefault(); unlock($("token").value); };
$("mark").onsubmit = (event) => {
  event.preventDefault();
  if ($("mark-text").value.trim()) command({ verb: "log_mark", text: $("mark-text").value.trim() });
};
$("save").onclick = () => command({ verb: "save" });
$("localise").onclick = () => command({ verb: "mode", mode: "localise" });
$("slam").onclick = () => command({ verb: "mode", mode: "slam" });
$("set-pose").onclick = () => arm(!place.armed);

takeColours();
new ResizeObserver(resize).observe(canvas);
resize();
setInterval(showState, 500);
if (token) unlock(token);
connect();
