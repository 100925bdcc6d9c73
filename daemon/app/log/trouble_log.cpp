// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/trouble_log.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

namespace slam {
namespace {

/// Words without their figures: "only 12 MB free" and "only 11 MB free" are one reason.
std::string withoutFigures(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0 || c == '.'; });
  return text;
}

std::string lengthOf(Duration time) {
  const long minutes = std::lround(toSeconds(time) / 60.0);
  return minutes < 120 ? std::to_string(minutes) + " min" : std::to_string(minutes / 60) + " h";
}

}  // namespace

bool TroubleLog::hasRoom(Cause& cause, std::size_t most, Timestamp now) const {
  while (!cause.lines.empty() && now - cause.lines.front() >= config_.window) cause.lines.pop_front();
  return cause.lines.size() < most;
}

bool TroubleLog::isDue(Cause& cause, const std::string& reason, Timestamp now) const {
  if (!hasRoom(cause, config_.most - config_.recoveries, now)) return false;
  const bool known = std::find(cause.reasons.begin(), cause.reasons.end(), reason) != cause.reasons.end();
  return !known || !cause.repeated || now - *cause.repeated >= cause.interval;
}

void TroubleLog::note(Cause& cause, const std::string& reason, Timestamp now) {
  const auto known = std::find(cause.reasons.begin(), cause.reasons.end(), reason);
  if (known == cause.reasons.end()) {
    if (cause.reasons.size() >= config_.reasons) cause.reasons.erase(cause.reasons.begin());
    cause.reasons.push_back(reason);
    cause.interval = std::max(cause.interval, config_.first);
  } else {
    cause.interval = std::min(2 * cause.interval, config_.longest);
  }
  cause.repeated = now;
  cause.said_wrong = true;
  cause.unsaid = 0;
  cause.lines.push_back(now);
}

std::optional<LogLine> TroubleLog::wrong(Cause& cause, const Trouble& trouble, Timestamp now) {
  if (!cause.wrong_since) {
    cause.wrong_since = now;
    ++cause.times;
  }
  cause.well_since.reset();
  if (trouble.text.empty()) return std::nullopt;
  cause.recovery = trouble.recovery;
  const std::string reason = withoutFigures(trouble.reason.empty() ? trouble.text : trouble.reason);
  const Duration lasted = now - *cause.wrong_since;
  const bool untrue =
      !cause.said_wrong && lasted >= config_.untrue && hasRoom(cause, config_.most - config_.recoveries, now);
  if (!untrue && !isDue(cause, reason, now)) return std::nullopt;
  std::string text = trouble.text;
  if (cause.times > 1) text += " (" + std::to_string(cause.times) + " times)";
  if (lasted >= config_.first) text += " (for " + lengthOf(lasted) + ")";
  note(cause, reason, now);
  return LogLine{trouble.error ? LogLine::kError : LogLine::kWarning, std::move(text)};
}

std::optional<LogLine> TroubleLog::well(Cause& cause, Timestamp now) {
  if (!cause.well_since) cause.well_since = now;
  const Duration lasted = now - *cause.well_since;
  if (lasted < config_.settled) return std::nullopt;
  cause.wrong_since.reset();
  if (!cause.said_wrong || !hasRoom(cause, config_.most, now)) return std::nullopt;
  cause.said_wrong = false;
  if (cause.recovery.empty()) return std::nullopt;
  cause.lines.push_back(now);
  return LogLine{LogLine::kInfo, cause.recovery};
}

std::vector<LogLine> TroubleLog::look(const std::vector<Trouble>& present, Timestamp now) {
  std::vector<LogLine> lines;
  const auto add = [&](std::optional<LogLine> line) {
    if (line) lines.push_back(std::move(*line));
  };
  for (const Trouble& trouble : present) {
    // What was never wrong has nothing that could not be over.
    if (!trouble.text.empty() || causes_.contains(trouble.cause)) add(wrong(causes_[trouble.cause], trouble, now));
  }
  for (auto at = causes_.begin(); at != causes_.end();) {
    const bool is_present =
        std::any_of(present.begin(), present.end(), [&](const Trouble& trouble) { return trouble.cause == at->first; });
    if (!is_present) add(well(at->second, now));
    const bool forgotten = at->second.well_since && now - *at->second.well_since >= config_.forgotten;
    at = forgotten ? causes_.erase(at) : std::next(at);
  }
  return lines;
}

bool TroubleLog::isOpen(const std::string& cause) const {
  const auto at = causes_.find(cause);
  return at != causes_.end() && at->second.said_wrong;
}

std::optional<LogLine> TroubleLog::happened(const std::string& name, const std::string& text, LogLine::Level level,
                                            Timestamp now) {
  Cause& cause = events_[name];
  if (cause.well_since && now - *cause.well_since >= config_.forgotten) cause = {};
  cause.well_since = now;  // the last time
  const std::string reason = withoutFigures(text);
  if (!isDue(cause, reason, now)) {
    ++cause.unsaid;
    return std::nullopt;
  }
  const bool known = std::find(cause.reasons.begin(), cause.reasons.end(), reason) != cause.reasons.end();
  const std::string further =
      known && cause.unsaid > 0 ? " (and " + std::to_string(cause.unsaid) + " times before)" : "";
  note(cause, reason, now);
  return LogLine{level, text + further};
}

void logLines(const std::vector<LogLine>& lines) {
  for (const LogLine& line : lines) logLine(line);
}

}  // namespace slam
