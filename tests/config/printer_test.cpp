// SPDX-License-Identifier: BSD-3-Clause
#include "config/printer.hpp"

#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "build_paths.hpp"
#include "config/config_values.hpp"
#include "config/loader.hpp"

namespace slam::printer_test {
namespace {

using test::differences;

/// Moves every key away from its default, to values that are hard to print.
class Change : public ConfigVisitor {
 public:
  void section(const char*, const char*) override {}
  void field(const FieldInfo&, double& value, double min, double max) override { value = min + (max - min) / 3.0; }
  void field(const FieldInfo&, int& value, int min, int) override { value = min; }
  void field(const FieldInfo&, bool& value) override { value = !value; }
  void field(const FieldInfo& info, std::string& value) override {
    value = info.secret ? "(not printed)" : "/a b/\"quoted\"\\new\n\ttab # no comment \u00e9\x01";
  }
  void field(const FieldInfo&, std::vector<BearingRange>& value) override { value = {{-30.0, 12.5}, {170.0, 190.0}}; }
  void choice(const FieldInfo&, std::size_t& index, std::span<const char* const> words) override {
    index = words.size() - 1;
  }
};

/// What no single key can be asked for, and every configuration must keep.
void keepTogether(Config& config) {
  config.lcm.url = "udpm://239.255.76.68:7668?ttl=1";
  config.lidar_device.model = LdsModel::kAuto;  // the driver is not "lds"
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

TEST(PrintTuning, IsTheFileInTheRepository) {
  EXPECT_TRUE(textOf(SLAMD_SOURCE_DIR "/docs/tuning.md") == printTuning())
      << "write it anew: slamd --print-template=tuning > docs/tuning.md";
}

/// The keys of a template, with those of the tier alone whose mark is given.
std::ptrdiff_t keysOf(const std::string& text, const std::string& mark = "") {
  const std::regex key("\n# " + mark + "[^\n]*\n(# [^\n]*\n)?#([a-z_0-9]+) = ");
  return std::distance(std::sregex_iterator(text.begin(), text.end(), key), {});
}

std::string uncommented(const std::string& text) {
  return std::regex_replace(text, std::regex("(^|\n)#([a-z_0-9]+ = )"), "$1$2");
}

TEST(PrintTemplate, ShowsTheFewKeysThatABuilderNeeds) {
  const std::string text = printTemplate();
  EXPECT_LE(keysOf(text), 45) << "more nobody reads";
  EXPECT_GE(keysOf(text), 30);
  EXPECT_GE(keysOf(text, "ROBOT: "), 10);
  EXPECT_LE(keysOf(text, "ROBOT: "), 20);
  EXPECT_EQ(keysOf(text, "EXPERT: "), 0);
  EXPECT_EQ(text.find("[match]"), std::string::npos) << "no section without a key";
}

TEST(PrintTemplate, ShowsAllKeysOnDemand) {
  const std::string all = printTemplate(TemplateKeys::kAll);
  EXPECT_EQ(static_cast<std::size_t>(keysOf(all)), test::valuesOf(Config{}).size());
  EXPECT_EQ(keysOf(all) - keysOf(all, "EXPERT: "), keysOf(printTemplate()));
  EXPECT_NE(all.find("\n# matching of scans against the local map\n[match]\n"), std::string::npos);
}

TEST(PrintTemplate, SetsNothing) {
  for (const TemplateKeys keys : {TemplateKeys::kShown, TemplateKeys::kAll})
    EXPECT_THAT(differences(parseConfig(printTemplate(keys), "template"), Config{}), testing::IsEmpty());
}

TEST(PrintTemplate, HoldsItsKeysReadyToUncomment) {
  for (const TemplateKeys keys : {TemplateKeys::kShown, TemplateKeys::kAll}) {
    const std::string text = printTemplate(keys), set = uncommented(text);
    EXPECT_THAT(differences(parseConfig(set, "template"), Config{}), testing::IsEmpty());
    const std::regex key_line("\n[a-z_0-9]+ = ");
    EXPECT_EQ(std::distance(std::sregex_iterator(set.begin(), set.end(), key_line), {}), keysOf(text));
  }
}

TEST(PrintConfig, PrintsTheHiddenKeys) {
  const std::string text = printConfig(parseConfig("[match]\nkernel_scale = 0.07\n", "robot.toml"));
  EXPECT_NE(text.find("\nkernel_scale = 0.07\n"), std::string::npos);
  EXPECT_EQ(printTemplate().find("kernel_scale"), std::string::npos);
}

TEST(PrintTuning, NamesTheKeysOfTheTemplateAndNoOthers) {
  const std::string text = printTuning();
  const std::regex row(
      "\n\\| `[a-z_0-9.]+`( \\(robot\\))? \\| ([^|]|\\\\\\|)+ \\| ([^|]|\\\\\\|)+ \\| [^|]+\\. \\| [^|]+\\. \\|");
  EXPECT_EQ(std::distance(std::sregex_iterator(text.begin(), text.end(), row), {}), keysOf(printTemplate()));
}

}  // namespace
}  // namespace slam::printer_test
