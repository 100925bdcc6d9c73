// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

/// Whether two wheels turn as they are asked to. A drive in closed loop may not: one in another control mode than
/// velocity leaves speeds out, and no heartbeat tells the mode. A wheel that does not turn while the other one follows
/// makes a robot turn on the spot. Wheels that both do not turn, or are on their way to their speeds, are no danger.
class FollowWatch {
 public:
  using Speeds = std::array<double, 2>;  ///< [turns/s] left, right

  /// @param velocity [turns/s] that was sent to a wheel last
  void ask(std::size_t side, double velocity) { asked_[side] = velocity; }
  /// At each look while somebody drives. @param period at which the speeds are measured
  void add(Timestamp now, const Speeds& measured, Duration period) {
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t other = 1 - side;
      const double wanted = std::abs(asked_[side]), got = asked_[side] < 0.0 ? -measured[side] : measured[side];
      const bool other_follows = std::abs(measured[other]) >= kSlowest &&
                                 std::abs(measured[other] - asked_[other]) <= kFollows * std::abs(asked_[other]);
      const bool idles = wanted >= kSlowest && got < kIdles * wanted && other_follows;
      Idling& idling = idling_[side];
      if (!idles) {
        idling.since.reset();
      } else if (!idling.since || got > idling.best + kProgress * wanted) {
        idling = {now, got};
      } else if (now - *idling.since >= std::max(kLasts, 3 * period)) {
        idle_ = side;
      }
    }
  }
  /// Nobody drives.
  void rest() { idling_ = {}; }
  /// What was found is to be found anew.
  void forget() { idle_.reset(); }
  /// The wheel that does not follow.
  std::optional<std::size_t> idle() const { return idle_; }

 private:
  static constexpr double kSlowest = 0.1;   // [turns/s] slower ones may be friction
  static constexpr double kFollows = 0.3;   // [1] of what is asked, off at most
  static constexpr double kIdles = 0.2;     // [1] of what is asked, turned at most
  static constexpr double kProgress = 0.1;  // [1] of what is asked, gained meanwhile: it is on its way
  // A ramp of a third of the speed in a second is no idle wheel; a robot that turns on the spot stops within 0.5 s.
  static constexpr Duration kLasts = std::chrono::milliseconds(300);

  struct Idling {
    std::optional<Timestamp> since;  // without progress
    double best = 0.0;               // [turns/s] then, the way it is asked to turn
  };
  Speeds asked_{};
  std::array<Idling, 2> idling_{};
  std::optional<std::size_t> idle_;
};

}  // namespace slam
