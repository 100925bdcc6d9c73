// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- logs ---------------------------------------------------------------------------------------------------------

async function showLogs() {
  const logs = await listOf("/api/v1/logs", $("logs-result"));
  if (!logs) return;
  const rows = logs.map((log, i) => {
    const row = element("tr"), next = logs[i + 1], link = element("a", t("download"));
    const end = next && next.run === log.run && next.utime ? next.utime : log.modified;
    link.href = `/logs/${log.run}/${log.file}`;
    link.setAttribute("aria-label", t("download") + " " + log.file);
    link.download = "";
    const cells = [log.utime ? localTime(log.utime) : "\u2013", log.utime ? duration(Math.max(0, end - log.utime) / 1e6) : "\u2013", number(log.bytes / 1e6, 1) + " MB",
      log.marks.map((mark) => mark.replace(/^\S+Z /, "")).join("; ")].map((text) => element("td", text));
    cells.push(element("td", ""));
    cells[4].append(link);
    row.append(...cells);
    return row;
  });
  const head = element("tr");
  for (const name of ["time", "lasts", "size", "marks", "file"]) head.append(element("th", t(name)));
  for (const cell of head.children) cell.scope = "col";
  $("log-table").replaceChildren(head, ...rows.reverse());
  $("all-logs").hidden = logs.length === 0;
  $("all-logs").textContent = t("allLogs", number(logs.reduce((sum, log) => sum + log.bytes, 0) / 1e6, 1));
}
