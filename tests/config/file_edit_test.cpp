// SPDX-License-Identifier: BSD-3-Clause
#include "config/file_edit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_values.hpp"
#include "config/loader.hpp"
#include "config/printer.hpp"

namespace slam::file_edit_test {
namespace {

using test::differences;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Config changed(Config config, const std::string& text) {
  setFrom(text, "test", config);
  return config;
}

TEST(EditedConfig, FillsTheTemplateIn) {
  const Config wanted = changed({},
                                "lidar.port = '/dev/ttyUSB1'\nlidar.x = 0.125\nmode = 'localise'\nbase.baud = 57600\n"
                                "base.counts_per_turn = 1440.0\nweb.token = '0123456789abcdef'\nlidar.mask = [[1, 2]]");
  const std::string text = editedConfig("", wanted);
  EXPECT_THAT(differences(parseConfig(text, "written"), wanted), IsEmpty());
  EXPECT_THAT(text, HasSubstr("\nx = 0.125\n"));
  EXPECT_THAT(text, HasSubstr("mounted this far ahead of the base's turning centre")) << "its comments stay";
  EXPECT_THAT(text, HasSubstr("token = \"0123456789abcdef\"")) << "the file keeps what no log does";
}

TEST(EditedConfig, ChangesWhatIsWrongAndNothingElse) {
  const std::string old =
      "# Anna's robot\n[lidar]\nport = \"/dev/ttyUSB0\"  # in front\nx = 0.05 # by ruler; \xC3\xA4\n\n[base]\n"
      "driver = 'kobuki'  # \xC3\xB6\n[imu]\ndriver = \"base\"\n";
  const Config config = parseConfig(old, "old");
  EXPECT_EQ(editedConfig(old, config), old);
  const std::string text = editedConfig(old, changed(config, "lidar.x = 0.06\nlidar.yaw = 0.1\nmap.resolution = 0.1"));
  EXPECT_EQ(text,
            "# Anna's robot\n[lidar]\nyaw = 0.1\nport = \"/dev/ttyUSB0\"  # in front\nx = 0.06 # by ruler; \xC3\xA4\n\n"
            "[base]\ndriver = 'kobuki'  # \xC3\xB6\n[imu]\ndriver = \"base\"\n\n[map]\nresolution = 0.1\n");
}

TEST(EditedConfig, WritesTheTemplateWhereAFileHasAnotherForm) {
  for (const std::string old : {"lidar.x = 0.05\n", "lidar = {x = 0.05}\n", "[lidar]\nmask = [\n[1, 2],\n]\n"}) {
    const Config wanted = changed(parseConfig(old, "old"), "lidar.y = 0.5\nlidar.mask = [[3, 4]]");
    const std::string text = editedConfig(old, wanted);
    EXPECT_THAT(differences(parseConfig(text, "written"), wanted), IsEmpty()) << old;
  }
}

TEST(EditedConfig, RefusesWhatDoesNotFitTogether) {
  EXPECT_THROW(editedConfig("", changed({}, "base.driver = 'create'")), ConfigError)
      << "imu.driver is the HandsFree board's";
}

TEST(SetFrom, SetsWhatATextHasAndNamesItsKeys) {
  Config config;
  EXPECT_THAT(setFrom("lidar.x = 0.5\n[imu]\ndriver = 'base'\n", "answers", config),
              testing::UnorderedElementsAre("lidar.x", "imu.driver"));
  EXPECT_EQ(config.front_end.lidar.T_base_lidar.x, 0.5);
  try {
    setFrom("lidar.y = 0.5\nlidar.prt = 'a'", "answers", config);
    FAIL() << "an unknown key was taken";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("answers:2:"));
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'port'?"));
  }
  EXPECT_EQ(config.front_end.lidar.T_base_lidar.y, 0.0) << "all or nothing";
}

}  // namespace
}  // namespace slam::file_edit_test
