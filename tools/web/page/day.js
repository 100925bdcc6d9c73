// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- what happened over the last day ------------------------------------------------------------------------------

const kDayPeriod = 30000, kLogLooks = 10, kHour = 3.6e9;  // [ms] between looks at it; looks for one at the logs; [us]
const kLanes = { state: 0, device: 1, drive: 2, mark: 2 };
const kInks = { drive: "accent", mark: "ink", device: "fault", localised: "good", silent: "soft", lost: "fault" };
const kHollow = ["initialising", "silent"];  // else as high as degraded and lost
const kStates = { localised: 0.3, degraded: 0.65, initialising: 0.65, lost: 1, silent: 1 };  // [1] height in its lane
const day = { list: [], since: 0, now: 0, hours: 0, chosen: null };
window.slam.day = day;
const periods = all("[data-hours]"), strip = $("day"), band = $("band");

/// Marks that were set without the page are in the logs alone.
function marksOf(logs) {
  return logs.flatMap((log) => log.marks.map((line) => {
    const [, date, hour, minute, second, words] = /^(\d+-\d+-\d+)T(\d+)-(\d+)-(\d+)Z (.*)$/.exec(line) || [];
    return words && { kind: "mark", name: words, begin: 1000 * Date.parse(`${date}T${hour}:${minute}:${second}Z`), problem: null };
  })).filter(Boolean);
}

let marks = [], looks = 0;

async function showDay() {
  if (document.hidden || robot.locked) return;
  try {
    const answer = await fetch("/api/v1/history");
    if (!answer.ok) return;
    const { since, now, happenings } = await answer.json();
    if (looks++ % kLogLooks === 0) {
      const logs = await fetch("/api/v1/logs");
      marks = logs.ok ? marksOf(await logs.json()) : [];
      if (logs.status === 404) looks = NaN;  // there are none
    }
    const own = happenings.filter((one) => one.kind === "mark");
    for (const mark of marks) if (!own.some((one) => one.name === mark.name && Math.abs(one.begin - mark.begin) < 5e6)) own.push({ ...mark, end: mark.begin });
    Object.assign(day, { since, now, list: happenings.filter((one) => one.kind !== "mark").concat(own).sort((a, b) => a.begin - b.begin) });
  } catch (error) { return; }
  const seen = (day.now - day.since) / kHour;  // [h]
  day.hours ? drawDay() : look(seen > 6 ? 24 : seen > 1 ? 6 : seen > 0.25 ? 1 : 0.25);
}

const isChosen = (one) => day.chosen && one.kind === day.chosen.kind && one.name === day.chosen.name && one.begin === day.chosen.begin;
const begins = () => day.now - day.hours * kHour;
const shown = () => day.list.filter((one) => one.end >= begins() && !(one.kind === "state" && one.name === "localised"));

function wordsOfHappening(one) {
  const about = one.kind === "state" ? t(one.name) : one.kind === "device" ? t("no", named("device", one.name)) : one.kind === "drive" ? t("drove", number(one.metres, 1)) : t("marked", one.name);
  const time = localTime(one.begin, { hour: "2-digit", minute: "2-digit", second: "2-digit" });
  return about + ", " + time + (one.end > one.begin + 1e6 ? ", " + duration((one.end - one.begin) / 1e6) : "");
}

function drawDay() {
  const ratio = ratioOf(), wide = band.width = Math.round(band.clientWidth * ratio), high = band.height = Math.round(band.clientHeight * ratio), lane = high / 3;
  const to = band.getContext("2d"), style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue("--" + name).trim();
  const x = (utime) => Math.max(0, (utime - begins()) / (day.hours * kHour) * wide);
  to.strokeStyle = colour("line");
  for (let i = 0; i < x(day.since); i += 7 * ratio) {  // nothing was seen
    to.beginPath();
    to.moveTo(i, 0);
    to.lineTo(i, high);
    to.stroke();
  }
  for (const one of day.list) {
    if (one.end < begins()) continue;
    const left = x(one.begin), width = Math.max(2 * ratio, x(one.end) - left), top = kLanes[one.kind] * lane;
    const height = (one.kind === "state" ? kStates[one.name] || 1 : one.kind === "drive" ? 0.3 : 0.8) * (lane - 3 * ratio);
    to.fillStyle = colour(kInks[one.kind] || kInks[one.name] || "warning");
    if (one.kind === "mark") {
      to.beginPath();
      to.moveTo(left, top + 2 * ratio);
      to.lineTo(left - 5 * ratio, top + lane - ratio);
      to.lineTo(left + 5 * ratio, top + lane - ratio);
      to.fill();
    } else if (kHollow.includes(one.name)) {
      to.lineWidth = 1.5 * ratio;
      to.strokeStyle = to.fillStyle;
      to.strokeRect(left, top + lane - height, width, height);
    } else to.fillRect(left, top + lane - height, width, height);
    if (isChosen(one)) {
      to.strokeStyle = colour("ink");
      to.lineWidth = 2 * ratio;
      to.strokeRect(left - 2 * ratio, top, width + 4 * ratio, lane);
    }
  }
  const from = new Date(Math.max(begins(), day.since) / 1000);
  $("day-from").textContent = localTime(begins(), { hour: "2-digit", minute: "2-digit" });
  $("day-note").textContent = day.now === 0 ? t("waiting") : day.since > begins() ? t("dayBegins", from.toLocaleString(language, { weekday: "short", hour: "2-digit", minute: "2-digit" })) : "";
  const list = shown(), at = list.findIndex(isChosen);
  strip.setAttribute("aria-valuemax", Math.max(0, list.length - 1));
  strip.setAttribute("aria-valuenow", Math.max(0, at));
  strip.setAttribute("aria-valuetext", at >= 0 ? wordsOfHappening(list[at]) : t("happenings", list.length));
}

function chooseHappening(one) {
  day.chosen = one || null;
  $("happened").replaceChildren(...(one ? [element("b", wordsOfHappening(one)), ...(one.problem ? wordsIn([one.problem]) : [])] : []));
  if (one && robot.pose && one.map === robot.pose.map) {
    setFollow(false);
    view.x = one.x, view.y = one.y, view.moved = true;
  } else if (one) $("happened").append(element("p", t("noPlace"), "advice"));
  drawDay();
  redraw();
}

function drawHappening(ratio) {
  const one = day.chosen;
  if (!one || !robot.pose || one.map !== robot.pose.map) return;
  const [x, y] = [px(one.x), py(one.y)];
  paint.beginPath();
  paint.moveTo(x, y);
  paint.arc(x, y - 22 * ratio, 10 * ratio, 0.75 * Math.PI, 2.25 * Math.PI);
  paint.closePath();
  paint.fillStyle = "#18212b";
  paint.strokeStyle = "#fff";
  paint.lineWidth = 2 * ratio;
  paint.fill();
  paint.stroke();
}

strip.onclick = (event) => {
  const box = band.getBoundingClientRect(), at = begins() + (event.clientX - box.left) / box.width * day.hours * kHour;
  const lane = Math.min(2, Math.max(0, Math.floor((event.clientY - box.top) / box.height * 3)));
  const off = (one) => Math.max(one.begin - at, at - one.end, 0) + (kLanes[one.kind] === lane ? 0 : 0.02 * day.hours * kHour);
  chooseHappening(shown().sort((a, b) => off(a) - off(b))[0]);
};
strip.onkeydown = (event) => {
  const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, Home: -1e9, End: 1e9 }[event.key], list = shown();
  if (!step || list.length === 0) return;
  event.preventDefault();
  const chosen = list.findIndex(isChosen), at = chosen < 0 && step < 0 ? list.length : chosen;
  chooseHappening(list[Math.min(list.length - 1, Math.max(0, at + step))]);
};
function look(hours) {
  day.hours = hours;
  for (const one of periods) one.setAttribute("aria-pressed", Number(one.dataset.hours) === hours);
  drawDay();
}
for (const one of periods) one.onclick = () => look(Number(one.dataset.hours));
new ResizeObserver(drawDay).observe(band);
dark.addEventListener("change", drawDay);

$("show-logs").onclick = () => withMore(() => openDialog($("logs"), showLogs));
$("show-maps").onclick = () => withMore(() => openDialog($("maps"), showMaps));
$("keep").onclick = async () => {
  if (!unlocked) return askForToken();
  const { ok, words } = await ask({ verb: "log_mark", text: t("keepWords") });
  $("happened").replaceChildren(element("p", words, ok ? "" : "bad"));
  showDay();
};
