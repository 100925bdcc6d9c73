// SPDX-License-Identifier: BSD-3-Clause
// The input is the beginning of a CARMEN log that a good line follows.
#include <algorithm>
#include <stdexcept>
#include <string>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/read_log.hpp"
#include "tools/convert/formats.hpp"

namespace slam {
namespace {

constexpr char kGoodLine[] = "\nFLASER 3 1.25 2.5 3.75 0 0 0 0.5 0.25 0.125 12.5 host 1\n";
// [us] of the good line: its own, or its logger's where the stamps of the other lines serve as little; a clock that
// begins before 1 s is 1 s later.
constexpr std::int64_t kGoodStamps[] = {12'500'000, 1'000'000, 2'000'000};

/// The good lines of what was written, of which all is what a sensor may say. Which of their ranges are codes is for
/// all lines to decide.
int goodLines(const std::filesystem::path& file) {
  int good = 0;
  EventLogReader reader(file);
  for (LogEvent event; reader.next(event);) {
    if (event.channel != channel::kScan) continue;
    const auto scan = decodeChecked<scan_t>(event.data);
    for (const float range : scan->ranges) FUZZ_CHECK(range <= 81.0F);
    good += scan->ranges.size() == 3 && std::ranges::count(kGoodStamps, scan->utime) == 1 ? 1 : 0;
  }
  return good;
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static const fuzz::MemoryFile in, log, text;
  const bool compressed = size >= 2 && data[0] == 0x1F && data[1] == 0x8B;
  std::string content(reinterpret_cast<const char*>(data), size);
  content += kGoodLine;
  in.write(content);
  log.write("");
  try {
    const Recording report = convertCarmen(in.path(), log.path());
    fuzz::checkConverted(report, log.path());
    FUZZ_CHECK(compressed || goodLines(log.path()) >= 1);
    if (size % 8 != 0) return 0;  // what follows costs three times as much as all before
    // There and back: every scan comes again.
    text.write("");
    const Recording back = convertToCarmen(log.path(), text.path());
    FUZZ_CHECK(back.scans == report.scans && back.wheels == report.wheels && back.rejected == 0);
    const Recording again = convertCarmen(text.path(), log.path());
    FUZZ_CHECK(again.scans == report.scans && again.rejected == 0);
  } catch (const std::runtime_error& error) {
    const bool asks_for_a_period = std::string(error.what()).find("--period") != std::string::npos;
    FUZZ_CHECK(compressed || asks_for_a_period);
  }
  return 0;
}
