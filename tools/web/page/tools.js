// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- drawing into the map: loaded when somebody begins to ---------------------------------------------------------

const kTools = ["erase", "brush", "zone", "wall", "free", "room", "place", "remove"];
const kBrush = 18, kTap = 8;  // [pixel of the screen] radius; way of a finger that taps
const isOutline = () => !["brush", "wall", "place", "remove"].includes(edit.tool);

function drawDraft(ratio) {
  const points = edit.points.concat(edit.drawing && edit.tool !== "brush" ? edit.drawing : []);
  paint.lineCap = paint.lineJoin = "round";
  paint.strokeStyle = "#46515c";
  paint.globalAlpha = 0.5;
  for (const { path, radius } of edit.strokes) {
    tracePath(path.length > 1 ? path : [path[0], path[0]]);
    paint.lineWidth = 2 * radius * view.scale;
    paint.stroke();
  }
  paint.globalAlpha = 1;
  paint.lineCap = "butt";
  if (edit.tool === "remove") return;
  if (edit.tool === "place" && points.length > 0) drawEdit("place", points, $("edit-name").value, edit.theta, ratio);
  else if (points.length > 0) {
    drawEdit(edit.tool, points, null, 0, ratio);
    paint.fillStyle = kEdits[edit.tool].colour;
    for (const [x, y] of edit.points) paint.fillRect(px(x) - 4 * ratio, py(y) - 4 * ratio, 8 * ratio, 8 * ratio);
  }
  if (document.activeElement !== canvas || !canvas.matches(":focus-visible")) return;
  paint.fillStyle = "#1a5fd0";  // where a key draws
  paint.fillRect(canvas.width / 2 - 12 * ratio, canvas.height / 2 - ratio, 24 * ratio, 2 * ratio);
  paint.fillRect(canvas.width / 2 - ratio, canvas.height / 2 - 12 * ratio, 2 * ratio, 24 * ratio);
}

/// Id of the edit under a finger: of several, the one whose middle is nearest; undefined: there is none.
function editUnder({ x, y }) {
  const hit = ({ points, kind }) => {
    tracePath(points, kind !== "wall");
    if (points.length < 2) paint.arc(px(points[0][0]), py(points[0][1]), 20 * ratioOf(), 0, 7);
    paint.lineWidth = 30 * ratioOf();
    return paint.isPointInPath(x, y) || paint.isPointInStroke(x, y);
  };
  const off = ({ points }) => Math.hypot(px(middleOf(points, 0)) - x, py(middleOf(points, 1)) - y);
  return robot.edits.filter(hit).sort((a, b) => off(a) - off(b))[0]?.id;
}

// ---- one finger draws ---------------------------------------------------------------------------------------------

const placeOf = (p) => [mx(p.x), my(p.y)];

function beginDrawing(p) {
  edit.from = p;
  edit.drawing = [placeOf(p)];
  if (edit.tool === "brush") edit.strokes.push({ path: edit.drawing, radius: kBrush * ratioOf() / view.scale });
  if (edit.tool === "place") edit.points = [], edit.theta = 0;
}

function goOnDrawing(p) {
  if (!edit.drawing) return;
  const [x, y] = placeOf(p), [x0, y0] = edit.drawing[0];
  if (edit.tool === "wall") edit.drawing = [[x0, y0], [x, y]];
  else if (edit.tool === "place") edit.theta = Math.atan2(y - y0, x - x0);
  else edit.drawing.push([x, y]);
}

/// @param p where the finger went up; nothing: another one came down, and it is no drawing
function endDrawing(p) {
  const drawn = edit.drawing;
  edit.drawing = null;
  if (!drawn) return;
  edit.force = false;
  if (edit.tool === "brush") {
    if (!p) edit.strokes.pop();
  } else if (edit.tool === "remove") {
    edit.target = p && editUnder(p);
  } else if (p) {
    const tapped = Math.hypot(p.x - edit.from.x, p.y - edit.from.y) < kTap * ratioOf() && drawn.length < 30;
    if (edit.tool === "wall" && edit.points.length > 0) edit.points.push(drawn[drawn.length - 1]);
    else edit.points.push(...(tapped || edit.tool === "place" ? [drawn[0]] : edit.tool === "wall" ? drawn : fewCorners(drawn, 3 * ratioOf() / view.scale)));
  }
  showEdit();
}

// ---- the bar ------------------------------------------------------------------------------------------------------

const isNamed = () => edit.tool === "room" || edit.tool === "place";

function isReady() {
  const n = edit.points.length;
  if (edit.tool === "remove") return edit.target > 0;
  if (isNamed() && !$("edit-name").value.trim()) return false;
  return edit.tool === "brush" ? edit.strokes.length > 0 : edit.tool === "wall" ? n > 1 : n > 2 || (n === 1 && isNamed());
}

function showEdit(words, bad) {
  document.body.classList.toggle("editing", edit.on);
  canvas.classList.toggle("placing", edit.on);
  $("edit").hidden = !edit.on;
  $("edit-map").setAttribute("aria-pressed", edit.on);
  for (const one of $("tools").children) one.setAttribute("aria-pressed", one.value === edit.tool);
  $("edit-name").hidden = !isNamed();
  $("apply").textContent = t(edit.force ? "force" : "apply");
  $("apply").disabled = edit.busy || !isReady();
  $("drop").disabled = edit.busy || (edit.points.length + edit.strokes.length === 0 && !edit.target);
  $("edit-hint").textContent = words || t("hint" + (isOutline() ? "outline" : edit.tool));
  $("edit-hint").classList.toggle("bad", Boolean(bad));
  document.body.style.setProperty("--bar", $("edit").offsetHeight + "px");
  redraw();
}

function drop() {
  edit.points = [];
  edit.strokes = [];
  edit.drawing = edit.target = null;
  edit.force = false;
  showEdit();
}

function editMode(on) {
  edit.on = on;
  if (on) arm(false), setFollow(false);
  drop();
  if (!view.moved) resize(), fit();
  if (on) canvas.focus({ preventScroll: true });
}

function take(tool) {
  edit.tool = tool;
  drop();
}

const rounded = (points) => points.map((point) => point.map((value) => Math.round(100 * value) / 100));

/// Sends what is drawn. What slamd refuses stays, with the reason.
async function apply() {
  if (edit.busy || !isReady()) return;
  if (edit.tool === "remove") return send([{ verb: "map_remove", id: edit.target }], true);
  const name = isNamed() ? { name: $("edit-name").value.trim() } : {};
  const kind = edit.tool === "brush" ? "erase" : edit.tool;
  const outlines = edit.tool === "brush" ? outlinesOf(edit.strokes) : [edit.points];
  await send(outlines.map((points) => ({ verb: "map_edit", edit: { kind, points: rounded(points), by: "slam-web", ...name,
    ...(kind === "place" && { theta: edit.theta }), ...(edit.force && { force: true }) } })), true);
}

async function send(requests, draft) {
  edit.busy = true;
  showEdit(t("sending"));
  let answer = { ok: true };
  for (const request of requests) if (answer.ok) answer = await ask(request);
  edit.busy = false;
  if (answer.ok && draft) $("edit-name").value = "", drop();
  else if (draft)  // slamd's refusal, not a wrong outline: an erase may be forced
    edit.force = ["erase", "brush"].includes(edit.tool) && answer.status === 409;
  showEdit(answer.words, !answer.ok);
}

for (const tool of kTools) {
  const made = button("tool" + tool, () => take(tool));
  made.value = tool;
  made.dataset.text = "tool" + tool;
  $("tools").append(made);
}
$("leave").onclick = () => editMode(false);
$("undo").onclick = () => send([{ verb: "map_undo" }]);
$("redo").onclick = () => send([{ verb: "map_redo" }]);
$("apply").onclick = apply;
$("drop").onclick = drop;
$("edit-name").oninput = () => showEdit();
$("edit-name").onkeydown = (event) => { if (event.key === "Enter") apply(); };

/// @return whether the key was one of the edit mode's
function editByKey(event) {
  const key = event.key.toLowerCase(), arrow = kArrows[event.key];
  if (event.ctrlKey || event.metaKey) {
    if (key !== "z" && key !== "y") return false;
    send([{ verb: key === "y" || event.shiftKey ? "map_redo" : "map_undo" }]);
  } else if (key === " ") {
    const middle = { x: canvas.width / 2, y: canvas.height / 2 };
    beginDrawing(middle);
    endDrawing(middle);
  } else if (arrow && event.shiftKey && edit.tool === "place") {
    edit.theta -= kKeyTurn * (arrow[0] || -arrow[1]);
  } else if (key === "backspace") {
    (edit.tool === "brush" ? edit.strokes : edit.points).pop();
    showEdit();
  } else if (key === "enter") apply();
  else if (key === "escape") edit.points.length + edit.strokes.length > 0 ? drop() : editMode(false);
  else return false;
  return true;
}
