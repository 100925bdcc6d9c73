// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "core/timestamp.hpp"
#include "firmware_if/outgoing.hpp"
#include "problems/devices.hpp"

namespace slam {

/// What a base has sent, as far as one frame or answer tells it.
struct BaseReading {
  Timestamp stamp;         ///< when it was measured
  bool restarted = false;  ///< the base was reset since the reading before: it counts anew
  std::optional<std::array<std::uint32_t, 2>>
      counts{};                       ///< of the wheels' encoders: left, right, forward up; they wrap
  std::optional<double> turn_rate{};  ///< [rad/s] counter-clockwise, of its gyro
  std::optional<bool> lifted{};       ///< a wheel hangs in the air
  std::optional<bool> bumped{};       ///< a bumper is pressed
  std::optional<bool>
      obeys{};  ///< false: it has left the mode in which it drives, and no command has asked for it again
  std::optional<float> battery{};  ///< [V]
  Problem fault{};                 ///< a part of the base does not do its work; nothing: all do
  bool has_speed = false;          ///< the base is known to have the speed that was sent last
};

/// Speeds that the wheels of a base shall have [m/s].
struct SideSpeeds {
  double left = 0.0, right = 0.0;
  bool isZero() const { return left == 0.0 && right == 0.0; }
};

/// What SerialBase needs to know of one make's dialogue: bytes to readings, and speeds to bytes. A codec of firmware_if
/// has the bytes; here is what is asked when. No thread, port or clock; after construction no allocation.
class BaseProtocol {
 public:
  using Take = std::function<void(const BaseReading&)>;
  virtual ~BaseProtocol() = default;

  /// The port was opened: nothing is known of the base.
  virtual void begin(Timestamp now) = 0;
  /// A byte has come. @param take gets what it completes
  virtual void push(std::uint8_t byte, Timestamp now, const Take& take) = 0;
  /// The greeting or question that is to be sent now; empty: none.
  virtual Outgoing question(Timestamp now) = 0;
  /// Whether a speed may be sent now.
  virtual bool takesSpeeds(Timestamp) const { return true; }
  virtual Outgoing speeds(const SideSpeeds& wanted, Timestamp now) = 0;
  /// What is sent last, behind the last zero.
  virtual Outgoing farewell() { return {}; }
  virtual std::uint32_t damage() const = 0;  ///< frames, lines and questions that came to nothing
};

}  // namespace slam
