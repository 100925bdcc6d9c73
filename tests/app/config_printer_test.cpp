// SPDX-License-Identifier: BSD-3-Clause
#include "app/config_printer.hpp"

#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "app/config_loader.hpp"
#include "app/config_values.hpp"
#include "build_paths.hpp"

namespace slam {
namespace {

using test::differences;

/// Moves every key away from its default, to values that are hard to print.
class Change : public ConfigVisitor {
 public:
  void section(const char*, const char*) override {}
  void field(const FieldInfo&, double& value, double min, double max) override { value = min + (max - min) / 3.0; }
  void field(const FieldInfo&, int& value, int min, int) override { value = min; }
  void field(const FieldInfo&, bool& value) override { value = !value; }
  void field(const FieldInfo& info, std::string& value, const std::vector<std::string>& choices) override {
    value = info.secret       ? "(not printed)"
            : choices.empty() ? "/a b/\"quoted\"\\new\n\ttab # no comment \u00e9\x01"
                              : choices.back();
  }
};

/// What no single key can be asked for, and every configuration must keep.
void keepTogether(Config& config) {
  config.lcm.url = "udpm://239.255.76.68:7668?ttl=1";
  config.lcm.pose_rate = std::min(config.lcm.pose_rate, config.runtime.estimator_rate);
  config.base_device.mileage_rate = config.base_device.imu_rate = std::min(200.0, config.runtime.base_rate / 4.0);
}

std::string textOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in.good()) << path << " is missing";
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(PrintConfig, IsReadBackToTheSameValues) {
  Config config;
  EXPECT_THAT(differences(parseConfig(printConfig(config), "printed"), config), testing::IsEmpty());
  Change change;
  visitConfig(config, change);
  keepTogether(config);
  EXPECT_THAT(differences(parseConfig(printConfig(config), "printed"), config), testing::IsEmpty());
  EXPECT_EQ(printConfig(parseConfig(printConfig(config), "printed")), printConfig(config));
}

TEST(PrintConfig, KeepsASecretToItself) {
  Config config;
  config.web.commands = true;
  config.web.token = "0123456789abcdef";
  const std::string text = printConfig(config);
  EXPECT_THAT(text, testing::Not(testing::HasSubstr(config.web.token)));
  EXPECT_EQ(printConfig(parseConfig(text, "printed")), text);
}

TEST(PrintConfig, KeepsTheEnds) {
  for (const bool upper : {false, true}) {
    class ToEnd : public Change {
     public:
      explicit ToEnd(bool to_max) : to_max_(to_max) {}
      void field(const FieldInfo&, double& value, double min, double max) override { value = to_max_ ? max : min; }
      void field(const FieldInfo&, int& value, int min, int max) override { value = to_max_ ? max : min; }
      using Change::field;

     private:
      bool to_max_;
    };
    Config config;
    ToEnd to_end(upper);
    visitConfig(config, to_end);
    keepTogether(config);
    EXPECT_THAT(differences(parseConfig(printConfig(config), "printed"), config), testing::IsEmpty());
  }
}

TEST(PrintTemplate, IsTheFileInTheRepository) {
  EXPECT_TRUE(textOf(SLAMD_SOURCE_DIR "/config/slamd.toml") == printTemplate())
      << "write it anew: slamd --print-template > config/slamd.toml";
}

TEST(PrintTemplate, MarksTheFewKeysThatARobotMustBeToldBy) {
  const std::string text = printTemplate();
  const std::regex marked("\n# ROBOT: [^\n]*\n#([a-z_]+) = ");
  const auto count = std::distance(std::sregex_iterator(text.begin(), text.end(), marked), {});
  EXPECT_GE(count, 10);
  EXPECT_LE(count, 15) << "more nobody reads";
  EXPECT_NE(text.find("\n# expert: point-to-line matching of scans\n[match]\n"), std::string::npos);
  EXPECT_EQ(text.find("expert: wheels and the geometry"), std::string::npos);
}

TEST(PrintTemplate, SetsNothing) {
  EXPECT_THAT(differences(parseConfig(printTemplate(), "template"), Config{}), testing::IsEmpty());
}

TEST(PrintTemplate, HoldsEveryKeyReadyToUncomment) {
  const std::string text = printTemplate();
  const std::string uncommented = std::regex_replace(text, std::regex("(^|\n)#([a-z_0-9]+ = )"), "$1$2");
  EXPECT_THAT(differences(parseConfig(uncommented, "template"), Config{}), testing::IsEmpty());
  const std::regex key_line("\n[a-z_0-9]+ = ");
  const auto keys = std::distance(std::sregex_iterator(uncommented.begin(), uncommented.end(), key_line), {});
  EXPECT_EQ(static_cast<std::size_t>(keys), test::valuesOf(Config{}).size());
}

}  // namespace
}  // namespace slam
