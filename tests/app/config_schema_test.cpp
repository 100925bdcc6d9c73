// SPDX-License-Identifier: BSD-3-Clause
#include "app/config_schema.hpp"

#include <algorithm>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/config_values.hpp"

namespace slam {
namespace {

/// Checks what the schema says of each key.
class SchemaCheck : public ConfigVisitor {
 public:
  void section(const char* name, const char* meaning) override {
    section_ = name;
    EXPECT_GT(std::strlen(meaning), 5U) << section_ << " is not explained";
  }
  void field(const FieldInfo& info, double& value, double min, double max) override {
    explained(info);
    EXPECT_STRNE(info.unit, "") << section_ << "." << info.key << " has no unit";
    inRange(info, value, min, max);
  }
  void field(const FieldInfo& info, int& value, int min, int max) override {
    explained(info);
    inRange(info, value, min, max);
  }
  void field(const FieldInfo& info, bool&) override { explained(info); }
  void field(const FieldInfo& info, std::string& value, const std::vector<std::string>& choices) override {
    explained(info);
    if (!choices.empty()) {
      EXPECT_THAT(choices, testing::Contains(value)) << section_ << "." << info.key;
    }
  }

 private:
  void explained(const FieldInfo& info) const {
    EXPECT_GT(std::strlen(info.meaning), 5U) << section_ << "." << info.key << " is not explained";
  }
  template <typename Number>
  void inRange(const FieldInfo& info, Number value, Number min, Number max) const {
    EXPECT_LT(min, max) << section_ << "." << info.key;
    EXPECT_TRUE(value >= min && value <= max) << section_ << "." << info.key << ": default " << value;
  }
  std::string section_;
};

TEST(ConfigSchema, ExplainsEachKeyAndHoldsItsDefault) {
  Config config;
  SchemaCheck check;
  visitConfig(config, check);
}

TEST(ConfigSchema, NamesEachKeyOnce) {
  Config config;
  test::ValueReader reader;
  visitConfig(config, reader);
  EXPECT_GT(reader.values.size(), 50U);
  EXPECT_THAT(reader.repeated, testing::IsEmpty());
}

}  // namespace
}  // namespace slam
