// SPDX-License-Identifier: BSD-3-Clause
#include "config/service_reach.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/loader.hpp"
#include "tools/files.hpp"

namespace slam::service_reach_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

class ServiceReachTest : public testing::Test {
 protected:
  void unit(const std::string& text) const { file("lib/systemd/system/slamd.service", text); }
  void dropIn(const std::string& name, const std::string& text) const {
    file("etc/systemd/system/slamd.service.d/" + name, text);
  }
  void file(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder / name).parent_path());
    folder.write(name, text);
  }
  /// Of the service with store.directory there; empty: it may be used.
  std::string problemOf(const std::string& directory) const {
    Config config;
    config.store.directory = directory;
    const auto problems = ServiceReach(folder / "").problemsOf(config);
    return problems.empty() ? "" : problems[0].what + "; " + problems[0].fix;
  }
  static std::string delivered() {
    return test::contentOf(std::filesystem::path(SLAMD_SOURCE_DIR) / "systemd/slamd.service.in");
  }

  const test::Folder folder;
};

TEST_F(ServiceReachTest, ReadsAsWhomTheServiceRunsAndItsLimits) {
  for (const bool installed : {false, true}) {  // what is known without the unit is what the unit says
    if (installed) unit(delivered());
    const ServiceAccount account = ServiceReach(folder / "").account();
    EXPECT_EQ(account.user + " " + account.group, "slamd slamd");
    EXPECT_THAT(account.further_groups, testing::ElementsAre("dialout", "video"));
    EXPECT_EQ(account.priority_limit + " " + account.lock_limit, "95 infinity");
    EXPECT_FALSE(account.realtime_refused);
    EXPECT_EQ(ServiceReach(folder / "").workingDirectory(), "/var/lib/slamd");
  }
  dropIn("robot.conf", "[Service]\nUser=robot\nSupplementaryGroups=\nSupplementaryGroups=plugdev\nLimitMEMLOCK=64M\n");
  const ServiceAccount account = ServiceReach(folder / "").account();
  EXPECT_EQ(account.user, "robot");
  EXPECT_EQ(account.lock_limit, "64M");
  EXPECT_THAT(account.further_groups, testing::ElementsAre("plugdev"));
  unit("[Service]\nExecStart=slamd\n");
  EXPECT_EQ(ServiceReach(folder / "").account().priority_limit, "0");
}

TEST_F(ServiceReachTest, OfTheDeliveredUnitIsItsStateDirectory) {
  for (const bool installed : {false, true}) {  // what is known without the unit is what the unit says
    if (installed) unit(delivered());
    EXPECT_EQ(problemOf(""), "");
    for (const char* good :
         {"/var/lib/slamd", "/var/lib/slamd/maps", "maps", "./maps", "/run/slamd/maps", "/var/lib/other/../slamd/maps"})
      EXPECT_EQ(problemOf(good), "") << good;
    for (const char* home :
         {"/home/robot/maps", "/root", "/root/maps/", "/run/user/1000/maps", "/var/lib/../../home/x"})
      EXPECT_THAT(problemOf(home), AllOf(HasSubstr("slamd.service cannot reach /"),
                                         HasSubstr("use a path below /var/lib/slamd, or run sudo systemctl edit slamd"),
                                         HasSubstr("ProtectHome=tmpfs and BindPaths=/")));
    for (const char* temporary : {"/tmp/maps", "/var/tmp/maps"})
      EXPECT_THAT(problemOf(temporary), HasSubstr("a /tmp and /var/tmp of its own"));
    for (const char* other :
         {"/srv/maps", "/", "/mnt/disk/maps", "/var/lib/slamd2", "/var/lib", "../maps", "/var/log/slamd"})
      EXPECT_THAT(problemOf(other), AllOf(HasSubstr("slamd.service may not write /"), HasSubstr("ReadWritePaths=/")))
          << other;
  }
}

TEST_F(ServiceReachTest, FollowsDropIns) {
  unit(delivered());
  dropIn("10-disk.conf", "[Service]\nReadWritePaths=-/mnt/disk \"/srv/maps\"\n# ReadWritePaths=/opt\n");
  EXPECT_EQ(problemOf("/mnt/disk/maps"), "");
  EXPECT_EQ(problemOf("/srv/maps"), "");
  EXPECT_NE(problemOf("/opt"), "");
  EXPECT_NE(problemOf("/home/robot/maps"), "");
  dropIn("20-home.conf", "[Service]\nBindPaths = /data:/home/robot/maps:norbind\n");
  EXPECT_NE(problemOf("/home/robot/maps"), "") << "ProtectHome=yes hides what is bound there, too";
  dropIn("30-home.conf", "[Service]\nProtectHome=tmpfs\n");
  EXPECT_EQ(problemOf("/home/robot/maps"), "");
  EXPECT_NE(problemOf("/home/robot/other"), "");
  dropIn("40-none.conf", "[Service]\nReadWritePaths=\nPrivateTmp=no\n");
  EXPECT_NE(problemOf("/mnt/disk/maps"), "");
  EXPECT_THAT(problemOf("/tmp/maps"), HasSubstr("may not write"));
  dropIn("50-all.conf", "[Service]\nProtectSystem=full\nProtectHome=no\n");
  for (const char* path : {"/mnt/disk/maps", "/tmp/maps", "/home/robot/other"}) EXPECT_EQ(problemOf(path), "");
}

TEST_F(ServiceReachTest, IsThatOfAUnitOfThePersonsOwn) {
  unit(delivered());
  file("etc/systemd/system/slamd.service", "[Service]\nExecStart=/opt/slamd\nProtectHome=read-only\n");
  EXPECT_EQ(problemOf("/srv/maps"), "");
  EXPECT_THAT(problemOf("/home/robot/maps"), HasSubstr("may not write"));
}

TEST_F(ServiceReachTest, AsksOfEachPathWhatIsDoneThere) {
  Config config;
  config.store.map = "kitchen";
  config.depth_device.uri = "";
  EXPECT_THAT(ServiceReach(folder / "").problemsOf(config), IsEmpty());
  config.store.map = "/srv/maps/kitchen.yaml";  // reading is free
  config.depth_device.uri = "/srv/camera.oni";
  EXPECT_THAT(ServiceReach(folder / "").problemsOf(config), IsEmpty());
  config.store.map = "/home/robot/kitchen.yaml";
  config.depth_device.uri = "/home/robot/camera.oni";
  config.store.directory = config.output.map = config.output.record = config.depth_device.record =
      config.runtime.socket = config.log.directory = "/home/robot/out/x.y";
  std::vector<std::string> keys;
  for (const auto& problem : ServiceReach(folder / "").problemsOf(config)) {
    keys.emplace_back(problem.key);
    const bool is_folder = keys.back() == "store.directory" || keys.back() == "log.directory",
               reads = keys.back() == "store.map" || keys.back() == "depth.uri";
    EXPECT_THAT(problem.fix, HasSubstr(is_folder ? "BindPaths=/home/robot/out/x.y into"
                                       : reads   ? "BindPaths=/home/robot into"
                                                 : "BindPaths=/home/robot/out into"));
  }
  EXPECT_THAT(keys, testing::UnorderedElementsAre("store.directory", "store.map", "depth.uri", "depth.record",
                                                  "runtime.socket", "log.directory", "output.map", "output.record"));
}

TEST_F(ServiceReachTest, FollowsALinkOutOfIt) {
  unit("[Service]\nProtectSystem=strict\nStateDirectory=slamd\nReadWritePaths=" + (folder / "in").string() + "\n");
  std::filesystem::create_directories(folder / "in");
  std::filesystem::create_directories(folder / "out");
  std::filesystem::create_directory_symlink(folder / "out", folder / "in/maps");
  EXPECT_EQ(problemOf(folder / "in/others"), "");
  EXPECT_THAT(problemOf(folder / "in/maps/new"), HasSubstr("may not write " + (folder / "out/new").string()));
}

TEST_F(ServiceReachTest, RefusesAConfigurationOfTheServiceAtItsLine) {
  const ServiceReach reach(folder / "");
  const std::string text = "[output]\nmap = \"/home/robot/map\"\n";
  EXPECT_NO_THROW(parseConfig(text, "slamd.toml")) << "a developer's";
  try {
    parseConfig(text, "slamd.toml", {}, &reach);
    ADD_FAILURE() << "not refused";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(),
                testing::StartsWith("slamd.toml:2:7: output.map: slamd.service cannot reach /home/robot/map"));
  }
}

TEST(IsServiceConfig, WhateverItIsCalled) {
  EXPECT_TRUE(isServiceConfig("/etc/slamd/slamd.toml"));
  EXPECT_TRUE(isServiceConfig("/etc/../etc/slamd/./slamd.toml"));
  EXPECT_FALSE(isServiceConfig("slamd.toml"));
  EXPECT_FALSE(isServiceConfig("/etc/slamd/other.toml"));
}

}  // namespace
}  // namespace slam::service_reach_test
