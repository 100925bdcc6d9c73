// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "drivers/base/base_protocol.hpp"

namespace slam {

/// Dialogue with a base that answers each request, in their order and without a number. One request is under way at a
/// time. An answer that comes late must not pass for that of the next request of its kind: after one that was given up,
/// a question of another kind is asked until it is answered, since then all before it have been. A zero does not wait
/// for that: the base may receive although nothing of it is received.
class PolledProtocol : public BaseProtocol {
 public:
  void begin(Timestamp now) override;
  Outgoing question(Timestamp now) override;
  bool takesSpeeds(Timestamp now) const override;
  Outgoing speeds(const SideSpeeds& wanted, Timestamp now) override;

 protected:
  enum class Request : std::uint8_t {
    kSync,    ///< of a kind of its own, and harmless
    kCounts,  ///< the wheels'
    kSpeeds,
    kOther,  ///< of encodeOther()
  };
  /// @param period of the counts
  explicit PolledProtocol(Duration period) : period_(period) {}

  virtual Outgoing encode(Request question) = 0;
  virtual Outgoing encodeSpeeds(const SideSpeeds& wanted) = 0;
  /// What else is due; empty: nothing.
  virtual Outgoing encodeOther(Timestamp) { return {}; }
  /// What half an answer has left behind is void.
  virtual void forget() = 0;

  /// Nothing is sent until then.
  void rest(Timestamp until) { rests_until_ = until; }
  bool rests(Timestamp now) const { return now < rests_until_; }
  std::optional<Request> pending() const { return pending_; }
  /// Whether this is the answer to what is under way; then the next request may follow.
  bool settle(Request request);
  /// When the counts of the answer to the present request were taken: as soon as it had reached the base.
  Timestamp taken() const { return requested_ + kTravel; }
  std::uint32_t unanswered() const { return unanswered_; }

 private:
  static constexpr Duration kAnswer = std::chrono::milliseconds(100);  // a request not answered by then is lost
  static constexpr Duration kTravel = std::chrono::milliseconds(1);    // of a request: bytes, and a frame of the USB
  Outgoing ask(Request request, const Outgoing& bytes, Timestamp now);

  Duration period_;
  std::optional<Request> pending_;
  bool synced_ = false;  // no answer to a request given up before can still come
  Timestamp requested_{}, next_counts_{}, rests_until_{};
  std::uint32_t unanswered_ = 0;
};

}  // namespace slam
