// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_sampler.hpp"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tools/sim/log_mode.hpp"

namespace slam::sim::depth_sampler_test {
namespace {

using namespace std::chrono_literals;

TEST(DepthSampler, GivesTenImagesASecondOfADriveInLogMode) {
  const auto file = std::filesystem::path(testing::TempDir()) / ("sampler_" + std::to_string(getpid()) + ".lcm");
  std::vector<Timestamp> stamps;
  std::size_t seen = 0;
  writeLog({.scene = "people", .seconds = 5.0}, file, [&](const DepthImage& image, const Pose2&) {
    stamps.push_back(image.stamp);
    seen +=
        static_cast<std::size_t>(std::count_if(image.depth.begin(), image.depth.end(), [](auto d) { return d > 0; }));
  });
  std::filesystem::remove(file);
  ASSERT_NEAR(static_cast<double>(stamps.size()), 50.0, 1.0);
  for (std::size_t i = 1; i < stamps.size(); ++i) EXPECT_EQ(stamps[i] - stamps[i - 1], 100ms);
  EXPECT_GT(seen, stamps.size() * 320U * 240U / 2U);
}

}  // namespace
}  // namespace slam::sim::depth_sampler_test
