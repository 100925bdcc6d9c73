// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <cstdint>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <slam/ack_t.hpp>
#include <slam/command_t.hpp>
#include <slam/config_t.hpp>
#include <slam/counter_t.hpp>
#include <slam/depth_t.hpp>
#include <slam/device_health_t.hpp>
#include <slam/drive_t.hpp>
#include <slam/health_t.hpp>
#include <slam/imu_t.hpp>
#include <slam/map_edit_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problem_t.hpp>
#include <slam/problems_t.hpp>
#include <slam/scan_t.hpp>
#include <slam/stage_health_t.hpp>
#include <slam/wheels_t.hpp>
#include <string>

#include "build_paths.hpp"

namespace slam::lcmtypes_test {
namespace {

template <typename... Messages>
std::map<std::string, std::uint64_t> fingerprints() {
  return {{Messages::getTypeName(), static_cast<std::uint64_t>(Messages::getHash())}...};
}

std::map<std::string, std::uint64_t> allFingerprints() {
  return fingerprints<bot_core::planar_lidar_t, bot_core::pose_t, ack_t, command_t, config_t, counter_t, depth_t,
                      device_health_t, drive_t, health_t, imu_t, map_edit_t, map_meta_t, map_tile_t, odometry_t,
                      pose_estimate_t, problem_t, problems_t, scan_t, stage_health_t, wheels_t>();
}

TEST(LcmTypes, BorrowedTypesHaveTheFingerprintsOfExistingViewers) {
  EXPECT_EQ(static_cast<std::uint64_t>(bot_core::pose_t::getHash()), 0x2e16efb052b0105eU);
  EXPECT_EQ(static_cast<std::uint64_t>(bot_core::planar_lidar_t::getHash()), 0xe3d17423180b5e8dU);
}

TEST(LcmTypes, NoTwoHaveTheSameFingerprint) {
  std::map<std::uint64_t, std::string> seen;
  for (const auto& [name, fingerprint] : allFingerprints()) {
    const auto [earlier, is_new] = seen.emplace(fingerprint, name);
    EXPECT_TRUE(is_new) << name << " has the field list of " << earlier->second;
  }
}

TEST(LcmTypes, EveryFileIsInTheFingerprintTest) {
  const std::filesystem::path folder = std::filesystem::path(SLAMD_SOURCE_DIR) / "daemon/lcmtypes";
  const auto files = std::count_if(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator{},
                                   [](const auto& entry) { return entry.path().extension() == ".lcm"; });
  EXPECT_EQ(static_cast<std::size_t>(files), allFingerprints().size()) << "add the new type to allFingerprints()";
}

}  // namespace
}  // namespace slam::lcmtypes_test
