// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/serial_lidar.hpp"

#include <utility>

#include "drivers/tcp_port.hpp"

namespace slam {
namespace {

/// @param stride one of so many measurements is used
Problem thinning(int stride) {
  if (stride < 2) return {};
  return stride == 2 ? problem::kLidarHalved : problem::kLidarThinned;
}

/// Of a lidar on the network: neither plug nor baud rate.
Problem overTcp(const Problem& problem, const std::string& path) {
  if (problem.is(problem::kPortGone)) return {problem::kTcpClosed, {}, {path}};
  for (const ProblemKind* kind : {&problem::kLidarUnheard, &problem::kLidarNoPackets, &problem::kLidarUndecoded,
                                  &problem::kLidarUnanswered, &problem::kLidarSilent}) {
    if (problem.is(*kind)) return {problem::kTcpSilent, {}, {path}};
  }
  return problem;
}

}  // namespace

SerialLidar::SerialLidar(const SerialLidarConfig& config, std::unique_ptr<LidarUnit> unit, Clock now, Sink sink,
                         PortOpener open)
    : config_(config),
      unit_(std::move(unit)),
      now_(now),
      sink_(std::move(sink)),
      open_(std::move(open)),
      wrong_device_(PortOf::kLidar, config.port, config.baud, open_, config.line_device) {
  report_scan_ = [this](const LaserScan& scan) { report(scan); };
}

void SerialLidar::report(const LaserScan& scan) {
  status_.set(DeviceState::kStreaming, warning_ ? warning_ : thinning(reader_->scans().stride()));
  status_.thinned.store(thinned_before_ + reader_->scans().thinned(), std::memory_order_relaxed);
  status_.countSample(reader_->lastArrival());
  sink_(scan);
}

bool SerialLidar::fail(DeviceState state, const Problem& why) {
  status_.set(state, isTcp(config_.port) ? overTcp(why, config_.port) : why);
  stop();
  return false;
}

bool SerialLidar::connect(const std::atomic<bool>& cancel) {
  status_.setOpening(problem::kOpening);
  stop();
  if (!unit_ && !findUnit(cancel)) return false;
  OpenedPort port = open_(config_.port, config_.baud);
  if (!port.stream) {
    wrong_device_.forget();
    return fail(DeviceState::kAbsent, port.problem);
  }
  stream_ = std::move(port.stream);
  LidarUnit::Begun begun = unit_->begin(*stream_, cancel, wrong_device_);
  if (begun.state != DeviceState::kStreaming) {
    fail(begun.state, begun.unanswered ? wrong_device_.found(begun.problem) : begun.problem);
    if (begun.unanswered && !isTcp(config_.port)) findOtherDevice(cancel, begun.problem);
    if (begun.unanswered && config_.find) unit_.reset();  // another one may be there now
    return false;
  }
  warning_ = begun.problem;
  if (config_.find && !isTcp(config_.port))
    begun.identity = "found at " + std::to_string(config_.baud) + " bit/s: " + begun.identity;
  status_.identify(begun.identity);
  status_.setOpening(problem::kLidarSpinsUp);
  reader_.emplace(now_, std::move(begun.start));
  return true;
}

bool SerialLidar::findUnit(const std::atomic<bool>& cancel) {
  status_.setOpening(problem::kLidarSearched);
  FoundUnit found = config_.find(open_, cancel);
  if (!found.unit) {
    const bool other = found.is_open && !cancel;
    if (!other) wrong_device_.forget();
    fail(other ? DeviceState::kFault : DeviceState::kAbsent, wrong_device_.found(found.problem));
    if (other && !isTcp(config_.port)) findOtherDevice(cancel, found.problem);
    return false;
  }
  unit_ = std::move(found.unit);
  config_.baud = found.baud;
  wrong_device_ = WrongDevice(PortOf::kLidar, config_.port, found.baud, open_, found.line_device);
  return true;
}

/// Once for a port: what was found is remembered until the lidar answers, or the port has gone.
void SerialLidar::findOtherDevice(const std::atomic<bool>& cancel, const Problem& unanswered) {
  constexpr Duration kLook = std::chrono::milliseconds(10);
  wrong_device_.ask();
  while (wrong_device_.tick(now_()) && !cancel) wrong_device_.rest(kLook);
  status_.set(DeviceState::kFault, wrong_device_.found(unanswered));
}

bool SerialLidar::poll(Duration timeout) {
  if (!stream_ || !reader_) return false;
  const LidarReader::Ending ending = reader_->read(*stream_, timeout, report_scan_);
  status_.rejects.store(rejects_before_ + reader_->scans().rejects(), std::memory_order_relaxed);
  if (ending == LidarReader::Ending::kNone) return true;
  lost_();
  switch (ending) {
    case LidarReader::Ending::kClosed:
      return fail(DeviceState::kAbsent, problem::kPortGone);
    case LidarReader::Ending::kRestarted:
      return fail(DeviceState::kStale, problem::kLidarRestarted);
    case LidarReader::Ending::kHeadStands:
      return fail(DeviceState::kStale, problem::kLidarHeadStands);
    default:
      break;
  }
  const Problem why = unit_->silence(*reader_);
  return fail(why.is(problem::kPortGone) ? DeviceState::kAbsent : DeviceState::kStale, why);
}

void SerialLidar::stop() {
  if (!stream_) return;
  unit_->end();
  if (reader_) {
    rejects_before_ += reader_->scans().rejects();
    thinned_before_ += reader_->scans().thinned();
  }
  reader_.reset();
  stream_.reset();
}

}  // namespace slam
