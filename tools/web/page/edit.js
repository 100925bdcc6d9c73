// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- what is drawn into the map -----------------------------------------------------------------------------------

// How each kind looks: never by colour alone. A tool is a kind, and the brush.
const kEdits = {
  erase: { colour: "#46515c", dash: [2, 4] }, zone: { colour: "#b3261e", fill: true }, wall: { colour: "#7b2d8b", wide: 4 },
  free: { colour: "#0a6b52", dash: [7, 4] }, room: { colour: "#1a5fd0", dash: [1, 3] }, place: { colour: "#1a5fd0" },
};
// Points and strokes [m] that are drawn and not applied.
const edit = { on: false, tool: "erase", points: [], strokes: [], drawing: null, theta: 0, force: false, busy: false, target: null };
robot.edits = [];
window.slam.edit = edit;

takers.edits = (data) => {
  robot.edits = data;
  if (edit.on) window.slam.edited = performance.now();
  redraw();
};

function tracePath(points, closed) {
  paint.beginPath();
  points.forEach(([x, y], i) => i === 0 ? paint.moveTo(px(x), py(y)) : paint.lineTo(px(x), py(y)));
  if (closed) paint.closePath();
}

function drawLabel(words, x, y, colour, ratio) {
  paint.font = `600 ${12 * ratio}px system-ui, sans-serif`;
  paint.textAlign = "center";
  paint.lineWidth = 4 * ratio;
  paint.strokeStyle = "#fff";
  paint.fillStyle = colour;
  paint.setLineDash([]);
  paint.strokeText(words, x, y);
  paint.fillText(words, x, y);
}

const middleOf = (points, i) => points.reduce((sum, point) => sum + point[i], 0) / points.length;

function drawEdit(kind, points, name, theta, ratio, chosen) {
  const { colour, dash, fill, wide } = kEdits[kind], closed = kind !== "wall" && points.length > 2;
  if (kind === "place") {
    const [x, y] = [px(points[0][0]), py(points[0][1])], r = 9 * ratio;
    paint.beginPath();
    paint.arc(x, y, r, -theta, 2 * Math.PI - theta);
    paint.lineTo(x + 2.4 * r * Math.cos(theta), y - 2.4 * r * Math.sin(theta));
    paint.lineWidth = 3 * ratio;
    paint.strokeStyle = colour;
    paint.stroke();
  } else {
    tracePath(points, closed);
    paint.strokeStyle = colour;
    paint.lineWidth = (wide || 2) * ratio;
    paint.setLineDash((dash || []).map((length) => length * ratio));
    if (fill) {
      paint.globalAlpha = 0.35;
      paint.fillStyle = hatchOf(colour);
      paint.fill();
      paint.globalAlpha = 1;
    }
    paint.stroke();
    paint.setLineDash([]);
  }
  const words = chosen ? "\u2715 " + t("toolremove") : name || (edit.on && name === "" && kind !== "erase" ? t("tool" + kind) : "");
  if (words) drawLabel(words, px(middleOf(points, 0)), py(middleOf(points, 1)) + (kind === "place" ? 26 : 4) * ratio, colour, ratio);
}

function drawEdits(ratio) {
  for (const one of robot.edits)
    if (one.kind in kEdits && (edit.on || one.kind !== "erase")) drawEdit(one.kind, one.points, one.name, one.theta, ratio, one.id === edit.target);
  if (edit.on) drawDraft(ratio);
}

$("edit-map").onclick = () => unlocked ? withMore(() => editMode(!edit.on)) : askForToken();
