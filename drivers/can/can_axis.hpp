// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/timestamp.hpp"
#include "drivers/can/pace.hpp"
#include "firmware_if/can_odrive.hpp"

namespace slam {

/// What is known of one wheel's drive besides the angle of its wheel.
///
/// What a heartbeat says beside its axis error depends on the drive's firmware. The dialect is told by the drive's
/// version, or by a heartbeat that only one of them can send; until it is known the axis error alone decides.
class CanAxis {
 public:
  using Dialect = can::odrive::Dialect;
  /// The shortest silence that counts as one: three heartbeats of a drive as delivered.
  static constexpr Duration kFramesLost = std::chrono::milliseconds(300);

  /// @param node of the drive. @return false: the frame is no heartbeat
  bool addHeartbeat(Timestamp stamp, int node, const can::Frame& frame) {
    if (!can::odrive::parseHeartbeat(node, frame)) return false;
    if (stamp - heartbeat_ > kForgotten) forgetDialect();  // it may be another drive, or another firmware
    noteDialect(can::odrive::dialectOf(frame), frame.data[5] != 0 || frame.data[6] != 0);
    addHeartbeat(stamp, *can::odrive::parseHeartbeat(node, frame, dialect_));
    return true;
  }
  void addHeartbeat(Timestamp stamp, const can::odrive::Heartbeat& heartbeat) {
    // A damaged frame is not an error of the drive: what it says has to come twice.
    if (last_ && last_->axis_error == heartbeat.axis_error && last_->state == heartbeat.state) newest_ = heartbeat;
    last_ = heartbeat;
    heartbeat_ = stamp;
    heartbeats_.add(stamp);
  }
  /// A frame with the id of its heartbeat that another device may have sent. @return whether one does: frames of that
  /// id come too fast to be heartbeats, and count as none
  bool sharesHeartbeat(Timestamp stamp) {
    crowded_ = stamp - heartbeat_ < kCrowded ? std::min(crowded_ + 1, kMostCrowded) : crowded_ / 2;
    if (!isShared()) return false;
    last_.reset();
    newest_.reset();
    heartbeat_ = stamp;
    return true;
  }
  bool isShared() const { return crowded_ >= kMostCrowded; }
  /// Whether to ask for its version now: a few times, as long as that would settle what it says.
  bool wantsVersion(Timestamp now) {
    if (!isAmbiguous() || version_request_.times >= kAskTries || now < version_request_.next) return false;
    version_request_ = {version_request_.times + 1, now + kAskPeriod};
    return true;
  }
  /// It is gone, and may come back as another.
  void askAnew() { version_request_ = {}; }
  void addVersion(const can::odrive::Version& version) {
    version_ = version;
    dialect_ = version.dialect();
  }
  /// @param step [turns] of its position: slower than two of them in the time in which it is taken for frozen, it may
  /// stay the same
  void setStep(double step) { turning_ = std::max(turning_, static_cast<float>(2.0 * step / toSeconds(kFrozen))); }
  void addEstimates(Timestamp stamp, const can::odrive::EncoderEstimates& estimates) {
    const bool moved = estimates.position != position_ || std::abs(estimates.velocity) < turning_;
    if (moved || stamp - estimates_ > kFrozen) moved_ = stamp;
    position_ = estimates.position;
    velocity_ = estimates.velocity;
    estimates_ = stamp;
  }
  void addBadEstimates(Timestamp stamp) { bad_estimates_ = stamp; }

  Timestamp heartbeat() const { return heartbeat_; }  ///< when the last one came
  Timestamp estimates() const { return estimates_; }  ///< the same
  /// Some that are no numbers came within this time.
  bool hasBadEstimates(Timestamp now, Duration within) const {
    return bad_estimates_ != Timestamp{} && now - bad_estimates_ <= within;
  }
  double velocity() const { return static_cast<double>(velocity_); }  ///< [turns/s] in the last of them
  const std::optional<can::odrive::Heartbeat>& lastHeartbeat() const { return newest_; }
  Dialect dialect() const { return dialect_; }
  const std::optional<can::odrive::Version>& version() const { return version_; }  ///< that it has told
  /// What it says means one thing in one dialect and another in the other.
  bool isAmbiguous() const {
    return dialect_ == Dialect::kUnknown && newest_ && (newest_->motor_error || newest_->encoder_error);
  }
  bool faulty() const { return newest_ && isFaulty(*newest_); }
  bool inClosedLoop() const { return newest_ && isClosedLoop(*newest_); }
  /// It does what it is asked for, by what it says. One heartbeat is enough that it does not, two in a row that it
  /// does.
  bool obeys() const {
    const auto well = [this](const auto& h) { return h && isClosedLoop(*h) && !isFaulty(*h); };
    return well(last_) && well(newest_);
  }
  /// How long there may be no heartbeat, by the period at which the drive sends them.
  Duration heartbeatPatience() const { return patienceFor(heartbeats_.period(), kFramesLost); }
  /// Its position stays the same although it says that the wheel turns.
  bool frozen() const { return estimates_ - moved_ > kFrozen; }
  /// Its position is no measurement.
  bool positionInvalid() const { return frozen() || encoderFailed(); }
  /// What its heartbeat says, without the flags that may be none.
  std::optional<can::odrive::Heartbeat> usableHeartbeat() const {
    auto heartbeat = newest_;
    if (!heartbeat || dialect_ == Dialect::k05) return heartbeat;
    heartbeat->motor_error = heartbeat->controller_error = false;
    heartbeat->encoder_error = encoderFailed();
    return heartbeat;
  }

 private:
  static constexpr Duration kFrozen = std::chrono::milliseconds(300);
  static constexpr Duration kForgotten = std::chrono::seconds(3);
  static constexpr Duration kCrowded = std::chrono::milliseconds(25);  // between two frames of a heartbeat's id
  static constexpr int kMostCrowded = 20;                              // in a row
  static constexpr Duration kAskPeriod = std::chrono::seconds(1);      // for its version
  static constexpr int kAskTries = 3;

  /// @param flagged the heartbeat has what is a flag in one of them
  void noteDialect(Dialect evidence, bool flagged) {
    const bool twice = evidence == std::exchange(evidence_, evidence);
    if (twice && !version_ && (flagged || evidence != Dialect::kUnknown)) dialect_ = evidence;
  }
  void forgetDialect() {
    dialect_ = evidence_ = Dialect::kUnknown;
    version_.reset();
  }
  static bool isClosedLoop(const can::odrive::Heartbeat& heartbeat) {
    return heartbeat.state == std::uint8_t(can::odrive::AxisState::kClosedLoop);
  }
  bool isFaulty(const can::odrive::Heartbeat& h) const {
    const bool flagged = dialect_ == Dialect::k05 && (h.motor_error || h.encoder_error || h.controller_error);
    return h.axis_error != 0 || flagged;
  }
  bool encoderFailed() const {
    if (!newest_ || !newest_->encoder_error) return false;
    // Where the dialect is not known: error word and flag agree in that it failed.
    return dialect_ == Dialect::k05 || (newest_->axis_error & can::odrive::kEncoderFailed05) != 0;
  }

  std::optional<can::odrive::Heartbeat> last_, newest_;
  std::optional<can::odrive::Version> version_;
  Dialect dialect_ = Dialect::kUnknown, evidence_ = Dialect::kUnknown;
  Timestamp heartbeat_{}, estimates_{}, bad_estimates_{}, moved_{};
  Pace heartbeats_;
  float position_ = 0.0F, velocity_ = 0.0F;  // [turns, turns/s]
  float turning_ = 0.05F;                    // [turns/s] a wheel that is faster changes its position
  int crowded_ = 0;                          // frames of its heartbeat's id in a row that came too fast to be some
  struct VersionRequest {
    int times = 0;
    Timestamp next{};
  };
  VersionRequest version_request_;
};

}  // namespace slam
