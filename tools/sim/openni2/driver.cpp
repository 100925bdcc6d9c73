// SPDX-License-Identifier: BSD-3-Clause
// OpenNI2 driver of the camera that slam-sim --devices serves, as the plug-in interface of OpenNI2 2.2 asks
// (Driver/OniDriverAPI.h). The environment's SLAM_SIM_DEVICES names the directory; without it there is no camera.
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <thread>
#include <unistd.h>

#include "tools/sim/openni2/simulated_device.hpp"

// OniDriverAPI.h takes these from a library that is not packaged.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete pointer

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
constexpr auto kWatchPeriod = 200ms;

/// Announces the camera while its socket is served.
class SimulatedDriver : public oni::driver::DriverBase {
 public:
  explicit SimulatedDriver(OniDriverServices* services) : DriverBase(services) {
    if (const char* directory = std::getenv("SLAM_SIM_DEVICES")) path_ = std::string(directory) + "/depth";
    std::snprintf(info_.uri, sizeof info_.uri, "slam-sim:%s", path_.c_str());
    std::snprintf(info_.vendor, sizeof info_.vendor, "SlamSim");
    std::snprintf(info_.name, sizeof info_.name, "simulated Xtion");
  }
  ~SimulatedDriver() override { SimulatedDriver::shutdown(); }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback state_changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, state_changed, cookie);
    if (path_.empty() || watcher_.joinable()) return ONI_STATUS_OK;
    stopping_ = false;
    watch();  // once now, so that the camera is enumerated after initialize()
    watcher_ = std::thread([this] { run(); });
    return ONI_STATUS_OK;
  }

  void shutdown() override {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    if (watcher_.joinable()) watcher_.join();
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    if (path_.empty() || std::string(uri) != info_.uri) return nullptr;
    return new SimulatedDevice(path_, [this] { reportLost(); });
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
      wake_.wait_for(lock, kWatchPeriod, [this] { return stopping_ || lost_; });
      if (stopping_) return;
      lock.unlock();
      watch();
      lock.lock();
    }
  }

  /// A camera that is announced is only asked for again when its stream broke or its socket is gone.
  void watch() {
    bool lost = false;
    {
      const std::lock_guard lock(mutex_);
      std::swap(lost, lost_);
    }
    if (announced_ && (lost || access(path_.c_str(), F_OK) != 0)) {
      announced_ = false;
      deviceDisconnected(&info_);
    } else if (!announced_ && isServed(path_)) {
      announced_ = true;
      deviceConnected(&info_);
    }
  }

  void reportLost() {
    {
      const std::lock_guard lock(mutex_);
      lost_ = true;
    }
    wake_.notify_all();
  }

  std::string path_;  // of the socket; empty: no camera
  OniDeviceInfo info_{};
  bool announced_ = false;  // of the watcher, after initialize()
  std::mutex mutex_;        // guards the flags below
  std::condition_variable wake_;
  bool stopping_ = false, lost_ = false;
  std::thread watcher_;
};

}  // namespace
}  // namespace slam::sim

ONI_EXPORT_DRIVER(slam::sim::SimulatedDriver)
