// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/config_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "config/file_edit.hpp"
#include "config/loader.hpp"
#include "tools/files.hpp"

namespace slam::config_writer_test {
namespace {

namespace fs = std::filesystem;
using test::contentOf;

Config lidarAt(double x) {
  Config config;
  config.front_end.lidar.T_base_lidar.x = x;
  return config;
}

TEST(WriteConfig, KeepsTheOldFileAndItsRights) {
  const test::Folder folder;
  const fs::path file = folder.write("slamd.toml", "# old\n");
  chmod(file.c_str(), 0640);
  const Config wanted = lidarAt(0.5);
  const std::string text = editedConfig("# old\n", wanted);
  EXPECT_EQ(writeConfig(file, text, wanted), folder / "slamd.toml.old");
  EXPECT_EQ(contentOf(file), text);
  EXPECT_EQ(contentOf(folder / "slamd.toml.old"), "# old\n");
  EXPECT_EQ(static_cast<int>(fs::status(file).permissions()), 0640);
  EXPECT_EQ(writeConfig(file, text, wanted), folder / "slamd.toml.old2");
  EXPECT_FALSE(fs::exists(folder / "slamd.toml.new"));
}

TEST(WriteConfig, WritesANewFileIntoItsFolder) {
  const test::Folder folder;
  const Config wanted = lidarAt(0.5);
  EXPECT_TRUE(writeConfig(folder / "robots" / "anna.toml", editedConfig("", wanted), wanted).empty());
  EXPECT_EQ(loadConfig(folder / "robots" / "anna.toml").front_end.lidar.T_base_lidar.x, 0.5);
}

TEST(WriteConfig, LeavesTheFileAloneThatIsNotReadBackToTheSame) {
  const test::Folder folder;
  const fs::path file = folder.write("slamd.toml", "# old\n");
  EXPECT_NE(test::refusalOf([&] { writeConfig(file, "[lidar]\nx = 0.4\n", lidarAt(0.5)); }), "");
  EXPECT_NE(test::refusalOf([&] { writeConfig(file, "[lidar\n", lidarAt(0.5)); }), "");
  EXPECT_EQ(contentOf(file), "# old\n");
  EXPECT_FALSE(fs::exists(folder / "slamd.toml.new"));
  EXPECT_FALSE(fs::exists(folder / "slamd.toml.old"));
}

TEST(WriteConfig, WritesThroughALink) {
  const test::Folder folder;
  folder.write("real.toml", "# old\n");
  fs::create_symlink(folder / "real.toml", folder / "slamd.toml");
  writeConfig(folder / "slamd.toml", editedConfig("", lidarAt(0.5)), lidarAt(0.5));
  EXPECT_TRUE(fs::is_symlink(folder / "slamd.toml"));
  EXPECT_EQ(loadConfig(folder / "real.toml").front_end.lidar.T_base_lidar.x, 0.5);
}

TEST(ChangedSettings, NamesKeyAndBothValuesButNoPassword) {
  Config after = lidarAt(0.25);
  after.web.token = "0123456789abcdef";
  EXPECT_THAT(changedSettings({}, after), testing::ElementsAre("lidar.x = 0.25, was 0.0", "web.token is another one"));
  EXPECT_THAT(changedSettings(after, after), testing::IsEmpty());
}

}  // namespace
}  // namespace slam::config_writer_test
