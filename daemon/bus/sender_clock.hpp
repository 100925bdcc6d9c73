// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "bus/refusal.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// How far the clock of who sends a stream is from ours, by the least delay seen lately: no message comes before it was
/// sent, and one of many is hardly late. One stamp far from the others of its stream is damaged or was delayed; when
/// the others follow it, the sender's clock was set.
class LeastDelay {
 public:
  /// @param confirmed_after a difference of clocks is believed when it has lasted so long. 0: with the second message
  explicit LeastDelay(Duration confirmed_after) : confirmed_after_(confirmed_after) {}

  /// @param age of the message by its stamp, below zero: it comes from the future
  Refusal add(Duration age, Timestamp now);
  /// Least age of a message within the last seconds, with both clocks' difference in it; std::nullopt: not known.
  std::optional<Duration> least() const;
  Timestamp lastReceived() const { return last_received_; }

 private:
  void begin(Duration age, Timestamp now);
  bool confirms(Duration age, Timestamp now, Duration after);

  Duration confirmed_after_;
  std::optional<Duration> present_, before_;  // least ages of this part of the window, and of the one before
  Timestamp part_began_{}, last_received_{};
  std::optional<Duration> doubted_;  // age of messages that do not fit
  Timestamp doubted_since_{}, doubted_last_{};
};

/// Stamps of several streams in our time. Streams of one sender have one clock: what differs between them is how long
/// their messages take.
class SenderClocks {
 public:
  enum Stream : std::uint8_t { kLidar, kWheels, kImu, kDepth, kDrive };

  struct Mapped {
    Refusal refusal = Refusal::kNone;
    Duration shift{0};     ///< to be added to the stamp, because the clocks differ; 0: they do not
    bool differs = false;  ///< the sender's clock, from our stamps and from this computer's wall clock
    Duration age{0};       ///< of the stamp, by whichever of these two it is nearer to; below zero: from the future
  };
  /// @param stamp  in our time, as if the sender's clock were ours
  /// @param lasted [s] of the measurement behind its stamp: it cannot have been sent before it was over
  Mapped map(Stream stream, Timestamp stamp, Duration lasted, Timestamp now);
  /// Our own clock was set: what is known of others is worth nothing.
  /// @param ahead by which our stamps are ahead of the wall clock now, because it was set back and they never go back
  void begin(Duration ahead);

 private:
  static constexpr std::size_t kStreams = 5;
  std::array<LeastDelay, kStreams> streams_ = fresh();
  std::array<bool, kStreams> differs_{};
  Duration ahead_{0};

  static std::array<LeastDelay, kStreams> fresh();
};

}  // namespace slam
