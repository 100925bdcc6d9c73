// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/trouble_log.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slam {
namespace {

/// "Only 12 MB free" and "only 11 MB free" are one reason.
bool isKnown(const std::vector<Problem>& reasons, const Problem& reason) {
  return std::any_of(reasons.begin(), reasons.end(), [&](const Problem& known) { return known.isSame(reason); });
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

bool TroubleLog::isDue(Cause& cause, const Problem& reason, Timestamp now) const {
  if (!hasRoom(cause, config_.most - config_.recoveries, now)) return false;
  return !isKnown(cause.reasons, reason) || !cause.repeated || now - *cause.repeated >= cause.interval;
}

void TroubleLog::note(Cause& cause, const Problem& reason, Timestamp now) {
  if (!isKnown(cause.reasons, reason)) {
    if (cause.reasons.size() >= config_.reasons) cause.reasons.erase(cause.reasons.begin());
    cause.reasons.push_back(reason);
    cause.interval = std::max(cause.interval, config_.first);
  } else {
    cause.interval = std::min(2 * cause.interval, config_.longest);
  }
  cause.repeated = now;
  cause.reported_wrong = true;
  cause.unreported = 0;
  cause.lines.push_back(now);
}

std::optional<LogLine> TroubleLog::wrong(Cause& cause, const Trouble& trouble, Timestamp now) {
  if (!cause.wrong_since) {
    cause.wrong_since = now;
    ++cause.times;
  }
  cause.well_since.reset();
  if (!trouble.problem) return std::nullopt;
  cause.recovery = trouble.recovery;
  const Problem& reason = trouble.problem;
  const Duration lasted = now - *cause.wrong_since;
  const bool untrue =
      !cause.reported_wrong && lasted >= config_.untrue && hasRoom(cause, config_.most - config_.recoveries, now);
  if (!untrue && !isDue(cause, reason, now)) return std::nullopt;
  std::string text = trouble.text();
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
  if (!cause.reported_wrong || !hasRoom(cause, config_.most, now)) return std::nullopt;
  cause.reported_wrong = false;
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
    if (trouble.problem || causes_.contains(trouble.cause())) add(wrong(causes_[trouble.cause()], trouble, now));
  }
  for (auto at = causes_.begin(); at != causes_.end();) {
    const bool is_present = std::any_of(present.begin(), present.end(),
                                        [&](const Trouble& trouble) { return trouble.cause() == at->first; });
    if (!is_present) add(well(at->second, now));
    const bool forgotten = at->second.well_since && now - *at->second.well_since >= config_.forgotten;
    at = forgotten ? causes_.erase(at) : std::next(at);
  }
  return lines;
}

bool TroubleLog::isOpen(const std::string& cause) const {
  const auto at = causes_.find(cause);
  return at != causes_.end() && at->second.reported_wrong;
}

std::optional<LogLine> TroubleLog::happened(const std::string& name, const Problem& reason, const std::string& text,
                                            LogLine::Level level, Timestamp now) {
  Cause& cause = events_[name];
  if (cause.well_since && now - *cause.well_since >= config_.forgotten) cause = {};
  cause.well_since = now;  // the last time
  if (!isDue(cause, reason, now)) {
    ++cause.unreported;
    return std::nullopt;
  }
  const bool known = isKnown(cause.reasons, reason);
  const std::string further =
      known && cause.unreported > 0 ? " (and " + std::to_string(cause.unreported) + " times before)" : "";
  note(cause, reason, now);
  return LogLine{level, text + further};
}

void logLines(const std::vector<LogLine>& lines) {
  for (const LogLine& line : lines) logLine(line);
}

}  // namespace slam
