// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board/handsfree_board.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

using namespace std::chrono_literals;
using robolink::ChassisType;
using robolink::Command;

constexpr Duration kInfo = 200ms;           // between looks at the board's time, which tell one that renews nothing
constexpr Duration kAnswer = 100ms;         // a request not answered by then is lost
constexpr Duration kStale = 500ms;          // no answer at all
constexpr Duration kDead = 3s;              // then the port is opened anew
constexpr Duration kDrivePeriod = 50ms;     // the board's own control loop
constexpr Duration kChassisPeriod = 1s;     // between attempts
constexpr int kStopTries = 10;              // at the end
constexpr Duration kStopAnswer = 10ms;      // to each
constexpr int kChassisTries = 3;            // an old firmware may not know the command
constexpr float kLongRun = 2048.0F;         // [rad] above, single precision begins to cost: 0.04 % of the way
constexpr Duration kStandingForClear = 1s;  // before the counters are set back
constexpr Duration kClearPeriod = 60s;      // between attempts
constexpr std::int64_t kNanoseconds = 1'000'000'000;

int wheelsOf(ChassisType type) {
  switch (type) {
    case ChassisType::kDifferential2:
      return 2;
    case ChassisType::kOmni3:
      return 3;
    default:
      return 4;
  }
}

std::array<std::uint8_t, robolink::kCoordinateSize> encodeTriple(const std::array<double, 3>& numbers) {
  return robolink::encodeCoordinate(
      {static_cast<float>(numbers[0]), static_cast<float>(numbers[1]), static_cast<float>(numbers[2])});
}

}  // namespace

HandsfreeBoard::HandsfreeBoard(const HandsfreeConfig& config, Clock now, Sinks sinks, const PortOpener& open)
    : config_(config),
      now_(now),
      sinks_(std::move(sinks)),
      wheel_count_(wheelsOf(config.chassis)),
      port_(config.port, config.baud, config.in_background, open),
      wrong_speaker_(PortOf::kBoard, config.port, config.baud, open),
      polls_{Poll{Command::kGetMotorMileage, PollSchedule(fromSeconds(1.0 / config.mileage_rate))},
             Poll{Command::kGetImu, PollSchedule(fromSeconds(1.0 / config.imu_rate))},
             Poll{Command::kGetSystemInfo, PollSchedule(kInfo)}, Poll{Command::kGetMotorSpeed, PollSchedule(100ms)}},
      speeds_(config.may_drive, config.limits, kDrivePeriod) {}

void HandsfreeBoard::tick() {
  const Timestamp now = now_();
  if (!port_.isOpen()) {
    if (wrong_speaker_.running()) {
      if (port_.isReleased() && !wrong_speaker_.tick(now))
        setBoth(DeviceState::kFault, wrong_speaker_.found(wheels_.problem()));
    } else if (port_.due(now)) {
      open(now);
    }
    return;
  }
  if (!receive()) return close(now, DeviceState::kAbsent, problem::kPortGone);
  watch(now);
  if (port_.isOpen()) request(now);
}

void HandsfreeBoard::stop() {
  for (int i = 0; i < kStopTries && port_.isOpen() && speeds_.isOwed(); ++i) {
    // The answer to a speed that is still under way comes first, and is not the zero's.
    speeds_.sendZero(drained_ && pending_ != Command::kSetRobotSpeed);
    ask(now_(), Command::kSetRobotSpeed, robolink::encodeCoordinate({}));
    if (!receive(kStopAnswer)) break;
  }
  port_.close();
}

bool HandsfreeBoard::command(double vx, double vy, double omega, Timestamp given) {
  return speeds_.give({vx, vy, omega}, given);
}

void HandsfreeBoard::open(Timestamp now) {
  if (const Problem problem = port_.open(now)) {
    wrong_speaker_.forget();
    return setBoth(DeviceState::kAbsent, problem);
  }
  decoder_.reset();
  pending_.reset();
  drained_ = true;
  bytes_came_ = false;
  // A board that kept its power goes on counting where it was: one that did not asks for the handshake first.
  chassis_tries_left_ = kChassisTries;
  next_chassis_ = now;
  answered_ = now;
  speeds_.owe();
  for (DeviceStatus* status : {&wheels_, &imu_}) status->setOpening(problem::kBoardOpening);
}

void HandsfreeBoard::close(Timestamp now, DeviceState state, const Problem& why) {
  port_.fail(now);
  if (state == DeviceState::kAbsent) wrong_speaker_.forget();
  setBoth(state, why);
}

void HandsfreeBoard::setBoth(DeviceState state, const Problem& why) {
  wheels_.set(state, why);
  imu_.set(state, why);
}

bool HandsfreeBoard::receive(Duration wait) {
  const bool open = port_.drain(
      [this](std::uint8_t byte) {
        bytes_came_ = true;
        for (auto frame = decoder_.push(byte); frame; frame = decoder_.flush()) handle(*frame);
      },
      wait);
  const auto& counters = decoder_.counters();
  const auto damaged = counters.bad_checksums + counters.bad_lengths + counters.foreign_frames;
  wheels_.rejects.store(damaged + unanswered_ + bad_mileage_, std::memory_order_relaxed);
  return open;
}

void HandsfreeBoard::handle(const robolink::Frame& frame) {
  answered_ = now_();
  port_.succeeded();
  wrong_speaker_.forget();
  bytes_came_ = false;
  const auto command = static_cast<Command>(frame.command);
  if (command == Command::kShakingHands) return greet();
  if (!pending_ || command != *pending_) {
    late_ = answered_;
    return;
  }
  pending_.reset();
  if (command == Command::kSetRobotSpeed) speeds_.acknowledge();
  drained_ = drained_ || command == Command::kGetSystemInfo;
  if (handleAnswer(command, frame.payload)) return;
  if (command == Command::kGetMotorMileage) {
    ++bad_mileage_;
    restarted_ = true;  // whatever it counts next need not be what it counted before
  } else {
    imu_.rejects.fetch_add(1, std::memory_order_relaxed);
  }
}

/// The board has just started. It wants the last coordinate and the time.
void HandsfreeBoard::greet() {
  sendCoordinate();
  robolink::SystemInfo info;
  if (const std::int64_t offset = local_time_offset_; offset != 0) {
    info.local_time = robolink::localTimeAt((answered_.time_since_epoch().count() + offset) / kNanoseconds);
  }
  ask(answered_, Command::kSetSystemInfo, robolink::encodeSystemInfo(info));
  drained_ = restarted_ = true;
  speeds_.owe();
  mileage_.clock.restart();
  last_imu_.clock.restart();
  time_ran_ = frozen_ = false;
  still_looks_ = 0;
  chassis_tries_left_ = kChassisTries;
  next_chassis_ = answered_;
}

void HandsfreeBoard::watch(Timestamp now) {
  const auto silent = [&](const DeviceStatus& status) {
    const std::int64_t last = status.last_sample_ns.load(std::memory_order_relaxed);
    return status.state == DeviceState::kStreaming && now.time_since_epoch().count() - last > kStale.count();
  };
  if (now - answered_ > kDead) {
    const Problem unknown = bytes_came_ ? problem::kBoardUndecoded : problem::kBoardUnanswered;
    close(now, DeviceState::kFault, wrong_speaker_.found(unknown));
    return wrong_speaker_.ask();
  }
  if (now - answered_ > kStale) {
    const Problem unknown = bytes_came_ ? problem::kBoardGarbage : problem::kBoardSilent;
    return setBoth(DeviceState::kStale, wrong_speaker_.found(unknown));
  }
  if (now - answered_ > kAnswer) return;  // it may be the board that has just fallen silent
  // Now and then one that is late passes for the answer to the same question asked anew.
  const bool late = late_ && now - *late_ < kStale;
  if (silent(imu_)) imu_.set(DeviceState::kStale, late ? problem::kBoardLate : problem::kBoardImuFrozen);
  if (silent(wheels_)) wheels_.set(DeviceState::kStale, late ? problem::kBoardLate : problem::kBoardNoMileage);
}

void HandsfreeBoard::request(Timestamp now) {
  if (pending_) {
    if (now - requested_ < kAnswer) return;
    pending_.reset();
    decoder_.reset();  // half a frame must not hold the next answer back
    ++unanswered_;
    drained_ = false;
    speeds_.owe();
  }
  // Answers carry no number, and one that comes late must not pass for that of the next request. They come in order:
  // when another command has been answered, all before it have been.
  if (!drained_) {
    // The board may hear although it is not heard: its zero does not wait for that.
    if (speeds_.isOwed() && !speeds_.drives(now)) send(Command::kSetRobotSpeed, robolink::encodeCoordinate({}));
    return ask(now, Command::kGetSystemInfo);
  }
  if (requestDrive(now) || requestOnce(now)) return;
  Poll* next = nullptr;
  for (Poll& poll : polls_) {
    const bool unwanted = (poll.command == Command::kGetMotorSpeed && !sinks_.speeds) ||
                          (poll.command == Command::kGetImu && !sinks_.imu);
    if (!unwanted && (next == nullptr || poll.schedule.due() < next->schedule.due())) next = &poll;
  }
  if (next->schedule.due() > now) return;
  next->schedule.advance(now);
  ask(now, next->command);
}

bool HandsfreeBoard::requestDrive(Timestamp now) {
  const std::optional<Twist2> speed = speeds_.due(now);
  if (!speed) return false;
  ask(now, Command::kSetRobotSpeed, encodeTriple({speed->vx, speed->vy, speed->omega}));
  return true;
}

/// What is asked now and then: the board's idea of its chassis, and counters from zero before they get coarse.
bool HandsfreeBoard::requestOnce(Timestamp now) {
  if (chassis_tries_left_ > 0 && now >= next_chassis_) {
    --chassis_tries_left_;
    next_chassis_ = now + kChassisPeriod;
    ask(now, Command::kReadChassisParameters);
    return true;
  }
  const auto coarse = [](float angle) { return std::abs(angle) > kLongRun; };
  if (!mileage_.values || frozen_ || speeds_.isOwed() || now < next_clear_ ||
      now - mileage_.changed < kStandingForClear ||
      std::none_of(mileage_.values->begin(), mileage_.values->end(), coarse)) {
    return false;
  }
  next_clear_ = now + kClearPeriod;
  ask(now, Command::kClearCoordinateData);
  return true;
}

void HandsfreeBoard::sendCoordinate() { send(Command::kShakingHands, encodeTriple(coordinate_.load().numbers)); }

void HandsfreeBoard::ask(Timestamp now, Command command, std::span<const std::uint8_t> payload) {
  send(command, payload);
  pending_ = command;
  requested_ = now;
}

void HandsfreeBoard::send(Command command, std::span<const std::uint8_t> payload) {
  std::array<std::uint8_t, robolink::kMaxFrame> frame;
  const std::size_t size = robolink::encodeFrame(robolink::kMaster, robolink::kSlave, command, payload, frame);
  port_.write({frame.data(), size});
}

}  // namespace slam
