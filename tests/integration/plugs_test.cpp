// SPDX-License-Identifier: BSD-3-Clause
// Devices that are not there when slamd starts, and plugs pulled together.
#include <gtest/gtest.h>

#include "integration/live_faults.hpp"

namespace slam::plugs_test {
namespace {

using namespace std::chrono_literals;
using test::Clock;
using test::kPatience;

struct Plug {
  const char* device;  // of slam-sim
  const char* status;  // in SLAM_HEALTH
};
constexpr std::array<Plug, 4> kPlugs = {{{"lidar", "lidar"}, {"depth", "depth"}, {"board", "base"}, {"imu", "imu"}}};

class Plugs : public test::LiveFaults {
 protected:
  void SetUp() override {
    LiveFaults::SetUp();
    ASSERT_TRUE(listener_.good());
    startSimulator("600", "meeting-room", {"--speed", "0.1"});
  }
  void pull(const Plug& plug) const { inject(plug.device, "unplug 1"); }
  void plugIn(const Plug& plug) const { inject(plug.device, "unplug 0"); }

  bool isMissed(const Plug& plug) {
    const auto d = device(plug.status);
    return d && d->state != kStreaming && !d->reason.empty() &&
           summary().find(std::string(plug.status) + ": ") != std::string::npos;
  }
  /// @return [s] until SLAM_HEALTH says that all of `plugs` are missed; negative: never
  double untilMissed(const std::vector<Plug>& plugs) {
    return secondsUntilAll(plugs, [this](const Plug& plug) { return isMissed(plug); });
  }
  /// The same of devices that stream.
  double untilStreaming(const std::vector<Plug>& plugs) {
    return secondsUntilAll(plugs, [this](const Plug& plug) { return streams(plug.status); });
  }
  template <typename Condition>
  double secondsUntilAll(const std::vector<Plug>& plugs, Condition&& condition) {
    const auto begin = Clock::now();
    const bool held = listener_.until([&] { return poseState(), std::all_of(plugs.begin(), plugs.end(), condition); },
                                      kPatience * 10s);
    return held ? std::chrono::duration<double>(Clock::now() - begin).count() : -1.0;
  }

  void expectWithin(double seconds, double limit, const char* what) {
    EXPECT_GE(seconds, 0.0) << what << ": " << summary() << "\n" << daemonLog();
    if (!test::kSanitized) {
      EXPECT_LT(seconds, limit) << what << ": " << summary();
    }
    std::printf("  %s after %.2f s\n", what, seconds);
  }
};

TEST_F(Plugs, AnyMayBeMissingAtTheStart) {
  for (unsigned mask = 1; mask < 1U << kPlugs.size(); ++mask) {
    std::vector<Plug> missing, present;
    std::string names = "without";
    for (std::size_t i = 0; i < kPlugs.size(); ++i) {
      ((mask >> i & 1U) != 0 ? missing : present).push_back(kPlugs[i]);
      if ((mask >> i & 1U) != 0) names += std::string(" ") + kPlugs[i].device;
    }
    SCOPED_TRACE(names);
    std::printf("%s\n", names.c_str());
    for (const Plug& plug : missing) pull(plug);
    listener_.listenFor(300ms);
    listener_.clear();
    startDaemon({"imu.driver='hfi'"});
    expectWithin(untilMissed(missing), 3.0, "said");
    expectWithin(untilStreaming(present), 5.0, "the others stream");
    const bool lidar = (mask & 1U) == 0;
    if (lidar) {
      EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised; }, kPatience * 5s)) << summary();
    } else {
      EXPECT_NE(poseState(), kLocalised) << "by the wheels alone, at best degraded";
    }
    for (const Plug& plug : missing) plugIn(plug);
    expectWithin(untilStreaming(missing), 3.1, "stream");
    EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised; }, kPatience * 5s)) << summary();
    slamd_->signal(SIGTERM);
    EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  }
}

TEST_F(Plugs, AnyTwoMayBePulledAtOnceAndReturnInAnyOrder) {
  startDaemon({"imu.driver='hfi'"});
  expectWithin(untilStreaming({kPlugs.begin(), kPlugs.end()}), 6.0, "all stream");
  std::vector<std::pair<std::string, std::size_t>> begins;  // among the poses, of each two
  for (const Plug& first : kPlugs) {
    for (const Plug& second : kPlugs) {
      if (&first == &second) continue;
      begins.emplace_back(std::string(first.device) + " before " + second.device, poses_.size());
      SCOPED_TRACE(begins.back().first);
      std::printf("%s\n", begins.back().first.c_str());
      ASSERT_TRUE(listener_.until([&] { return poseState() == kLocalised; }, kPatience * 10s)) << summary();
      pull(first);
      pull(second);
      expectWithin(untilMissed({first, second}), 1.1, "said");
      worstStateFor(700ms);
      plugIn(first);
      expectWithin(untilStreaming({first}), 3.1, "the first streams");
      plugIn(second);
      expectWithin(untilStreaming({second}), 3.1, "the second streams");
    }
  }
  EXPECT_TRUE(listener_.until([&] { return poseState() == kLocalised; }, kPatience * 10s)) << summary();
  begins.emplace_back("", poses_.size());
  const Trajectory truth = endDrive();
  for (std::size_t i = 0; i + 1 < begins.size(); ++i) {
    const Compared compared = compare(truth, begins[i].second, begins[i + 1].second, kLocalised);
    std::printf("%s: off by at most %.3f m in %d poses localised\n", begins[i].first.c_str(), compared.worst,
                compared.poses);
    EXPECT_LT(compared.worst, 0.1) << "[m] " << begins[i].first;
    EXPECT_GT(compared.poses, 20) << begins[i].first;
  }
}

}  // namespace
}  // namespace slam::plugs_test
