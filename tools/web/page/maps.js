// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- stored maps --------------------------------------------------------------------------------------------------

/// A button that does something. @param what a text of the page
function button(what, act) {
  const made = element("button", t(what));
  made.type = "button";
  made.onclick = act;
  return made;
}

/// The answer to a request for a list, or null, with the reason in the dialog's last line.
async function listOf(path, line) {
  try {
    const answer = await fetch(path);
    if (answer.ok) return await answer.json();
    line.textContent = await answer.text();
  } catch (error) { line.textContent = t("noWeb"); }
  return null;
}

/// Has slamd do it, and shows what it answers, with a way back where there is one.
async function manage(request, undo) {
  const line = $("maps-result");
  line.textContent = "\u2026";
  const { ok, words } = await ask(request);
  if (ok && request.verb === "load") loaded = request.name;
  await showMaps();
  line.className = ok ? "" : "bad";
  line.replaceChildren(words + " ", ...(ok && undo ? [undo] : []));
}

let loaded = null;  // a map that slamd has opened, and not written yet
const isPresent = (map) => loaded ? map.name === loaded : map.continued_at_start;

/// The row asks for another name.
function rename(map, row) {
  const form = element("form"), name = element("input"), done = element("button", "OK");
  name.value = map.name;
  name.required = true;
  name.setAttribute("aria-label", t("name"));
  form.append(name, done);
  form.onsubmit = (event) => {
    event.preventDefault();
    manage({ verb: "rename", name: map.name, to: name.value });
  };
  row.replaceChildren(form);
  name.select();
}

function mapRow(map) {
  const row = element("li"), picture = element("img"), facts = element("div"), acts = element("div");
  picture.loading = "lazy";
  picture.src = `/api/v1/maps/${map.name}.png?v=${map.generation}-${map.utime}`;
  picture.alt = "";
  picture.onerror = () => picture.removeAttribute("src");
  const present = isPresent(map);
  facts.append(element("b", map.name), element("p", [map.utime > 0 && localTime(map.utime), t("ofKeyframes", map.keyframes), present && t("present")].filter(Boolean).join(" · "), "advice"));
  if (map.problem) facts.append(element("p", map.state + ": " + map.problem, "reason"));
  acts.className = "acts";
  if (present) acts.append(button("straighten", () => manage({ verb: "map_straighten" })));
  else {
    acts.append(button("load", () => manage({ verb: "load", name: map.name })), button("rename", () => rename(map, acts)),
      button("delete", () => manage({ verb: "delete", name: map.name }, button("undo", () => manage({ verb: "restore" })))));
  }
  for (const one of acts.children) one.setAttribute("aria-label", one.textContent + ": " + map.name);
  facts.append(acts);
  row.append(picture, facts);
  return row;
}

async function showMaps() {
  const maps = await listOf("/api/v1/maps", $("maps-result"));
  if (!maps) return;
  if (maps.some((map) => map.continued_at_start && map.name === loaded)) loaded = null;
  $("map-list").replaceChildren(...maps.sort((a, b) => isPresent(b) - isPresent(a) || b.utime - a.utime).map(mapRow));
}

function openDialog(dialog, show) {
  if (!dialog.open) dialog.showModal();
  dialog.querySelector("[role=status]").textContent = "";
  show();
}

for (const dialog of all("dialog")) {
  dialog.querySelector(".close").onclick = () => dialog.close();
  dialog.onclick = (event) => { if (event.target === dialog) dialog.close(); };  // beside it
}
