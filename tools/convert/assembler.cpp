// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/assembler.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bus/channels.hpp"
#include "core/samples.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {

SensorRows& Assembler::rows(const Origin& origin) {
  SensorRows& rows = recording.sensor(origin.sensor);
  if (rows.frame.empty()) rows.frame = origin.frame;
  return rows;
}

/// Writes the message that was recorded, or else the sample, and counts it.
template <typename Write>
void Assembler::use(const Origin& origin, const char* channel, int Recording::*count, const Write& write) {
  if (origin.stamp <= 0) return refuse(origin, kNoTime);
  if (origin.message.empty()) write();
  if (!origin.message.empty()) log_.add(origin.received, channel, origin.message);
  if (origin.sensor.empty()) return void(++(recording.*count));
  recording.use(rows(origin), count, origin.stamp);
}

void Assembler::scan(const Origin& origin, LaserScan& scan, const ScanFacts& facts) {
  if (surveying_) {
    for (std::size_t i = 0; i < facts.written.size(); ++i) census.add(i, facts.written.size(), facts.written[i]);
    if (facts.timed) beam_times_.add(origin.stamp, origin.stamp + spanOf(scan));
    return;
  }
  Origin from = origin;
  const std::span<Beam> beams(scan.storage.data(), static_cast<std::size_t>(scan.size));
  if (facts.timed && copied_turn_) {
    from.message = {};
    from.stamp -= *copied_turn_;
    for (Beam& beam : beams) beam.time_offset = 0.0F;
  }
  for (std::size_t i = 0; i < facts.written.size(); ++i) {
    const auto is = [&](double code) { return isCode(facts.written[i], code); };
    if (std::any_of(codes.begin(), codes.end(), is)) beams[i].range = 0.0F;
  }
  scan.stamp = fromMicroseconds(from.stamp);
  use(from, channel::kScan, &Recording::scans, [&] { log_.add(from.received, scan, from.stamp); });
}

void Assembler::wheels(const Origin& origin, const Pose2& pose, std::span<const double> angles, bool turn_rate_known) {
  if (surveying_) return;
  const WheelSample sample{fromMicroseconds(origin.stamp), pose, turn_rate_known};
  use(origin, channel::kWheels, &Recording::wheels, [&] { log_.add(origin.received, sample, origin.stamp, angles); });
}

void Assembler::imu(const Origin& origin, const Eigen::Vector3d& gyro, const Eigen::Vector3d& accel) {
  if (surveying_) return;
  const ImuSample sample{fromMicroseconds(origin.stamp), gyro, accel};
  use(origin, channel::kImu, &Recording::imu, [&] { log_.add(origin.received, sample, origin.stamp); });
}

void Assembler::refuse(const Origin& origin, const std::string& why) {
  if (surveying_) return;
  if (origin.sensor.empty()) return recording.reject(origin.where, why);
  recording.reject(rows(origin), origin.where, why);
}

void Assembler::passOver(std::string_view kind, std::size_t most) {
  if (surveying_) return;
  const auto at = passed_over_.find(kind);
  if (at != passed_over_.end()) ++at->second;
  if (at == passed_over_.end() && passed_over_.size() < most) passed_over_.emplace(kind, 1);
}

void Assembler::noteChannels() {
  for (const auto& [channel, count] : passed_over_) {
    recording.unused.push_back(channel + ", " + std::to_string(count) + " messages: of a kind that is not read");
  }
}

void Assembler::endSurvey() {
  surveying_ = false;
  codes = census.codes();
  copied_turn_ = beam_times_.copiedTurn();
  if (!copied_turn_) return;
  char text[200];
  std::snprintf(text, sizeof(text),
                "the beams of a scan have one time, that of a turn which was complete: it was measured over the %.3f s "
                "before, and is used so",
                1e-6 * static_cast<double>(*copied_turn_));
  recording.notes.emplace_back(text);
}

Recording assemble(Reader&& reader, const std::filesystem::path& out) {
  Assembler assembler;
  reader.read(assembler);
  assembler.endSurvey();
  reader.decide(assembler);
  reader.read(assembler);
  reader.finish(assembler);
  assembler.log_.write(out, &assembler.recording);
  return std::move(assembler.recording);
}

std::int64_t spanOf(const LaserScan& scan) {
  float longest = 0.0F;
  for (const Beam& beam : scan.beams()) longest = std::max(longest, beam.time_offset);
  return std::llround(1e6 * static_cast<double>(longest));
}

void forEachLine(const std::filesystem::path& file, Assembler& to,
                 const std::function<void(const std::vector<std::string_view>&, Origin)>& body) {
  TextFile text(file);
  const auto here = [&] {
    return Origin{.sensor = {}, .where = file.filename().string() + ":" + std::to_string(text.lineNumber())};
  };
  for (std::string line; text.next(line);) {
    const auto words = splitWords(line);
    if (!words.empty()) body(words, here());
  }
  if (text.damaged()) to.refuse(here(), kDamage);
}

}  // namespace slam
