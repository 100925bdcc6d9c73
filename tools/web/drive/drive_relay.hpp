// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "core/estimates.hpp"
#include "core/timestamp.hpp"
#include "problems/problem.hpp"

namespace slam {

/// A speed that somebody asks for while a finger is held down.
struct DriveRequest {
  Twist2 twist;            ///< in base
  std::uint64_t hold = 0;  ///< of the press of the finger, another number for each; 0: of none, as for a stop
};
/// @return std::nullopt, and why not, for a body that is no such request
std::optional<DriveRequest> driveRequestOf(const std::string& body, std::string& problem);

/// Passes speeds of pages on to slamd, each once. A press of a finger drives until a zero of anybody, or until it was
/// silent for too long: then a zero follows, and what comes late of that press is refused, so that a link that comes
/// back does not move the robot. One press drives at a time. Time is data; safe from several threads.
class DriveRelay {
 public:
  /// slamd's own limit is twice as long. Pages send at 12 Hz.
  static constexpr Duration kLongestGap = std::chrono::milliseconds(250);
  /// @return false: it could not be sent
  using Send = std::function<bool(const Twist2&)>;

  explicit DriveRelay(Send send) : send_(std::move(send)) {}

  /// @return none, or why it is not driven @throws std::runtime_error where it cannot be sent
  Problem take(const DriveRequest& request, Timestamp now);
  /// Sends the zero that is due; belongs into each turn of a loop.
  void tend(Timestamp now);
  /// When tend() is due; std::nullopt: nothing is driven.
  std::optional<Timestamp> deadline() const;
  /// Stops; no more is driven.
  void end(Timestamp now);

 private:
  struct Ended {
    std::uint64_t hold;
    Timestamp when;
  };
  void endHold(std::uint64_t hold, Timestamp now);
  bool hasEnded(std::uint64_t hold, Timestamp now);
  void stopIfSilent(Timestamp now);

  const Send send_;
  mutable std::mutex mutex_;
  std::uint64_t hold_ = 0;     // that drives; 0: none
  Timestamp last_received_{};  // of it
  bool owes_stop_ = false, ends_ = false;
  std::deque<Ended> ended_;
};

}  // namespace slam
