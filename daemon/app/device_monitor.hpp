// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <optional>
#include <slam/device_health_t.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/log/trouble_log.hpp"
#include "core/timestamp.hpp"
#include "drivers/device_status.hpp"
#include "frontend/interpreter/echo_watch.hpp"

namespace slam {

/// One device as the supervisor sees it, whatever thread feeds it.
struct WatchedDevice {
  std::string name;
  DeviceStatus* status = nullptr;
  double expected = 0.0;  ///< [Hz]
  bool over_lcm = false;
  std::string without = {};                       ///< what slamd does without it ...
  std::string by = {};                            ///< ... as long as this device gives samples; empty: in any case
  DeviceState seen_state = DeviceState::kAbsent;  ///< at the last look that was news ...
  Problem seen = {};                              ///< ... and the problem
  bool is_new = true;                             ///< there was none yet
  std::optional<Timestamp> opening_since = {};    ///< at the last look
  bool has_streamed = false;                      ///< at any look
  double messages = 5.0;                          ///< of health that may be sent at once because of it
  Timestamp looked{};                             ///< when that was reckoned
  std::int64_t identified = 0;                    ///< connections whose device's identity was logged
  std::int64_t samples = 0;                       ///< when rates were measured last
  double rate = 0.0;                              ///< [Hz] then
  std::int64_t rejects = 0;                       ///< the same as samples, of what was refused
  double refused = 0.0;                           ///< [1/s] then
  bool streamed = false;                          ///< then
  bool rate_valid = false;                        ///< the rate can be compared with the expected one
  bool starved = false;                           ///< slamd has too little of the CPU to receive it
};

/// Of its last sample; std::nullopt: none came yet.
std::optional<Duration> ageOf(const WatchedDevice& device, Timestamp now);
DeviceState stateOf(const WatchedDevice& device, Timestamp now);
/// @param found by its driver, or what is known better @return what is wrong with what comes from it
Problem problemOf(const WatchedDevice& device, const Problem& found, Timestamp now);
/// What the words about its problem begin with: for how long it has sent nothing; empty: it sends.
std::string silenceOf(const WatchedDevice& device, Timestamp now);
/// @param interval [s] since it was measured last @param settled slamd has run for long enough for a valid rate
void measureRate(WatchedDevice& device, double interval, bool settled, Timestamp now);

/// What the devices do, for SLAM_HEALTH and the log.
///
/// A device that tries to open is not well: what was wrong before goes on until it streams.
class DeviceMonitor {
 public:
  /// @param lidar_stuck what the estimator has found
  explicit DeviceMonitor(const std::atomic<bool>& lidar_stuck) : lidar_stuck_(lidar_stuck) {}

  void add(WatchedDevice device) { devices_.push_back(std::move(device)); }
  /// What came before counts for no rate.
  void begin();
  /// @param interval, settled as of measureRate()
  void measureRates(double interval, bool settled, Timestamp now);
  /// What the front end has found out about the lidar's echoes.
  void setEchoes(EchoWatch::Finding finding) { echoes_ = finding; }
  /// The computer gives slamd too little time: neither rate nor silence shows anything about a device.
  void setOverloaded(bool overloaded) {
    for (WatchedDevice& device : devices_) device.starved = overloaded;
  }
  /// Whether anything is new about any, so that a health message should not wait.
  bool look(Timestamp now);
  /// What is wrong with each, for the log.
  std::vector<Trouble> troubles(Timestamp now);
  /// Which device each is, and that it streams for the first time.
  std::vector<LogLine> arrivals(TroubleLog& log, Timestamp now);

  std::vector<device_health_t> health(Timestamp now) const;
  /// The same as troubles(), also of a device that opens.
  std::vector<Trouble> problems(Timestamp now) const;
  /// Whether there is such a device that gives samples.
  bool streams(const std::string& name, Timestamp now) const;
  /// What each says that it is, the same.
  std::string identities() const;
  const std::vector<WatchedDevice>& devices() const { return devices_; }

 private:
  Problem found(const WatchedDevice& device) const;

  const std::atomic<bool>& lidar_stuck_;
  EchoWatch::Finding echoes_ = EchoWatch::Finding::kNone;
  std::vector<WatchedDevice> devices_;
};

}  // namespace slam
