// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/base_thread.hpp"
#include "app/bus_thread.hpp"
#include "app/config.hpp"
#include "app/devices.hpp"
#include "app/estimator_thread.hpp"
#include "app/exchange.hpp"
#include "app/graph_thread.hpp"
#include "app/health_parts.hpp"
#include "app/mapper_thread.hpp"
#include "app/storage_report.hpp"
#include "runtime/job_thread.hpp"
#include "runtime/watchdog.hpp"

namespace slam {

/// Owns all threads of the daemon. Logs what the real-time threads may not, feeds systemd's watchdog only while every
/// thread is alive, sends SLAM_HEALTH, and stops all on SIGINT, SIGTERM or SIGHUP, the wheels first.
class Supervisor {
 public:
  /// @throws std::system_error when the system has no thread or descriptor left
  explicit Supervisor(const Config& config);
  ~Supervisor();

  /// Those that end slamd in order. SIGHUP only where it is not ignored already, as by nohup.
  static sigset_t stopSignals();
  /// Runs until one of them. The calling thread must have them blocked. @return exit code
  int run();

 private:
  struct Watched {
    Worker* worker;
    SilenceLimits limits;
    DeviceStatus* connects = nullptr;  // it is silent for long while this device is not streaming
    bool warned = false;
  };
  /// Something that is kept on a disk.
  struct Stored {
    const char* name;
    std::function<StorageReport(Timestamp)> report;
    bool hangs = false;                    // the disk did when it was looked at last
    std::optional<Timestamp> logged = {};  // that it does
    bool logged_now = false;               // of this time
  };

  void start();
  bool stop();  ///< false: the map was not saved
  void watch(Timestamp now);
  void watchDisks(Timestamp now);
  std::string storageWords(Timestamp now) const;  ///< for the summary: what is not stored
  void logDeviceChanges();
  void logLocalisation();
  void logLink();
  void warnOnce();
  void measureRates(Timestamp now);
  void measureDiskSpace();
  void sendHealth(Timestamp now);
  double diskFree() const;  // [MB] where maps and records are written, the least; -1: not known
  std::string statusReason(const WatchedDevice& device) const;
  std::string summary(Timestamp now) const;

  const Config config_;
  WallClock clock_;
  Exchange exchange_;
  std::unique_ptr<BaseThread> base_;
  std::unique_ptr<LidarThread> lidar_;
  std::unique_ptr<DepthThread> depth_;
  GraphThread graph_;  // before the estimator: it loads the map
  EstimatorThread estimator_;
  MapperThread mapper_;
  BusThread bus_;
  std::vector<WatchedDevice> devices_;
  std::vector<Watched> watched_;
  std::vector<Stored> stored_;
  std::string not_locked_;  // memory, in words
  Watchdog watchdog_;       // its threads are those of watched_
  PoseSnapshot snapshot_;
  LocalisationState logged_localisation_ = LocalisationState::kInitialising;
  Timestamp started_{}, next_health_{};
  static constexpr Duration kHealthPeriod = std::chrono::seconds(1);
  Timestamp measured_{};                 // when rates were
  bool device_changed_ = false;          // or the link, since the last health message
  double cpu_ = 0.0;                     // [s] when rates were measured last
  double cpu_share_ = 0.0;               // [1] of a core, then
  std::atomic<double> disk_free_{-1.0};  // [MB] as diskFree()
  JobThread disk_space_{"disk space"};   // a network disk may keep who asks waiting
  std::array<bool, kSensorFaults> fault_logged_{};
  bool recorder_hangs_ = false, clock_step_logged_ = false;
  LinkState link_logged_ = LinkState::kOpening;
  const char* base_finding_ = "";  // static words; what was logged
};

}  // namespace slam
