// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <numeric>
#include <optional>
#include <poll.h>
#include <slam/health_t.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "build_paths.hpp"
#include "bus/channels.hpp"
#include "bus/udpm/lc02.hpp"
#include "bus/udpm/multicast_receiver.hpp"
#include "support/process.hpp"

// slamd as a user runs it: the simulator's byte-level devices on one side, the real liblcm over UDP on the other.
namespace slam::test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

inline const std::string kBin = SLAMD_BINARY_DIR;
inline const std::string kConfig = SLAMD_SIM_CONFIG;
inline const std::string kUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // several times slower: rates are asked for with more patience
#else
constexpr bool kSanitized = false;
#endif
#if defined(__SANITIZE_THREAD__)
constexpr bool kCamera = false;  // OpenNI2 is not instrumented, and finds no driver of this build
#else
constexpr bool kCamera = true;
#endif
constexpr int kPatience = kSanitized ? 3 : 1;

/// Counts messages by channel and keeps the last of each. Only sends by liblcm, whose receiver ends the process when a
/// test sends what a hostile program might; lcm-logger is there to read as other programs do.
class Listener {
 public:
  explicit Listener() : lcm_(kUrl) { receiver_.join(); }

  bool good() { return lcm_.good() && receiver_.descriptor() >= 0; }
  lcm::LCM& lcm() { return lcm_; }

  /// Listens until the condition holds. @return false when it does not by the deadline
  template <typename Condition>
  bool until(Condition&& condition, std::chrono::milliseconds limit) {
    const auto end = Clock::now() + limit;
    while (!condition()) {
      if (Clock::now() > end) return false;
      listenOnce(50);
    }
    return true;
  }
  /// Takes one message at most. @param wait [ms] for it
  void listenOnce(int wait) {
    auto datagram = receiver_.next();
    if (!datagram) {
      pollfd waiting{receiver_.descriptor(), POLLIN, 0};
      ::poll(&waiting, 1, wait);
      datagram = receiver_.next();
    }
    if (datagram) take(*datagram);
  }
  void listenFor(std::chrono::milliseconds time) {
    until([] { return false; }, time);
  }

  int count(const std::string& channel) { return counts_[channel]; }
  void forget() {
    counts_.clear();
    stamps_.clear();
  }
  /// [s] between messages, by the stamp that is the first field of each.
  double medianInterval(const std::string& channel) {
    std::vector<std::int64_t> intervals = stamps_[channel];
    std::adjacent_difference(intervals.begin(), intervals.end(), intervals.begin());
    if (intervals.size() < 2) return 0.0;
    const auto middle = intervals.begin() + 1 + static_cast<std::ptrdiff_t>(intervals.size() - 1) / 2;
    std::nth_element(intervals.begin() + 1, middle, intervals.end());
    return 1e-6 * static_cast<double>(*middle);
  }
  /// Forgets the messages, too.
  void clear() {
    forget();
    data_.clear();
  }

  template <typename Message>
  std::optional<Message> last(const std::string& channel) {
    const auto at = data_.find(channel);
    Message message{};
    if (at == data_.end()) return std::nullopt;
    const int size = static_cast<int>(at->second.size());
    return message.decode(at->second.data(), 0, size) == size ? std::optional(message) : std::nullopt;
  }
  std::size_t largest() const { return largest_; }

 private:
  void take(std::span<const std::uint8_t> datagram) {
    const Packet packet = parsePacket(datagram);
    if (packet.kind != Packet::kMessage) return;
    const std::string channel(packet.channel);
    ++counts_[channel];
    data_[channel].assign(packet.data.begin(), packet.data.end());
    if (packet.data.size() >= 16) {  // behind the fingerprint, the highest byte first
      std::uint64_t stamp = 0;
      for (std::size_t i = 8; i < 16; ++i) stamp = stamp << 8 | packet.data[i];
      stamps_[channel].push_back(static_cast<std::int64_t>(stamp));
    }
    largest_ = std::max(largest_, packet.data.size());
  }

  lcm::LCM lcm_;
  MulticastReceiver receiver_{parseUdpmUrl(kUrl)};
  std::map<std::string, int> counts_;
  std::map<std::string, std::vector<std::uint8_t>> data_;
  std::map<std::string, std::vector<std::int64_t>> stamps_;  // [us]
  std::size_t largest_ = 0;
};

class Live : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("live_") + testing::UnitTest::GetInstance()->current_test_info()->name() +
               std::to_string(getpid()));
    fs::create_directories(folder_);
    // The simulated driver of OpenNI2, as the real library finds it.
    setenv("LD_LIBRARY_PATH", (kBin + "/../lib/openni2").c_str(), 1);
    setenv("SLAM_SIM_DEVICES", (folder_ / "devices").c_str(), 1);
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // OpenNI2 never frees its drivers
  }
  void TearDown() override {
    sim_.reset();
    slamd_.reset();
    if (!HasFailure()) fs::remove_all(folder_);
  }

  void startSimulator(const std::string& seconds, const std::string& scene = "tile-rectangle",
                      const std::vector<std::string>& further = {}) {
    std::vector<std::string> command{kBin + "/slam-sim",    "--scene",   scene,
                                     "--seconds",           seconds,     "--truth",
                                     folder_ / "truth.tum", "--devices", folder_ / "devices"};
    command.insert(command.end(), further.begin(), further.end());
    sim_.emplace(command, folder_ / "sim.txt");
    const auto end = Clock::now() + 5s;
    while (!fs::exists(folder_ / "devices" / "board") && Clock::now() < end) usleep(20000);
  }
  /// @param by a program that starts it, with arguments
  void startDaemon(std::vector<std::string> settings, const std::vector<std::string>& by = {}) {
    std::vector<std::string> command = by;
    command.insert(command.end(), {kBin + "/slamd", "--config", kConfig});
    settings.push_back("lidar.port='" + (folder_ / "devices/lidar").string() + "'");
    settings.push_back("base.port='" + (folder_ / "devices/board").string() + "'");
    settings.push_back("imu.port='" + (folder_ / "devices/imu").string() + "'");
    settings.push_back("output.map='" + (folder_ / "map").string() + "'");
    if (kSanitized) settings.push_back("runtime.realtime=false");  // the sanitizers' shadow memory cannot be locked
    if (!kCamera) settings.push_back("depth.driver='none'");
    for (const std::string& setting : settings) command.insert(command.end(), {"--set", setting});
    slamd_.emplace(command, folder_ / "slamd.txt");
  }
  /// Of the last health message; empty: none has come.
  static std::string summary(Listener& listener) {
    const auto health = listener.last<health_t>(channel::kHealth);
    return health ? health->summary : "";
  }
  /// The same; -1: none has come, or it has no such counter.
  static std::int64_t counterOf(Listener& listener, const std::string& name) {
    const auto health = listener.last<health_t>(channel::kHealth);
    if (!health) return -1;
    for (const counter_t& counter : health->counters) {
      if (counter.name == name) return counter.value;
    }
    return -1;
  }
  std::string daemonLog() const { return textOf(folder_ / "slamd.txt"); }
  std::string simulatorLog() const { return textOf(folder_ / "sim.txt"); }
  static std::string textOf(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

  fs::path folder_;
  std::optional<Process> sim_, slamd_;
};

}  // namespace slam::test
