// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_imu.hpp"

#include <ctime>
#include <utility>

#include "core/plausibility.hpp"
#include "problems/devices.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kIioStale = 500ms;  // nothing that can be used
constexpr Duration kRetry = 200ms;     // between two looks for a device that is not there
constexpr int kFailures = 10;          // readings in a row: then it is looked for anew

void sleep(Duration time) {
  const timespec period{time.count() / 1'000'000'000, time.count() % 1'000'000'000};
  nanosleep(&period, nullptr);
}

}  // namespace

IioImu::IioImu(IioImuConfig config, Clock now, Sink sink)
    : config_(std::move(config)), now_(now), sink_(std::move(sink)), event_(now()), thread_([this] { work(); }) {
  status_.setOpening(Problem(problem::kWaitsForFrames, {}, {"the IMU's"}));
}

void IioImu::stop() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

/// The reading thread.
void IioImu::work() {
  const Duration period = fromSeconds(1.0 / config_.rate);
  std::optional<IioDevice> device;
  int failures = 0;
  for (Timestamp next = now_(); !ending_;) {
    if (!device) {
      Event event;
      device = IioDevice::find(config_.device, event.problem, config_.root);
      failures = 0;
      if (!device) {
        events_.push(event);
        sleep(kRetry);
        continue;
      }
      next = now_();
    }
    const Timestamp begin = now_();
    IioDevice::Reading reading;
    bool good = device->readGyro(reading);
    const Timestamp end = now_();
    good = good && device->readAccel(reading);
    failures = good ? 0 : failures + 1;
    Event event{.sample = {begin + (end - begin) / 2, reading.gyro, reading.accel}};
    if (!good) event.problem = {problem::kIioUnread, {}, {device->name()}};
    if (good && !device->hasAccel()) event.problem = Problem(problem::kImuNoAcceleration);
    events_.push(event);
    if (failures >= kFailures) device.reset();
    next = std::max(next + period, now_());
    sleep(next - now_());
  }
}

void IioImu::tick() {
  const Timestamp now = now_();
  events_.drain([&](const Event& event) { take(event, now); });
  if (now - event_ > kIioStale && status_.state == DeviceState::kStreaming)
    status_.set(DeviceState::kStale, Problem(problem::kImuSilent, {}, {"", ", and its bus"}));
}

void IioImu::take(const Event& event, Timestamp now) {
  event_ = now;
  const ImuSample& sample = event.sample;
  if (event.problem && !event.problem.is(problem::kImuNoAcceleration)) {
    const bool absent = event.problem.is(problem::kIioMissing);
    if (!absent) status_.rejects.fetch_add(1, std::memory_order_relaxed);
    return status_.set(absent ? DeviceState::kAbsent : DeviceState::kFault, event.problem);
  }
  // The chip measures at a rate of its own: what is as before is no new sample.
  const bool is_new = sample.gyro != last_.gyro || sample.accel != last_.accel;
  if (!is_new) {
    if (now - changed_ > kIioStale) status_.set(DeviceState::kStale, problem::kImuFrozen);
    return;
  }
  changed_ = now;
  last_ = sample;
  if (!isPlausible(sample)) {
    status_.rejects.fetch_add(1, std::memory_order_relaxed);
    return status_.set(DeviceState::kStale, problem::kImuSenseless);
  }
  sink_(sample);
  status_.countSample(now);
  status_.set(DeviceState::kStreaming, event.problem);
}

}  // namespace slam
