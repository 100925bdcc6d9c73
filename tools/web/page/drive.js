// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- driving ------------------------------------------------------------------------------------------------------

const kDrivePeriod = 80;    // [ms] slam-web stops the robot after 250 ms without a speed
const kAnswerLimit = 500;   // [ms] without an answer: the link is lost
const kStopPeriod = 150;    // [ms] between tries of a stop, until one is answered
const kStopTries = 10;
const kNoteTime = 6000;     // [ms]
const kDeadZone = 0.12, kByKey = 0.6;  // [1] of the stick's full way
const kDriveArrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const limits = { speed: 0, turn: 0 };  // [m/s], [rad/s]
// A press lasts from the finger's touch to its release; x to the right and y ahead [1]; hold numbers a press for slam-web.
const drive = { pressed: false, pointer: null, keys: new Set(), x: 0, y: 0, hold: 0, last: 0, answered: 0, timer: null, flying: null };
window.slam.drive = drive;
const stick = $("stick");

let note = null;

/// For a while, over the map.
function showNote(words) {
  clearTimeout(note);
  $("note").textContent = words;
  $("note").hidden = words === "";
  note = setTimeout(() => showNote(""), kNoteTime);
}

function postDrive(speed, options) {
  return fetch("/api/v1/drive", { method: "POST", body: JSON.stringify(speed), headers: authorized(), ...options });
}

/// Sends a zero, again and again until it is answered. What the page does else is no matter.
function stop(hold) {
  const state = { done: false, tries: 0 };
  const attempt = () => {
    if (state.done) return;
    if (state.tries++ >= kStopTries) return showNote(t("unconfirmed"));
    postDrive({ vx: 0, omega: 0, hold }, { keepalive: true }).then(async (answer) => {
      if (!answer.ok && answer.status >= 500) return;  // it is tried again
      if (!state.done && hold === 0) showNote(answer.ok ? t("stopped") : await messageOf(answer));
      state.done = true;
    }).catch(() => {});
    setTimeout(attempt, kStopPeriod);
  };
  attempt();
}

/// Ends what is driven: at once, and whatever the reason.
function letGoOfStick(words) {
  if (!drive.pressed) return;
  const hold = drive.hold;
  clearInterval(drive.timer);
  drive.pressed = false;
  drive.pointer = null;
  drive.keys.clear();
  drive.x = drive.y = drive.hold = 0;
  if (drive.flying) drive.flying.abort();  // the zero goes before them
  if (hold !== 0) stop(hold);
  if (words) showNote(words);
  showStick();
}

async function sendSpeed() {
  if (drive.hold !== 0 && performance.now() - drive.answered > kAnswerLimit) return letGoOfStick(t("linkLost"));
  const way = Math.hypot(drive.x, drive.y);
  if (way < kDeadZone) {
    if (drive.hold !== 0) stop(drive.hold);
    drive.hold = 0;
    return;
  }
  if (drive.hold === 0) {
    drive.hold = drive.last = Math.max(1000 * Date.now() + Math.floor(1000 * Math.random()), drive.last + 1);
    drive.answered = performance.now();
    drive.flying = new AbortController();
  }
  const hold = drive.hold;
  try {  // slow near the middle: by the square
    const answer = await postDrive({ vx: way * drive.y * limits.speed, omega: -way * drive.x * limits.turn, hold }, { signal: drive.flying.signal });
    if (hold !== drive.hold) return;
    if (answer.ok) drive.answered = performance.now();
    else letGoOfStick(t("notDriven", await messageOf(answer)));
  } catch (error) {
    if (hold === drive.hold) letGoOfStick(t("linkLost"));
  }
}

function press() {
  if (drive.pressed || !unlocked) return;
  drive.pressed = true;
  drive.hold = 0;
  drive.timer = setInterval(sendSpeed, kDrivePeriod);
}

function showStick() {
  stick.classList.toggle("held", drive.pressed);
  stick.firstElementChild.style.transform = `translate(${36 * drive.x}px, ${-36 * drive.y}px)`;
}

function moveStick(event) {
  const box = stick.getBoundingClientRect(), reach = box.width / 2;
  const x = (event.clientX - box.left - reach) / reach, y = (box.top + reach - event.clientY) / reach, way = Math.max(1, Math.hypot(x, y));
  drive.x = x / way;
  drive.y = y / way;
  showStick();
}

stick.addEventListener("pointerdown", (event) => {
  event.preventDefault();
  if (drive.pressed) return;
  stick.focus();
  press();
  drive.pointer = event.pointerId;
  stick.setPointerCapture(event.pointerId);
  moveStick(event);
  sendSpeed();
});
stick.addEventListener("pointermove", (event) => { if (drive.pressed && event.pointerId === drive.pointer) moveStick(event); });
for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
  stick.addEventListener(end, (event) => { if (event.pointerId === drive.pointer) letGoOfStick(); });
stick.addEventListener("contextmenu", (event) => event.preventDefault());
// A second finger, wherever it is.
addEventListener("pointerdown", (event) => { if (drive.pressed && event.pointerId !== drive.pointer) letGoOfStick(); }, true);

function moveByKeys() {
  drive.x = drive.y = 0;
  for (const key of drive.keys) drive.x += kByKey * kDriveArrows[key][0], drive.y += kByKey * kDriveArrows[key][1];
  showStick();
}
stick.addEventListener("keydown", (event) => {
  if (event.key === "Escape") return letGoOfStick();
  if (!(event.key in kDriveArrows) || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  if (event.repeat || drive.pointer !== null) return;
  press();
  if (!drive.pressed) return;
  drive.keys.add(event.key);
  moveByKeys();
  sendSpeed();
});
stick.addEventListener("keyup", (event) => {
  if (!drive.keys.delete(event.key)) return;
  if (drive.keys.size === 0) letGoOfStick();
  else moveByKeys();
});
stick.addEventListener("blur", () => letGoOfStick());
for (const end of ["blur", "pagehide", "offline"]) addEventListener(end, () => letGoOfStick());
document.addEventListener("visibilitychange", () => { if (document.hidden) letGoOfStick(); });

function showStop() {
  $("stop").textContent = t(unlocked ? "stop" : "stopLocked");
  $("stop").classList.toggle("locked", !unlocked);
  $("stick").hidden = !unlocked;
}
$("stop").onclick = () => {
  letGoOfStick();
  unlocked ? stop(0) : askForToken();
};
