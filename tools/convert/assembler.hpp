// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/recording.hpp"
#include "tools/convert/survey.hpp"

namespace slam {

/// Why a record is refused.
inline constexpr const char *kNoTime = "its stamp is not a time", *kDamage = "the compressed data is damaged here";

/// Where a sample is from.
struct Origin {
  std::string sensor = {};                     ///< as in SensorRows; empty: it has no rows of its own
  std::string where = {};                      ///< place of its record, for a refusal
  std::int64_t stamp = 0;                      ///< [us] of the measurement; not above 0: not a time
  std::int64_t received = 0;                   ///< [us] when it was recorded
  std::string frame = {};                      ///< as in SensorRows
  std::span<const std::uint8_t> message = {};  ///< as our log holds it: written as it is, unless the sample changes

  /// The same of another sensor, whose samples stand in the same record.
  Origin of(std::string other) const {
    return {.sensor = std::move(other), .where = where, .stamp = stamp, .received = received};
  }
};

/// What a reader knows of a scan beside its beams.
struct ScanFacts {
  std::span<const double> written = {};  ///< [m] ranges as they stand there, to find codes in; empty: it has none
  bool timed = false;                    ///< its beams have times
};

/// Makes a log of what a Reader yields, in two passes. The first surveys the samples, and writes none: which ranges are
/// codes of "no return", and whether beam times are those of a copy, is for all of them to decide.
class Assembler {
 public:
  bool surveying() const { return surveying_; }

  void scan(const Origin& origin, LaserScan& scan, const ScanFacts& facts = {});
  void wheels(const Origin& origin, const Pose2& pose, std::span<const double> angles = {},
              bool turn_rate_known = true);
  void imu(const Origin& origin, const Eigen::Vector3d& gyro, const Eigen::Vector3d& accel);
  /// The record is none that its format has. Counted in the second pass, as what follows.
  void refuse(const Origin& origin, const std::string& why);
  /// A record of a kind that is not read. @param most kinds that are counted
  void passOver(std::string_view kind, std::size_t most);

  /// The sensor's rows, made where there are none: the report has sensors in the order of their making.
  SensorRows& rows(const Origin& origin);
  const std::map<std::string, int, std::less<>>& passedOver() const { return passed_over_; }
  /// What was passed over are channels of messages.
  void noteChannels();

  Recording recording;
  RangeCensus census;
  std::vector<double> codes;  ///< [m] of the census, when the survey is done

 private:
  friend Recording assemble(class Reader&& reader, const std::filesystem::path& out);
  void endSurvey();
  template <typename Write>
  void use(const Origin& origin, const char* channel, int Recording::*count, const Write& write);

  bool surveying_ = true;
  BeamTimes beam_times_;
  std::optional<std::int64_t> copied_turn_;  // [us]
  std::map<std::string, int, std::less<>> passed_over_;
  LogOutput log_;
};

/// A recorded format: how its records are written, and what they mean.
class Reader {
 public:
  /// @param range_min, range_max [m] of its scans, unless they bring their own
  explicit Reader(std::filesystem::path in, float range_min = 0.02F, float range_max = 200.0F) : in_(std::move(in)) {
    scan_->range_min = range_min;
    scan_->range_max = range_max;
  }
  virtual ~Reader() = default;
  /// Hands over each record, from the first to the last; called twice.
  virtual void read(Assembler& to) = 0;
  /// What the survey decides, between the two.
  virtual void decide(Assembler&) {}
  /// Robot and notes at the end. @throws std::runtime_error where the recording holds nothing to use
  virtual void finish(Assembler&) {}

 protected:
  const std::filesystem::path in_;
  const std::unique_ptr<LaserScan> scan_ = std::make_unique<LaserScan>();  // the one that is being read: 64 KB
};

/// Reads twice and writes the log. @throws std::runtime_error when the input cannot be opened or used, or the output
/// cannot be written
Recording assemble(Reader&& reader, const std::filesystem::path& out);

/// Calls body(words, origin without sensor and times) for each line with words, and refuses damage.
void forEachLine(const std::filesystem::path& file, Assembler& to,
                 const std::function<void(const std::vector<std::string_view>&, Origin)>& body);

/// [m] of a beam; 0, no return, for what no lidar measures: not above 0, or 200 m and more
inline float returnedRange(double range) { return range > 0.0 && range < 200.0 ? static_cast<float>(range) : 0.0F; }

/// [us] from a scan's stamp to its last beam
std::int64_t spanOf(const LaserScan& scan);

/// The motion of a base whose wheels travelled so far. @param left, right [m] @param half_track [m]
inline Pose2 travelled(double left, double right, double half_track) {
  return exp({0.5 * (left + right), 0.0, (right - left) / (2.0 * half_track)});
}

}  // namespace slam
