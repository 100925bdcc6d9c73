// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/log/log.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// Something that is wrong now.
struct Trouble {
  std::string cause;        ///< what it is about, such as a device: one that fails in two ways in turn is one cause
  std::string text;         ///< what is wrong, what slamd does meanwhile, and the fix; empty: it is not over, no more
  std::string recovery;     ///< the line when it is over
  std::string reason = {};  ///< what tells it from others of its cause; empty: the text. Figures in it do not count
  bool error = false;
};

/// How often something is logged.
struct TroubleLogConfig {
  Duration settled = std::chrono::seconds(5);     ///< a cause that is well for so long is over
  Duration first = std::chrono::minutes(1);       ///< between two lines of a known reason; doubles ...
  Duration longest = std::chrono::minutes(60);    ///< ... up to this
  Duration untrue = std::chrono::minutes(10);     ///< the last line of a cause does not name the wrong state for longer
  Duration forgotten = std::chrono::minutes(60);  ///< a cause that is well for so long begins anew
  Duration window = std::chrono::minutes(60);     ///< within which a cause has ...
  std::size_t most = 20;                          ///< [1] ... so many lines, and of them ...
  std::size_t recoveries = 5;                     ///< [1] ... these are kept for recoveries
  std::size_t reasons = 32;                       ///< [1] of a cause that are remembered
};

/// Decides by value which line is written now about what may go wrong again and again: each new reason at once,
/// repetitions ever more seldom, recovery once. Time is data, so that a day is played in no time.
class TroubleLog {
 public:
  explicit TroubleLog(const TroubleLogConfig& config = {}) : config_(config) {}

  /// All that is wrong now, at most one trouble of each cause. Every other cause is well. @return what is to be written
  std::vector<LogLine> look(const std::vector<Trouble>& present, Timestamp now);
  /// Something happened that is over at once, such as a late thread. @return the line, if it is to be written
  std::optional<LogLine> happened(const std::string& cause, const std::string& text, LogLine::Level level,
                                  Timestamp now);

  /// Whether the last line about a cause says that it is wrong.
  bool isOpen(const std::string& cause) const;

 private:
  struct Cause {
    std::vector<std::string> reasons;  // that have a line
    std::string recovery;
    std::optional<Timestamp> wrong_since, well_since;  // without the other between them for long
    std::optional<Timestamp> repeated;                 // the last line that is no recovery
    Duration interval{0};                              // to the next one of a known reason
    bool said_wrong = false;                           // by the last line
    int times = 0;                                     // it went wrong since it was forgotten
    int unsaid = 0;                                    // of them since the last line
    std::deque<Timestamp> lines;                       // within the window
  };

  std::optional<LogLine> wrong(Cause& cause, const Trouble& trouble, Timestamp now);
  std::optional<LogLine> well(Cause& cause, Timestamp now);
  bool isDue(Cause& cause, const std::string& reason, Timestamp now) const;
  bool hasRoom(Cause& cause, std::size_t most, Timestamp now) const;
  void note(Cause& cause, const std::string& reason, Timestamp now);

  const TroubleLogConfig config_;
  std::map<std::string, Cause> causes_, events_;
};

/// Writes lines of a TroubleLog.
void logLines(const std::vector<LogLine>& lines);

}  // namespace slam
