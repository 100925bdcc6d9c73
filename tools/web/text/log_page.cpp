// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/text/log_page.hpp"

#include <cstdint>
#include <cstdio>

#include "tools/common/escaped.hpp"
#include "tools/web/request_guard.hpp"

namespace slam {
namespace {

std::string sizeText(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", 1e-6 * static_cast<double>(bytes));
  return text;
}

}  // namespace

std::string logPage(const std::vector<std::string>& parts, const std::vector<LogFolder::Entry>& entries) {
  std::string html =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>slamd: logs</title><link rel=\"stylesheet\" "
      "href=\"/page.css\"><main class=\"listing\"><h1>Logs</h1><p><a href=\"/\">Live map</a>";
  std::string at = "/logs/";
  if (!parts.empty()) html += " &middot; <a href=\"/logs/\">All runs</a>";
  for (const std::string& part : parts) at += part + "/";
  html += "</p><ul>";
  for (const LogFolder::Entry& entry : entries) {
    if (!logPathOf(at + entry.name)) continue;
    html += "<li><a href=\"" + at + escaped(entry.name) + (entry.is_folder ? "/" : "") + "\">" + escaped(entry.name) +
            "</a> " + (entry.is_folder ? "" : sizeText(entry.size)) + "</li>";
  }
  return html + (entries.empty() ? "</ul><p>Nothing is logged yet.</p></main></html>" : "</ul></main></html>");
}

}  // namespace slam
