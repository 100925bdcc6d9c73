// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board/handsfree_board.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

using namespace std::chrono_literals;
using robolink::Command;

constexpr Duration kInfo = 200ms;             // between looks at the board's time, which tell one that renews nothing
constexpr Duration kAnswer = 100ms;           // a request not answered by then is lost
constexpr Duration kBoardStale = 500ms;       // no answer at all
constexpr Duration kBoardDead = 3s;           // then the port is opened anew
constexpr Duration kBoardDrivePeriod = 50ms;  // the board's own control loop
constexpr Duration kChassisPeriod = 1s;       // between attempts
constexpr int kStopTries = 10;                // at the end
constexpr Duration kStopAnswer = 10ms;        // to each
constexpr int kChassisTries = 3;              // an old firmware may not know the command
constexpr Duration kClearPeriod = 60s;        // between attempts

std::array<std::uint8_t, robolink::kCoordinateSize> encodeTriple(const std::array<double, 3>& numbers) {
  return robolink::encodeCoordinate(
      {static_cast<float>(numbers[0]), static_cast<float>(numbers[1]), static_cast<float>(numbers[2])});
}

}  // namespace

void HandsfreeBoard::Request::begin(Timestamp now) {
  decoder_.reset();
  pending_.reset();
  drained_ = true;
  bytes_came_ = false;
  answered_ = now;
}

bool HandsfreeBoard::Request::take(Command command) {
  if (command != pending_) {
    late_ = answered_;
    return false;
  }
  pending_.reset();
  drained_ = drained_ || command == Command::kGetSystemInfo;
  return true;
}

bool HandsfreeBoard::Request::giveUp(Timestamp now) {
  if (now - requested_ < kAnswer) return false;
  pending_.reset();
  decoder_.reset();  // half a frame must not hold the next answer back
  ++unanswered_;
  drained_ = false;
  return true;
}

bool HandsfreeBoard::Request::wasLate(Timestamp now) const { return late_ && now - *late_ < kBoardStale; }

std::uint32_t HandsfreeBoard::Request::rejects() const {
  const auto& counters = decoder_.counters();
  return counters.bad_checksums + counters.bad_lengths + counters.foreign_frames + unanswered_;
}

HandsfreeBoard::Schedule::Schedule(const HandsfreeConfig& config)
    : polls_{Poll{Command::kGetMotorMileage, PollSchedule(fromSeconds(1.0 / config.mileage_rate))},
             Poll{Command::kGetImu, PollSchedule(fromSeconds(1.0 / config.imu_rate))},
             Poll{Command::kGetSystemInfo, PollSchedule(kInfo)}, Poll{Command::kGetMotorSpeed, PollSchedule(100ms)}} {}

void HandsfreeBoard::Schedule::begin(Timestamp now) {
  chassis_tries_left_ = kChassisTries;
  next_chassis_ = now;
}

std::optional<Command> HandsfreeBoard::Schedule::next(Timestamp now, bool imu, bool speeds) {
  Poll* next = nullptr;
  for (Poll& poll : polls_) {
    const bool unwanted =
        (poll.command == Command::kGetMotorSpeed && !speeds) || (poll.command == Command::kGetImu && !imu);
    if (!unwanted && (next == nullptr || poll.schedule.due() < next->schedule.due())) next = &poll;
  }
  if (next->schedule.due() > now) return std::nullopt;
  next->schedule.advance(now);
  return next->command;
}

bool HandsfreeBoard::Schedule::chassisDue(Timestamp now) {
  if (chassis_tries_left_ <= 0 || now < next_chassis_) return false;
  --chassis_tries_left_;
  next_chassis_ = now + kChassisPeriod;
  return true;
}

bool HandsfreeBoard::Schedule::clearDue(Timestamp now) {
  if (now < next_clear_) return false;
  next_clear_ = now + kClearPeriod;
  return true;
}

HandsfreeBoard::HandsfreeBoard(const HandsfreeConfig& config, Clock now, Sinks sinks, const PortOpener& open)
    : config_(config),
      now_(now),
      sinks_(std::move(sinks)),
      port_(PortOf::kBoard, config.port, config.baud, config.in_background, open, LineDevice::kBoard,
            {&wheels_, &imu_}),
      schedule_(config),
      mileage_(config.chassis),
      speeds_(config.may_drive, config.limits, kBoardDrivePeriod) {}

void HandsfreeBoard::tick() {
  const Timestamp now = now_();
  if (!port_.isOpen()) {
    if (port_.openWhenDue(now)) begin(now);
    return;
  }
  if (!receive()) return port_.lose(now);
  watch(now);
  if (port_.isOpen()) request(now);
}

void HandsfreeBoard::stop() {
  for (int i = 0; i < kStopTries && port_.isOpen() && speeds_.isOwed(); ++i) {
    // The answer to a speed that is still under way comes first, and is not the zero's.
    speeds_.sendZero(request_.isDrained() && request_.pending() != Command::kSetRobotSpeed);
    ask(now_(), Command::kSetRobotSpeed, robolink::encodeCoordinate({}));
    if (!receive(kStopAnswer)) break;
  }
  port_.close();
}

bool HandsfreeBoard::command(double vx, double vy, double omega, Timestamp given) {
  return speeds_.give({vx, vy, omega}, given);
}

void HandsfreeBoard::begin(Timestamp now) {
  // A board that kept its power goes on counting where it was: one that did not asks for the handshake first.
  request_.begin(now);
  schedule_.begin(now);
  speeds_.owe();
  for (DeviceStatus* status : {&wheels_, &imu_}) status->setOpening(problem::kBoardOpening);
}

bool HandsfreeBoard::receive(Duration wait) {
  const bool open = port_.drain(
      [this](std::uint8_t byte) {
        for (auto frame = request_.push(byte); frame; frame = request_.flush()) handle(*frame);
      },
      wait);
  wheels_.rejects.store(request_.rejects() + mileage_.rejects(), std::memory_order_relaxed);
  return open;
}

void HandsfreeBoard::handle(const robolink::Frame& frame) {
  request_.noteFrame(now_());
  port_.succeeded();
  const auto command = static_cast<Command>(frame.command);
  if (command == Command::kShakingHands) return greet();
  if (!request_.take(command)) return;
  if (command == Command::kSetRobotSpeed) speeds_.acknowledge();
  if (handleAnswer(command, frame.payload)) return;
  if (command == Command::kGetMotorMileage) {
    mileage_.reject();
  } else {
    imu_.rejects.fetch_add(1, std::memory_order_relaxed);
  }
}

/// The board has just started. It wants the last coordinate and the time.
void HandsfreeBoard::greet() {
  sendCoordinate();
  const Timestamp now = request_.answered();
  ask(now, Command::kSetSystemInfo, robolink::encodeSystemInfo(host_.infoAt(now)));
  request_.noteRestart();
  speeds_.owe();
  mileage_.restart();
  last_imu_.clock.restart();
  time_.restart();
  schedule_.begin(now);
}

void HandsfreeBoard::watch(Timestamp now) {
  const auto silent = [&](const DeviceStatus& status) {
    const std::int64_t last = status.last_sample_ns.load(std::memory_order_relaxed);
    return status.state == DeviceState::kStreaming && now.time_since_epoch().count() - last > kBoardStale.count();
  };
  const Duration silence = now - request_.answered();
  if (silence > kBoardDead) {
    const Problem unknown = request_.bytesCame() ? problem::kBoardUndecoded : problem::kBoardUnanswered;
    return port_.giveUp(now, unknown);
  }
  if (silence > kBoardStale) {
    const Problem unknown = request_.bytesCame() ? problem::kBoardGarbage : problem::kBoardSilent;
    return port_.report(DeviceState::kStale, unknown);
  }
  if (silence > kAnswer) return;  // it may be the board that has just fallen silent
  // Now and then one that is late passes for the answer to the same question asked anew.
  const bool late = request_.wasLate(now);
  if (silent(imu_)) imu_.set(DeviceState::kStale, late ? problem::kBoardLate : problem::kBoardImuFrozen);
  if (silent(wheels_)) wheels_.set(DeviceState::kStale, late ? problem::kBoardLate : problem::kBoardNoMileage);
}

void HandsfreeBoard::request(Timestamp now) {
  if (request_.pending()) {
    if (!request_.giveUp(now)) return;
    speeds_.owe();
  }
  if (!request_.isDrained()) {
    // The board may hear although it is not heard: its zero does not wait for that.
    if (speeds_.isOwed() && !speeds_.drives(now)) send(Command::kSetRobotSpeed, robolink::encodeCoordinate({}));
    return ask(now, Command::kGetSystemInfo);
  }
  if (requestDrive(now) || requestOnce(now)) return;
  if (const auto command = schedule_.next(now, sinks_.imu != nullptr, sinks_.speeds != nullptr)) ask(now, *command);
}

bool HandsfreeBoard::requestDrive(Timestamp now) {
  const std::optional<Twist2> speed = speeds_.due(now);
  if (!speed) return false;
  ask(now, Command::kSetRobotSpeed, encodeTriple({speed->vx, speed->vy, speed->omega}));
  return true;
}

/// What is asked now and then: the board's idea of its chassis, and counters from zero before they get coarse.
bool HandsfreeBoard::requestOnce(Timestamp now) {
  if (schedule_.chassisDue(now)) {
    ask(now, Command::kReadChassisParameters);
    return true;
  }
  if (time_.isFrozen() || speeds_.isOwed() || !mileage_.isCoarse(now) || !schedule_.clearDue(now)) return false;
  ask(now, Command::kClearCoordinateData);
  return true;
}

void HandsfreeBoard::sendCoordinate() { send(Command::kShakingHands, encodeTriple(host_.coordinate())); }

void HandsfreeBoard::ask(Timestamp now, Command command, std::span<const std::uint8_t> payload) {
  send(command, payload);
  request_.sent(command, now);
}

void HandsfreeBoard::send(Command command, std::span<const std::uint8_t> payload) {
  std::array<std::uint8_t, robolink::kMaxFrame> frame;
  const std::size_t size = robolink::encodeFrame(robolink::kMaster, robolink::kSlave, command, payload, frame);
  port_.write({frame.data(), size});
}

}  // namespace slam
