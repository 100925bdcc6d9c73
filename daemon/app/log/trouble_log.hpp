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
#include "problems/problem.hpp"

namespace slam {

/// Something that is wrong now.
struct Trouble {
  std::string device;          ///< what it is about: one that fails in two ways in turn is one cause
  Problem problem = {};        ///< none: it is not over, no more
  std::string begin = {};      ///< that the line begins with: the device, and its state
  std::string since = {};      ///< words before the cause, such as how long that has been so
  std::string meanwhile = {};  ///< what slamd does, where the table has nothing
  std::string recovery = {};   ///< the line when it is over
  bool error = false;          ///< of the line
  bool fault = false;          ///< slamctl doctor fails for it
  bool besides = false;        ///< a cause of its own, beside the others of the device

  std::string cause() const { return besides ? device + " " + problem.id() : device; }
  std::string text() const { return begin + since + problem.words(meanwhile); }
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
  /// @param reason distinguishes it from others of its cause; none: it is all that happens of it
  std::optional<LogLine> happened(const std::string& cause, const Problem& reason, const std::string& text,
                                  LogLine::Level level, Timestamp now);

  /// Whether the last line about a cause reports that it is wrong.
  bool isOpen(const std::string& cause) const;

 private:
  struct Cause {
    std::vector<Problem> reasons;  // that have a line
    std::string recovery;
    std::optional<Timestamp> wrong_since, well_since;  // without the other between them for long
    std::optional<Timestamp> repeated;                 // the last line that is no recovery
    Duration interval{0};                              // to the next one of a known reason
    bool reported_wrong = false;                       // by the last line
    int times = 0;                                     // it went wrong since it was forgotten
    int unreported = 0;                                // of them since the last line
    std::deque<Timestamp> lines;                       // within the window
  };

  std::optional<LogLine> wrong(Cause& cause, const Trouble& trouble, Timestamp now);
  std::optional<LogLine> well(Cause& cause, Timestamp now);
  bool isDue(Cause& cause, const Problem& reason, Timestamp now) const;
  bool hasRoom(Cause& cause, std::size_t most, Timestamp now) const;
  void note(Cause& cause, const Problem& reason, Timestamp now);

  const TroubleLogConfig config_;
  std::map<std::string, Cause> causes_, events_;
};

/// Writes lines of a TroubleLog.
void logLines(const std::vector<LogLine>& lines);

}  // namespace slam
