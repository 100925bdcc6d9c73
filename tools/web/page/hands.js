// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- mouse and fingers --------------------------------------------------------------------------------------------

const fingers = new Map();
const at = (event) => {
  const ratio = ratioOf();
  return { x: event.offsetX * ratio, y: event.offsetY * ratio };
};

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, at(event));
  if (place.armed && fingers.size === 1) {
    const p = at(event);
    place.from = place.to = { x: mx(p.x), y: my(p.y) };
  } else if (edit.on && event.button === 0 && !edit.busy) {
    fingers.size === 1 ? beginDrawing(at(event)) : endDrawing();
  } else {
    canvas.classList.add("dragging");
  }
});

canvas.addEventListener("pointermove", (event) => {
  const before = fingers.get(event.pointerId), now = at(event);
  if (!before) return;
  if (place.from) {
    place.to = { x: mx(now.x), y: my(now.y) };
  } else if (edit.on && fingers.size === 1 && !canvas.classList.contains("dragging")) {
    goOnDrawing(now);
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
  const last = fingers.size === 1;
  fingers.delete(event.pointerId);
  if (edit.on && last) endDrawing(event.type === "pointerup" ? at(event) : null);
  if (fingers.size === 0) canvas.classList.remove("dragging");
  if (!place.from) return;
  const { from, to } = place;
  arm(false);
  if (event.type === "pointerup")
    command({ verb: "set_pose", x: from.x, y: from.y, theta: Math.atan2(to.y - from.y, to.x - from.x) });
}
// Else the browser takes a fast drag for a fling, and loses the tap behind it.
canvas.addEventListener("touchstart", (event) => event.preventDefault(), { passive: false });
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
  const arrow = kArrows[event.key], ratio = ratioOf();
  if (edit.on && editByKey(event)) {
    event.preventDefault();
    return redraw();
  }
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
for (const button of all("[data-layer]")) {
  button.onclick = () => {
    view.layer = Number(button.dataset.layer);
    for (const other of all("[data-layer]")) other.setAttribute("aria-pressed", other === button);
    if (view.layer > 0 && !robot.map.layers) {
      robot.map.layers = true;
      robot.map.version = 0;  // the layers of all tiles, once
      fetchTiles();
    }
    redraw();
  };
}
