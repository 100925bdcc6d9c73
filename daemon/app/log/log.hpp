// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>

namespace slam {

/// A line of the log.
struct LogLine {
  enum Level : std::uint8_t { kInfo, kWarning, kError } level = kInfo;
  std::string text;
};

/// One line on stderr; with the priority prefix that journald reads when it listens. Never from real-time threads. What
/// may come again and again goes through a TroubleLog.
void logLine(const LogLine& line);
inline void logInfo(const std::string& text) { logLine({LogLine::kInfo, text}); }
inline void logWarning(const std::string& text) { logLine({LogLine::kWarning, text}); }
inline void logError(const std::string& text) { logLine({LogLine::kError, text}); }

}  // namespace slam
