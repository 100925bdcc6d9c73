// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- the set-up's page: shows what slamctl setup --web asks and finds, the same on each phone ---------------------------

const kLook = 500;  // [ms]
const kSteps = ["find", "ask", "drive", "calibrate", "write", "check"];
// What most robots have, to be tapped; the rest is typed.
const kUsual = {
  "lidar.yaw": ["0", "1.5708", "3.14159", "-1.5708"], "lidar.upside_down": ["false", "true"], "lidar.y": ["0"], "imu.roll": ["0", "3.14159"],
  "base.type": ["differential", "omni3", "mecanum4"],
};
window.slam = {};

let setup = null, shown = "", ended = false;

function showBanner(words) {
  $("banner").hidden = words === "";
  $("banner").textContent = words;
}

async function look() {
  if (ended) return;
  try {
    const answer = await fetch("/api/v1/setup", { headers: authorized() });
    if (answer.ok) {
      setup = await answer.json();
      unlocked = true;
      sessionStorage.setItem("slamd-token", token);
      showBanner("");
      showAll();
    } else {
      showBanner(answer.status === 404 ? t("setupNone") : answer.status === 401 ? t("setupToken") : await messageOf(answer));
    }
  } catch (error) { if (!ended) showBanner(t("setupAway")); }
}

async function reply(words) {
  const question = setup.question;
  for (const button of all("#question button")) button.disabled = true;
  try {
    const answer = await fetch("/api/v1/setup/answer", {
      method: "POST", headers: authorized(), body: JSON.stringify({ number: question.number, answer: words }) });
    $("refusal").textContent = answer.ok ? "" : await messageOf(answer);
    ended = answer.ok && question.id === "finish";
  } catch (error) { showBanner(t("setupAway")); }
  for (const button of all("#question button")) button.disabled = false;
  if (!ended) return look();
  $("question").hidden = true;
  showBanner(t("ended"));
}

function questionWords(question) {
  const id = question.kind === "choice" ? "choose" : question.id;
  return language === "de" && kGermanQuestions[id] || question.text;
}

function button(words, answer, isMain) {
  const made = element("button", words, isMain ? "main" : "");
  made.onclick = () => reply(answer);
  return made;
}

function showQuestion(question) {
  $("question").hidden = !question;
  const now = JSON.stringify([question, language]);
  if (!question || now === shown) return;  // what is being typed stays
  shown = now;
  const isText = question.kind === "text", mount = question.id.startsWith("lidar.") && ["x", "y", "yaw"].includes(question.id.slice(6));
  $("question-text").textContent = question.id === "finish" ? "" : questionWords(question);  // its button names it
  $("error").textContent = question.error;
  $("answer").hidden = !isText;
  $("typed").value = "";
  $("typed").placeholder = question.default.replace(/^"(.*)"$/, "$1");
  $("axes").toggleAttribute("hidden", !mount);
  $("axes-words").hidden = !mount;
  for (const part of all("#axes g")) part.classList.toggle("asked", question.id === "lidar." + part.classList[0]);
  const list = question.id === "finish" ? [button(t("finish"), "y", true)]
    : question.kind === "yes_no" ? [button(t("yes"), "y", true), button(t("no"), "n")]
      : question.kind === "choice" ? [...question.choices.map((name, i) => button(name, String(i + 1))), button(t("again"), "")]
        : (kUsual[question.id] || []).map((value) => button(value, value));
  $("choices").replaceChildren(...list);
}

function showSteps() {
  const at = kSteps.indexOf(setup.step), now = at < 0 ? kSteps.length : at;
  $("steps").replaceChildren(...kSteps.map((name, i) => element("li", t("step" + name), i < now ? "past" : i === now ? "now" : "")));
}

function showDevices() {
  const level = (device) => device.problem ? "fault" : device.name ? "good" : "";
  $("found").hidden = !setup.devices;
  $("devices").replaceChildren(...(setup.devices || []).flatMap((device) => {
    const words = device.problem ? wordsOf(device.problem) : null;
    const line = element("p", "", level(device));
    line.append(element("b", words ? words.cause : device.name || t("nothing")), element("br"), `${device.port}${device.adapter ? " (" + device.adapter + ")" : ""}${device.baud > 0 ? ", " + device.baud + " bit/s" : ""}`);
    if (words && words.fix) line.append(element("br"), words.fix);
    return [line];
  }));
}

function showDrive() {
  const progress = setup.progress, drives = setup.step === "drive";
  $("driving").hidden = !drives && setup.step !== "calibrate";
  $("how").textContent = !progress ? t("waits") : progress.over ? t("over") : t(setup.joystick ? "hold" : "push");
  const stick = Boolean(drives && setup.joystick && progress && !progress.over);
  if (!stick) letGoOfStick();
  $("drive").hidden = !stick;
  if (setup.joystick) limits.speed = setup.joystick.max_speed, limits.turn = setup.joystick.max_turn_rate;
  if (!progress) return showFacts($("progress"), []);
  const row = (have, need, words) => have >= need ? t("enough", words(have)) : t("missing", words(have), words(need - have));
  const metres = (way) => number(way, 1) + " m", turned = (angle) => number(angle * 180 / Math.PI, 0) + "°";
  showFacts($("progress"), [
    [t("time"), `${Math.round(Math.min(progress.seconds, progress.length))} / ${Math.round(progress.length)} s`],
    [t("straight"), row(progress.straight, progress.enough_straight, metres)], [t("left"), row(progress.left, progress.enough_turn, turned)],
    [t("right"), row(progress.right, progress.enough_turn, turned)]]);
}

function showCalibration() {
  const found = setup.calibration, none = setup.no_calibration;
  $("calibration").hidden = !found && !none;
  $("open").textContent = none ? t("notCalibrated", none) : found ? found.open : "";
  if (!found) return;
  const line = (tag, cells) => { const made = element("tr"); made.append(...cells.map((cell) => element(tag, cell))); return made; };
  $("values").replaceChildren(line("th", [t("value"), t("before"), t("after"), t("interval")]), ...found.values.map((value) => line("td", [
    `${value.key} [${value.unit}]: ${t(value.wrong ? "changed" : "stays")}`, number(value.configured, 4), number(value.wrong ? value.estimated : value.configured, 4), number(value.interval, 4)])));
  const [before, after] = found.translation.map((metres) => number(1000 * metres, 1)), [turn, turned] = found.rotation.map((angle) => number(angle * 180 / Math.PI, 2));
  $("fit").textContent = t("rms", before, turn, after, turned) + (found.gyro[0] !== 0 ? " " + t("gyro", number(found.gyro[0], 3), number(found.gyro[1], 3)) : "");
}

let pictured = 0;  // number of the pictures that are shown

/// An image itself would send no token.
async function showPicture(name) {
  const figure = $("picture-" + name);
  figure.hidden = !setup.pictures[name];
  if (!setup.pictures[name]) return;
  const answer = await fetch(`/api/v1/setup/${name}.png`, { headers: authorized() });
  if (!answer.ok) return;
  const reader = new FileReader();
  reader.onload = () => { figure.querySelector("img").src = reader.result; };
  reader.readAsDataURL(await answer.blob());
}

function showPictures() {
  const pictures = setup.pictures;
  $("drawn").hidden = !pictures || !pictures.map;
  for (const image of all("[data-alt]")) image.alt = t(image.dataset.alt);
  if (!pictures || pictures.number === pictured) return;
  pictured = pictures.number;
  for (const name of ["scans", "map"]) showPicture(name).catch(() => { pictured = 0; });
}

function showOutcome() {
  const changes = setup.changes, outcome = setup.outcome, findings = setup.findings;
  $("changes").hidden = !changes;
  if (changes) {
    $("changes-name").textContent = t(changes.same ? "same" : outcome && outcome.written ? "wrote" : "changes", changes.file);
    const lines = changes.lines.length > 0 || changes.same ? changes.lines : [t("noValue")];
    $("change-list").replaceChildren(...lines.map((words) => element("li", words)));
  }
  $("check").hidden = !findings;
  $("findings").replaceChildren(...(findings || []).map((finding) => {
    const line = element("p", "", finding.level);
    line.append(element("b", finding.what), ...(finding.fix ? [element("br"), finding.fix] : []));
    return line;
  }));
  $("outcome").hidden = !outcome && !setup.failure;
  $("verdict").textContent = setup.failure ? t("failed", setup.failure) : !outcome ? "" : !outcome.written ? t("notWritten") : outcome.faults === 0 ? t("allGood") : t("faults", outcome.faults);
  $("after").textContent = !outcome ? "" : outcome.service === null ? t("start") : t(outcome.service ? "serviceRuns" : "serviceFails");
  const live = new URL(location);
  live.port = outcome ? outcome.live_port : 0;
  live.hash = live.pathname = "";
  $("live").hidden = !outcome || outcome.live_port === 0;
  $("live").href = live.href;
}

function showAll() {
  if (!setup) return;
  showSteps();
  showQuestion(setup.question);
  showDevices();
  showDrive();
  showCalibration();
  showPictures();
  showOutcome();
  showFacts($("answered"), setup.answered.map(({ id, answer }) => [id, answer || "–"]));
  if ($("log").textContent !== setup.log) $("log").textContent = setup.log;
}

function askForToken() { showBanner(t("setupToken")); }

$("answer").onsubmit = (event) => { event.preventDefault(); reply($("typed").value); };
$("language").onchange = () => choose($("language").value);
document.addEventListener("DOMContentLoaded", () => {
  $("stop").onclick = () => { letGoOfStick(); stop(0); };
  translate();
  look();
  setInterval(look, kLook);
});
