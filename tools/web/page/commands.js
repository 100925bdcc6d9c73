// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- commands --------------------------------------------------------------------------------------

function showResult(words, bad) {
  $("result").textContent = words;
  $("result").classList.toggle("bad", Boolean(bad));
}

async function unlock(given) {
  try {
    const answer = await fetch("/api/v1/allowed", { headers: { Authorization: "Bearer " + given } });
    if (!answer.ok) {
      sessionStorage.removeItem("slamd-token");
      showUnlocked(false);
      showResult(await messageOf(answer), true);
      return false;
    }
  } catch (error) {
    showResult(t("noWeb"), true);
    return false;
  }
  token = given;
  sessionStorage.setItem("slamd-token", given);
  showResult("");
  showUnlocked(true);
  if (robot.locked) connect();
  return true;
}

function showUnlocked(is) {
  unlocked = is;
  $("login").hidden = is;
  $("actions").hidden = !is;
  showStop();
}

/// Has slamd do something. @return whether it did, the status of HTTP, and what it answers
async function ask(request) {
  try {
    const answer = await fetch("/api/v1/command", { method: "POST", body: JSON.stringify(request), headers: authorized() });
    return { ok: answer.ok, status: answer.status, words: await messageOf(answer) };
  } catch (error) { return { ok: false, words: t("noWeb") }; }
}

async function command(request) {
  showResult("\u2026");
  for (const button of $("actions").querySelectorAll("button")) button.disabled = true;
  const { ok, words } = await ask(request);
  showResult(words, !ok);
  for (const button of $("actions").querySelectorAll("button")) button.disabled = false;
}

function askForToken() {
  $("token").scrollIntoView({ block: "center" });
  $("token").focus();
}

/// The next drag draws a pose.
function arm(on) {
  place.armed = on;
  place.from = place.to = null;
  canvas.classList.toggle("placing", on);
  $("set-pose").setAttribute("aria-pressed", on);
  $("hint").hidden = !on;
  $("hint").textContent = t("hint");
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
$("language").onchange = () => choose($("language").value);

// ---- start --------------------------------------------------------------------------------------------------------

translate();
showStop();
takeColours();
new ResizeObserver(resize).observe(canvas);
resize();
setInterval(showState, 500);
connect();
showDay();
setInterval(showDay, kDayPeriod);
if (token) unlock(token);
if ("serviceWorker" in navigator) navigator.serviceWorker.register("/worker.js").catch(() => {});  // for a start without the robot
