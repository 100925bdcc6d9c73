// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "core/samples.hpp"
#include "drivers/device_status.hpp"
#include "drivers/imu/iio_device.hpp"

namespace slam {

struct IioImuConfig {
  std::string device = {};  ///< folder, or name of the chip
  double rate = 100.0;      ///< [Hz] at which it is read
  std::filesystem::path root = IioDevice::kRoot;
};

/// Owns an IMU that the kernel reads. A thread of its own polls the attributes, since that waits for the bus; the
/// owner's tick takes what has come without waiting.
class IioImu {
 public:
  using Sink = std::function<void(const ImuSample&)>;
  using Clock = Timestamp (*)();

  IioImu(IioImuConfig config, Clock now, Sink sink);
  ~IioImu() { stop(); }
  IioImu(const IioImu&) = delete;
  IioImu& operator=(const IioImu&) = delete;

  void tick();
  /// Waits for the reading that is under way.
  void stop();
  DeviceStatus& status() { return status_; }

 private:
  /// What the reading thread has come to: a sample, or a problem.
  struct Event {
    ImuSample sample{};
    Problem problem{};
  };
  /// From one thread to one other, neither of which waits; what finds no room is lost.
  class Events {
   public:
    void push(const Event& event) {
      const std::uint32_t at = written_.load(std::memory_order_relaxed);
      if (at - read_.load(std::memory_order_acquire) == events_.size()) return;
      events_[at % events_.size()] = event;
      written_.store(at + 1, std::memory_order_release);
    }
    template <typename Take>
    void drain(Take&& take) {
      for (std::uint32_t at = read_.load(std::memory_order_relaxed); at != written_.load(std::memory_order_acquire);
           read_.store(++at, std::memory_order_release))
        take(events_[at % events_.size()]);
    }

   private:
    std::array<Event, 32> events_{};
    std::atomic<std::uint32_t> written_{0}, read_{0};
  };

  void work();
  void take(const Event& event, Timestamp now);

  const IioImuConfig config_;
  Clock now_;
  Sink sink_;
  DeviceStatus status_;
  Events events_;
  ImuSample last_{};
  Timestamp event_{}, changed_{};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace slam
