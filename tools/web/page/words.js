// SPDX-License-Identifier: BSD-3-Clause
"use strict";

const all = (selector) => document.querySelectorAll(selector);
const $ = (id) => document.getElementById(id);

function element(tag, text = "", className) {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

function showFacts(list, facts) {
  list.replaceChildren(...facts.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
}

// ---- texts: one table for each language ---------------------------------------------------------------------------

const kTexts = {
  en: {
    map: "Live map. Arrow keys move it, plus and minus zoom, 0 shows all of it, F follows the robot.",
    layers: "Layer of the map", both: "Both", lidar: "Lidar", depth: "Depth", zoomIn: "Zoom in", zoomOut: "Zoom out",
    fit: "Whole map", follow: "Follow the robot", scan: "scan", obstacle: "depth", trail: "trail", closure: "loop closure", state: "State of the robot",
    language: "Language", pose: "Pose", devices: "Devices", problems: "Further problems", whichFloor: "Which floor?", commands: "Commands", token: "Token",
    unlock: "Unlock", save: "Save the map", setPose: "Set the pose", localise: "Localise only", localiseTitle: "The map stays as it is",
    slam: "Extend the map", slamTitle: "The map grows again", what: "What happened?", mark: "Mark the log", mapCard: "Map", logs: "Logs",
    developers: "For developers", latencies: "Latencies [ms]", stage: "Stage", computer: "Computer, disk and log", stop: "Stop",
    stopLocked: "Unlock to stop", stick: "Hold to drive: drag it, or hold arrow keys. Letting go stops.", drive: "hold to drive",
    connecting: "Connecting", waiting: "Waiting for the robot’s first pose", locked: "Locked: the page needs the token",
    noWeb: "No answer from slam-web",
    noWebLong: "No answer from slam-web for {0} s; the page keeps trying. Is the robot on, and in this network?",
    noSlamd: "slamd is silent", noSlamdLong: "slamd is silent since {0} s; the page shows its last state. On the robot: systemctl status slamd",
    localised: "Localised", degraded: "Degraded", lost: "Lost", initialising: "Initialising",
    to: "{0} to {1}", since: "{0} since {1}", no: "No {0}", it: "the device", and: "{0} · {1}",
    within: "The robot is somewhere within {0} of its mark", heading: "Heading", sigma: "Sigma", speed: "Speed", quality: "Scan on the map",
    keyframes: "Keyframes", tiles: "Tiles", resolution: "Resolution", noData: "no data yet", old: "{0} old",
    rates: "{0}; {1} Hz expected; {2} refused", up: "Up", cpu: "CPU", ofACore: "{0} % of a core", memory: "Memory", disk: "Disk free",
    noDisk: "nothing is written", closures: "Loop closures", lostFound: "Lost, found again", log: "Log", log0: "stopped",
    log1: "is being written", log2: "cannot be written", battery: "Battery",
    hint: "Press where the robot stands and drag to where it looks; or arrow keys, Shift with them to turn, Enter",
    good: "good", ABSENT: "absent", OPENING: "opening", STREAMING: "sends", STALE: "silent", FAULT: "fault",
    stopped: "Stopped", unconfirmed: "No answer to Stop. slamd stops by itself within half a second",
    linkLost: "The link was lost: the robot stops", notDriven: "The robot stops: {0}",
    devicelidar: "lidar", devicebase: "base", deviceimu: "gyro", devicedepth: "depth camera",
    devicesensors: "sensors", devicethreads: "computer", devicememory: "memory", devicemap: "map", devicerecord: "record",
    editMap: "Edit the map", maps: "Maps", tools: "What to draw", name: "Name", undo: "Undo", redo: "Redo", drop: "Discard", apply: "Apply", force: "Erase all the same", leave: "Done",
    toolerase: "Erase", toolbrush: "Brush", toolzone: "No-go", toolwall: "Wall", toolfree: "Keep free", toolroom: "Room", toolplace: "Place", toolremove: "Remove",
    hintoutline: "Circle it with one finger, or tap its corners. Two fingers move and zoom",
    hintbrush: "Wipe with one finger what is to go", hintwall: "Drag from end to end, or tap each corner of the wall",
    hintremove: "Tap what is to go", hintplace: "Press where the place is, drag where the robot looks, and name it", sending: "Sent; waits until the map is stored",
    ofKeyframes: "{0} keyframes", present: "open", straighten: "Straighten", load: "Load", rename: "Rename", delete: "Delete", close: "Close",
    day: "The last day", period: "Period", dayNow: "now", dayLanes: "Top: state, the higher the worse. Middle: devices away. Bottom: drives, marks (triangles)",
    dayBegins: "slam-web watches since {0}; it has not seen what was before", happenings: "{0} happenings", silent: "slamd was silent", drove: "Drove {0} m", marked: "Mark: {0}",
    noPlace: "Its place is not of this map", keep: "Keep the 10 minutes before", keepTitle: "Marks the log: it is deleted last", keepWords: "keep what was before",
    download: "Download", allLogs: "All of them as one zip, {0} MB", time: "Time", lasts: "Duration", size: "Size", marks: "Marks", file: "File",
    linelost: "waits to recognise something; drive slowly where it has been",
    linenot_found_yet: "waits to be found in its map; drive slowly on",
  },
  de: {
    map: "Karte. Pfeiltasten verschieben sie, Plus und Minus zoomen, 0 zeigt alles, F folgt dem Roboter.",
    layers: "Ebene der Karte", both: "Beide", lidar: "Lidar", depth: "Tiefe", zoomIn: "Vergrößern", zoomOut: "Verkleinern",
    fit: "Ganze Karte", follow: "Dem Roboter folgen", scan: "Scan", obstacle: "Tiefe", trail: "Weg", closure: "Schleife", state: "Zustand des Roboters",
    language: "Sprache", pose: "Pose", devices: "Geräte", problems: "Weitere Störungen", whichFloor: "Welche Etage?", commands: "Befehle", token: "Token",
    unlock: "Entsperren", save: "Karte speichern", setPose: "Pose setzen", localise: "Nur lokalisieren", localiseTitle: "Die Karte bleibt, wie sie ist",
    slam: "Karte erweitern", slamTitle: "Die Karte wächst wieder", what: "Was ist passiert?", mark: "Log markieren", mapCard: "Karte", logs: "Logs",
    developers: "Für Entwickler", latencies: "Latenzen [ms]", stage: "Stufe", computer: "Rechner, Platte und Log", stop: "Stopp",
    stopLocked: "Entsperren für Stopp", stick: "Zum Fahren halten: ziehen, oder Pfeiltasten halten. Loslassen hält an.", drive: "zum Fahren halten",
    connecting: "Verbinde", waiting: "Wartet auf die erste Pose des Roboters", locked: "Gesperrt: die Seite braucht das Token",
    noWeb: "Keine Antwort von slam-web",
    noWebLong: "Seit {0} s keine Antwort von slam-web; die Seite versucht es weiter. Ist der Roboter an und in diesem Netz?",
    noSlamd: "slamd schweigt", noSlamdLong: "slamd schweigt seit {0} s; die Seite zeigt den letzten Stand. Auf dem Roboter: systemctl status slamd",
    localised: "Lokalisiert", degraded: "Unsicher", lost: "Verloren", initialising: "Startet",
    to: "{0} auf {1}", since: "{0} seit {1}", no: "{0} fehlt", it: "das Gerät", and: "{0} · {1}",
    within: "Der Roboter ist irgendwo im Umkreis von {0} um sein Zeichen", heading: "Richtung", sigma: "Sigma", speed: "Tempo", quality: "Scan auf der Karte",
    keyframes: "Keyframes", tiles: "Kacheln", resolution: "Auflösung", noData: "noch keine Daten", old: "{0} alt",
    rates: "{0}; {1} Hz erwartet; {2} abgelehnt", up: "Läuft seit", cpu: "CPU", ofACore: "{0} % eines Kerns", memory: "Speicher", disk: "Platte frei",
    noDisk: "nichts wird geschrieben", closures: "Schleifen", lostFound: "Verloren, gefunden", log: "Log", log0: "angehalten",
    log1: "wird geschrieben", log2: "nicht schreibbar", battery: "Akku",
    hint: "Drücken, wo der Roboter steht, und ziehen, wohin er blickt; oder Pfeiltasten, mit Umschalt zum Drehen, Eingabe",
    good: "gut", ABSENT: "fehlt", OPENING: "wird geöffnet", STREAMING: "sendet", STALE: "schweigt", FAULT: "gestört",
    stopped: "Angehalten", unconfirmed: "Keine Antwort auf Stopp. slamd hält in einer halben Sekunde selbst an",
    linkLost: "Die Verbindung ist weg: der Roboter hält an", notDriven: "Der Roboter hält an: loslassen und neu drücken",
    devicelidar: "Lidar", devicebase: "Antrieb", deviceimu: "Gyro", devicedepth: "Tiefenkamera",
    devicesensors: "Sensoren", devicethreads: "Rechner", devicememory: "Speicher", devicemap: "Karte", devicerecord: "Aufzeichnung",
    editMap: "Karte bearbeiten", maps: "Karten", tools: "Was gezeichnet wird", name: "Name", undo: "Rückgängig", redo: "Wiederholen", drop: "Verwerfen", apply: "Anwenden", force: "Trotzdem löschen", leave: "Fertig",
    toolerase: "Radieren", toolbrush: "Pinsel", toolzone: "Sperrzone", toolwall: "Wand", toolfree: "Freihalten", toolroom: "Raum", toolplace: "Ort", toolremove: "Entfernen",
    hintoutline: "Mit einem Finger umkreisen oder Ecken antippen. Zwei Finger schieben und zoomen",
    hintbrush: "Mit einem Finger wischen, was weg soll", hintwall: "Von Ende zu Ende ziehen oder jede Ecke der Wand antippen",
    hintremove: "Antippen, was gezeichnet wurde", hintplace: "Drücken, wo der Ort ist, ziehen, wohin der Roboter blickt, und benennen", sending: "Gesendet; wartet, bis die Karte gespeichert ist",
    ofKeyframes: "{0} Keyframes", present: "geöffnet", straighten: "Ausrichten", load: "Laden", rename: "Umbenennen", delete: "Löschen", close: "Schließen",
    day: "Der letzte Tag", period: "Zeitraum", dayNow: "jetzt", dayLanes: "Oben: Zustand, je höher, desto schlechter. Mitte: Geräte weg. Unten: Fahrten, Marken (Dreiecke)",
    dayBegins: "slam-web sieht seit {0} zu; was vorher war, fehlt", happenings: "{0} Ereignisse", silent: "slamd schwieg", drove: "{0} m gefahren", marked: "Marke: {0}",
    noPlace: "Der Ort ist nicht auf dieser Karte", keep: "Letzte 10 Minuten behalten", keepTitle: "Markiert das Log: es wird zuletzt gelöscht", keepWords: "behalten, was vorher war",
    download: "Laden", allLogs: "Alle als ein Zip, {0} MB", time: "Zeit", lasts: "Dauer", size: "Größe", marks: "Marken", file: "Datei",
    linelost: "sucht Bekanntes; langsam fahren, wo er schon war",
    linenot_found_yet: "sucht sich in seiner Karte; langsam weiterfahren",
  },
};

let language = localStorage.getItem("slamd-language") || (navigator.language.startsWith("de") ? "de" : "en");
if (!(language in kTexts)) language = "en";

const t = (key, ...values) => kTexts[language][key].replace(/\{(\d)\}/g, (_, i) => values[i]);
/// A name that has a text of its own, or itself.
const named = (kind, name) => kTexts[language][kind + name] || name;
const number = (value, digits) => fixed(value, digits).replace(".", language === "de" ? "," : ".");
const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1");  // no -0.00

const localTime = (utime, style) => new Date(utime / 1000).toLocaleString(language, style || { dateStyle: "medium", timeStyle: "short" });

const kMore = ["/maps.js", "/logs.js", "/brush.js", "/tools.js"];
const loading = new Map();

/// Loads a script, once. Scripts run in the order of their loading.
function load(path) {
  if (!loading.has(path)) loading.set(path, new Promise((done, fail) => {
    const script = document.createElement("script");
    script.src = path;
    script.async = false;
    script.onload = done;
    script.onerror = () => { loading.delete(path); fail(new Error(path)); };
    document.head.append(script);
  }));
  return loading.get(path);
}

/// Does what only some open: its scripts come when it is first asked for.
async function withMore(act) {
  try { await Promise.all(kMore.map(load)); } catch (error) { return showNote(t("noWeb")); }
  act();
}

/// Puts the texts of the language where index.html names them.
function translate() {
  document.documentElement.lang = language;
  for (const e of all("[data-text]")) e.textContent = t(e.dataset.text);
  for (const e of all("[data-label]")) e.setAttribute("aria-label", t(e.dataset.label));
  for (const e of all("[data-title]")) e.title = t(e.dataset.title);
  for (const e of all("[data-placeholder]")) e.placeholder = t(e.dataset.placeholder);
  document.getElementById("language").value = language;
  if (language === "de") load("/german.js").then(showAll, () => {});  // large, and only some need it
}

function choose(chosen) {
  language = chosen;
  localStorage.setItem("slamd-language", chosen);
  translate();
  showAll();
}

// ---- problems -----------------------------------------------------------------------------------------------------

/// A place holder's number, as problem.cpp has it.
function placed(format, value) {
  const digits = Number(format[2]);
  return format[1] === "x" ? Math.round(value).toString(16).padStart(digits, "0")
    : number(value, format[1] === "." ? digits : format[1] === "s" && value < 10 ? 1 : 0);
}

/// Cause, fix and what slamd does meanwhile: German by the problem's id, else as slamd words them.
function wordsOf(problem) {
  const row = language === "de" && window.kGerman ? window.kGerman[problem.id] : null;
  if (!row) return { cause: problem.cause, fix: problem.fix, meanwhile: problem.meanwhile };
  const filled = (words) => (words || "").replace(/\{(#?)(\d)([^}]*)\}/g, (_, hash, i, rest) =>
    hash ? placed(i + rest, problem.numbers[i]) : problem.texts[i] || "");
  return { cause: filled(row[0]), fix: filled(row[1]), meanwhile: filled(row[2]) };
}

/// An answer's rows as one sentence, as answer.cpp joins them. @param message the same as slamd words it
function sentenceOf(message, parts) {
  if (language === "en" || parts.length === 0) return message;
  return parts.map((part) => {
    const { cause, meanwhile, fix } = wordsOf(part);
    return [cause, meanwhile, fix].filter(Boolean).join("; ");
  }).reduce((all, one) => all + (all.endsWith(":") ? " " : "; ") + one);
}

/// The cause without what identifies a device: that is for the device's details.
function shortCause(problem) {
  let cause = wordsOf(problem).cause;
  for (const text of problem.texts)
    if (/:\/\/|^\/dev\/|@/.test(text)) cause = cause.replaceAll(" " + text, "").replaceAll(text, t("it"));
  return cause;
}

/// As much of a text as fits, ended at a clause where there is one.
function shortened(text, most) {
  if (text.length <= most) return text;
  const part = text.slice(0, most - 1), clause = Math.max(...["; ", ": ", ", ", " ("].map((end) => part.lastIndexOf(end)));
  return clause > most / 2 ? part.slice(0, clause) : part.slice(0, Math.max(part.lastIndexOf(" "), most / 2)) + "…";
}
