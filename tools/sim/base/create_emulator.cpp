// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "firmware_if/create_oi.hpp"
#include "tools/sim/base/counting_base.hpp"

namespace slam::sim {
namespace {

using create_oi::Mode;

constexpr Duration kStreamPeriod = std::chrono::milliseconds(15);

/// A Create 2: it keeps the last speed for ever, but in safe mode a wheel that drops makes it passive, and stops it.
class CreateEmulator : public CountingBase {
 public:
  CreateEmulator() : CountingBase(geometryOf("create"), {65500, 40}) {}  // both soon wrap

 protected:
  void restart() override {
    setCountsBack();
    enter(Mode::kOff);
    streams_ = false;
    command_.clear();
  }
  void take(std::uint8_t byte, Bytes&) override {
    command_.push_back(byte);
    const std::size_t wanted = sizeOf(command_);
    if (command_.size() < wanted) return;
    obey();
    command_.clear();
  }
  void send(Bytes& out) override {
    const bool obeys = mode_ == Mode::kSafe || mode_ == Mode::kFull;
    if (mode_ == Mode::kSafe && lifted()) enter(Mode::kPassive);
    next_ = std::max(next_, now() - kStreamPeriod);
    for (; streams_ && mode_ != Mode::kOff && next_ <= now(); next_ += kStreamPeriod) {
      const auto all = counts();
      deliver(
          create_oi::encodeStream({.dropped = lifted(),
                                   .bumped = bumped(),
                                   .voltage = 14400,
                                   .mode = mode_,
                                   .requested = obeys ? requested_ : std::array<std::int16_t, 2>{},
                                   .counts = {static_cast<std::uint16_t>(all[0]), static_cast<std::uint16_t>(all[1])}}),
          out);
    }
  }
  SideSpeeds sides() const override { return {1e-3 * requested_[0], 1e-3 * requested_[1]}; }

 private:
  /// [bytes] of a command that begins so.
  static std::size_t sizeOf(const Bytes& command) {
    switch (command[0]) {
      case 137:
      case 145:
      case 146:
        return 5;
      case 148:
      case 149:
        return command.size() < 2 ? 2 : 2U + command[1];
      case 129:
      case 142:
      case 150:
      case 165:
        return 2;
      default:
        return 1;
    }
  }
  void enter(Mode mode) {
    mode_ = mode;
    if (mode == Mode::kOff || mode == Mode::kPassive) requested_ = {};
  }
  std::int16_t word(std::size_t at) const { return static_cast<std::int16_t>(command_[at] << 8 | command_[at + 1]); }
  void obey() {
    if (command_[0] == 128) return enter(Mode::kPassive);
    if (command_[0] == 173) streams_ = false;
    if (command_[0] == 173) return enter(Mode::kOff);
    if (mode_ == Mode::kOff) return;
    switch (command_[0]) {
      case 131:
        return enter(lifted() ? Mode::kPassive : Mode::kSafe);
      case 145:
        if (mode_ != Mode::kPassive) requested_ = {word(3), word(1)};
        return;
      case 148:
        streams_ = true;
        use();
        return;
      case 150:
        streams_ = command_[1] != 0;
        return;
      default:
        return;
    }
  }

  Bytes command_;  // that is not whole yet
  Mode mode_ = Mode::kOff;
  bool streams_ = false;
  Timestamp next_{};
  std::array<std::int16_t, 2> requested_{};  // [mm/s] left, right
};

}  // namespace

std::unique_ptr<EmulatedBase> makeCreate() { return std::make_unique<CreateEmulator>(); }

}  // namespace slam::sim
