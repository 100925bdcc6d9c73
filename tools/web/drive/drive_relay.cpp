// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/drive/drive_relay.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "problems/answer.hpp"
#include "problems/answers.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
// The largest base.max_speed and base.max_turn_rate that can be set; slamd slows what is above the ones that are.
constexpr double kFastest = 10.0;      // [m/s]
constexpr double kFastestTurn = 20.0;  // [rad/s]
constexpr Duration kRemembered = 30s;  // an ended press: longer than a request is on its way, and waits for a thread
constexpr std::size_t kMostEnded = 64;
constexpr std::uint64_t kMostHold = std::uint64_t{1} << 53;  // what a page counts to

bool isZero(const Twist2& twist) { return twist.vx == 0.0 && twist.vy == 0.0 && twist.omega == 0.0; }

}  // namespace

std::optional<DriveRequest> driveRequestOf(const std::string& body, std::string& problem) {
  using nlohmann::json;
  const json request = json::parse(body, nullptr, false);
  if (!request.is_object()) {
    problem = "the body is not a JSON object";
    return std::nullopt;
  }
  const auto numberAt = [&](const char* key, double otherwise) {
    const auto at = request.find(key);
    return at == request.end() ? otherwise : at->is_number() ? at->get<double>() : std::nan("");
  };
  DriveRequest drive;
  drive.twist = {numberAt("vx", std::nan("")), numberAt("vy", 0.0), numberAt("omega", std::nan(""))};
  const Twist2& twist = drive.twist;
  const bool possible =
      std::abs(twist.vx) <= kFastest && std::abs(twist.vy) <= kFastest && std::abs(twist.omega) <= kFastestTurn;
  if (!possible) {  // or no number
    problem = "\"vx\" and \"vy\" [m/s] are not numbers from -10 to 10, or \"omega\" [rad/s] is none from -20 to 20";
    return std::nullopt;
  }
  const auto hold = request.find("hold");
  const bool counted = hold != request.end() && hold->is_number_unsigned() && hold->get<std::uint64_t>() < kMostHold;
  if (hold != request.end() && !counted) {
    problem = "\"hold\" is no whole number from 0 to 2^53 - 1";
    return std::nullopt;
  }
  drive.hold = counted ? hold->get<std::uint64_t>() : 0;
  if (drive.hold != 0 || isZero(twist)) return drive;
  problem = "a speed needs \"hold\", a number above 0 that is another one for each press";
  return std::nullopt;
}

void DriveRelay::endHold(std::uint64_t hold, Timestamp now) {
  if (hold == 0) return;
  ended_.push_back({hold, now});
  if (ended_.size() > kMostEnded) ended_.pop_front();
}

bool DriveRelay::hasEnded(std::uint64_t hold, Timestamp now) {
  while (!ended_.empty() && now - ended_.front().when > kRemembered) ended_.pop_front();
  return std::any_of(ended_.begin(), ended_.end(), [&](const Ended& ended) { return ended.hold == hold; });
}

void DriveRelay::stopIfSilent(Timestamp now) {
  if (hold_ != 0 && now - last_received_ >= kLongestGap) {
    endHold(std::exchange(hold_, 0), now);
    owes_stop_ = true;
  }
  if (owes_stop_) owes_stop_ = !send_({});
}

Problem DriveRelay::take(const DriveRequest& request, Timestamp now) {
  const std::lock_guard lock(mutex_);
  if (isZero(request.twist)) {
    endHold(std::exchange(hold_, 0), now);
    endHold(request.hold, now);
    owes_stop_ = !send_({});
    if (owes_stop_) throw CommandRefused(answer::kStopNotSent);
    return {};
  }
  stopIfSilent(now);
  if (ends_) return answer::kWebEnds;
  if (owes_stop_) throw CommandRefused(answer::kSpeedNotSent);
  if (hasEnded(request.hold, now)) return answer::kPressOver;
  if (hold_ != 0 && hold_ != request.hold) return answer::kOtherDrives;
  hold_ = request.hold;
  last_received_ = now;
  if (send_(request.twist)) return {};
  endHold(std::exchange(hold_, 0), now);
  owes_stop_ = true;
  throw CommandRefused(answer::kSpeedNotSent);
}

void DriveRelay::tend(Timestamp now) {
  const std::lock_guard lock(mutex_);
  stopIfSilent(now);
}

std::optional<Timestamp> DriveRelay::deadline() const {
  const std::lock_guard lock(mutex_);
  return hold_ == 0 ? std::nullopt : std::optional(last_received_ + kLongestGap);
}

void DriveRelay::end(Timestamp now) {
  const std::lock_guard lock(mutex_);
  ends_ = true;
  if (hold_ != 0) last_received_ = now - kLongestGap;
  stopIfSilent(now);
}

}  // namespace slam
