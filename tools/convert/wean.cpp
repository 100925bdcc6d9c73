// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <numbers>

#include "tools/convert/formats.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr std::size_t kBeams = 180;
constexpr double kMetresPerUnit = 0.01;
constexpr double kNoReturn = 81.0;        // [m] the SICK's largest reading
constexpr std::int64_t kEpoch = 1000000;  // [us] the recording's clock begins at 0, which is no stamp

}  // namespace

ConvertReport convertWean(const std::filesystem::path& in, const std::filesystem::path& out) {
  TextFile file(in);
  ConvertReport report;
  LogOutput log;
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.05F;
  scan->range_max = 80.0F;
  std::int64_t arrival = 0;
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty()) continue;
    const bool laser = words[0] == "L", odometry = words[0] == "O";
    const std::size_t expected = laser ? 7 + kBeams + 1 : 5;
    const auto numbers = (laser || odometry) && words.size() == expected ? toNumbers(words, 1) : std::nullopt;
    const auto seconds = numbers ? toMicroseconds(words.back()) : std::nullopt;
    if (!seconds || *seconds < 0) {
      report.reject(in.filename().string() + ":" + std::to_string(file.lineNumber()),
                    "not an O line of 5 or an L line of 188 words");
      continue;
    }
    // An L line's odometry was interpolated to the moment of the scan, which lies before the line's stamp; an O line's
    // is of its stamp. Mixed they would go to and fro, so the scans' own are used.
    if (!laser) continue;
    const std::int64_t utime = *seconds + kEpoch;
    arrival = std::max(arrival, utime);
    const WheelSample wheels{fromMicroseconds(utime),
                             {(*numbers)[0] * kMetresPerUnit, (*numbers)[1] * kMetresPerUnit, (*numbers)[2]}};
    log.add(arrival, wheels, utime);
    ++report.wheels;
    scan->stamp = fromMicroseconds(utime);
    scan->size = 0;
    for (std::size_t i = 0; i < kBeams; ++i) {
      const double range = (*numbers)[6 + i] * kMetresPerUnit;
      const double bearing = -std::numbers::pi / 2.0 + std::numbers::pi / kBeams * static_cast<double>(i);
      scan->push(
          {.range = range >= kNoReturn ? 0.0F : static_cast<float>(range), .bearing = static_cast<float>(bearing)});
    }
    log.add(arrival, *scan, utime);
    ++report.scans;
  }
  reportDamage(file, in, report);
  log.write(out);
  return report;
}

}  // namespace slam
