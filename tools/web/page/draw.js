// SPDX-License-Identifier: BSD-3-Clause
"use strict";

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
const hatches = new Map();

function hatchOf(colour) {
  if (hatches.has(colour)) return hatches.get(colour);
  const tile = element("canvas");
  tile.width = tile.height = 8;
  const context = tile.getContext("2d");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, 8, 8);
  context.strokeStyle = colour;
  context.lineWidth = 3;
  context.beginPath();
  for (const x of [-8, 0, 8]) context.moveTo(x, 8), context.lineTo(x + 8, 0);
  context.stroke();
  hatches.set(colour, paint.createPattern(tile, "repeat"));
  return hatches.get(colour);
}

function drawRobot(ratio) {
  const p = robot.pose, [xx, xy, yy] = p.cov;
  const mark = robot.silent ? kMarks.lost : kMarks[p.state] || kMarks.lost;
  // Where it is with 95 %: half axes and direction of the covariance's ellipse. One larger than the screen is in words.
  const mean = (xx + yy) / 2, spread = Math.hypot((xx - yy) / 2, xy), k = 2.45;
  const a = k * Math.sqrt(Math.max(0, mean + spread)), b = k * Math.sqrt(Math.max(0, mean - spread));
  const valid = mark.fill !== "dashed", fits = a * view.scale < Math.min(canvas.width, canvas.height) / 2;
  showWithin(valid && !fits ? a : 0);
  if (valid && fits) {
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
  $("scale").lastElementChild.textContent = number(metres, metres < 1 ? 1 : 0) + " m";
}

function draw() {
  due = false;
  const ratio = ratioOf();
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
  drawEdits(ratio);
  if (view.layer !== 2) drawPoints(robot.scan, "rgba(229, 62, 68, .9)", 2.5 * ratio);
  if (view.layer !== 1) drawPoints(robot.depth, "rgba(217, 115, 13, .9)", 2.5 * ratio);
  drawClosures(ratio);
  if (robot.pose) drawRobot(ratio);
  drawHappening(ratio);
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
  const ratio = ratioOf(), box = canvas.getBoundingClientRect();
  canvas.width = Math.max(1, Math.round(box.width * ratio));
  canvas.height = Math.max(1, Math.round(box.height * ratio));
  if (!view.moved && !view.follow) fit();
  redraw();
}

/// Shows the whole map.
function fit() {
  const side = robot.map.side, ratio = ratioOf();
  let left = Infinity, right = -Infinity, bottom = Infinity, top = -Infinity;  // [cells]
  for (const tile of robot.map.tiles[0].values()) {
    left = Math.min(left, tile.column * side + tile.left), right = Math.max(right, tile.column * side + tile.right);
    bottom = Math.min(bottom, tile.row * side + tile.bottom), top = Math.max(top, tile.row * side + tile.top);
  }
  if (left >= right) return;
  const cell = robot.map.resolution, above = ($("top").offsetHeight + 22) * ratio, below = (edit.on ? $("edit").offsetHeight + 16 : 48) * ratio, beside = 16 * ratio;  // for what lies over it
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
