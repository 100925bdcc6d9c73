// SPDX-License-Identifier: BSD-3-Clause
// Each key of the configuration changes what is read back, and what slamd does. A new key needs a row in
// config_effects.cpp.
#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/config_effects.hpp"
#include "build_paths.hpp"
#include "config/config_values.hpp"
#include "config/loader.hpp"
#include "config/printer.hpp"

namespace slam::config_effect_test {
namespace {

using test::Effect;

std::vector<Effect> allEffects() {
  std::vector<Effect> all = test::effectsOfDevices();
  for (auto* more : {&test::effectsOfEstimation, &test::effectsOfMap}) {
    const std::vector<Effect> rows = more();
    all.insert(all.end(), rows.begin(), rows.end());
  }
  return all;
}

Config configured(std::vector<std::string> settings) { return parseConfig("", "given", settings); }

/// The configuration of a row: before and after its key is set.
std::pair<Config, Config> beforeAndAfter(const Effect& effect) {
  std::vector<std::string> settings = effect.given;
  const Config before = configured(settings);
  settings.push_back(std::string(effect.key) + "=" + effect.value);
  return {before, configured(settings)};
}

void expectEffects(const std::vector<Effect>& effects) {
  std::map<std::pair<test::Observable, std::vector<std::string>>, std::string> before;  // what is usual, shown once
  for (const Effect& effect : effects) {
    if (effect.observable == nullptr) continue;
    const auto [usual, changed] = beforeAndAfter(effect);
    const auto key = std::pair(effect.observable, effect.given);
    if (!before.contains(key)) before[key] = effect.observable(usual);
    EXPECT_TRUE(effect.observable(changed) != before[key]) << effect.key << " = " << effect.value << " changes nothing";
  }
}

TEST(ConfigEffects, NameEveryKeyOfTheSchemaOnce) {
  std::vector<std::string> keys, rows;
  for (const auto& [key, value] : test::valuesOf(Config{})) keys.push_back(key.front() == '.' ? key.substr(1) : key);
  for (const Effect& effect : allEffects()) rows.emplace_back(effect.key);
  EXPECT_THAT(rows, testing::UnorderedElementsAreArray(keys));
}

TEST(ConfigEffects, OfAKeyAreItsValueAloneAndItIsReadBack) {
  for (const Effect& effect : allEffects()) {
    if (effect.observable == nullptr) continue;
    const auto [before, after] = beforeAndAfter(effect);
    const std::string key = std::string(effect.key) == "mode" ? ".mode" : effect.key;
    EXPECT_THAT(test::differences(before, after), testing::ElementsAre(key));
    EXPECT_THAT(test::differences(parseConfig(printConfig(after), "printed"), after), testing::IsEmpty()) << key;
  }
}

TEST(ConfigEffects, ThatOnlyADaemonShowsAreTestedThere) {
  for (const Effect& effect : allEffects()) {
    if (effect.observable != nullptr) continue;
    const std::string place = effect.elsewhere;
    const auto colon = place.find(": ");
    ASSERT_NE(colon, std::string::npos) << effect.key;
    std::ifstream in(SLAMD_SOURCE_DIR "/" + place.substr(0, colon));
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_THAT(text, testing::HasSubstr(place.substr(colon + 2))) << effect.key;
  }
}

TEST(ConfigEffects, OfDevicesAndThreads) { expectEffects(test::effectsOfDevices()); }
TEST(ConfigEffects, OfTheFilterAndTheFrontEnd) { expectEffects(test::effectsOfEstimation()); }
TEST(ConfigEffects, OfTheMapAndTheBackEnd) { expectEffects(test::effectsOfMap()); }

}  // namespace
}  // namespace slam::config_effect_test
