// SPDX-License-Identifier: BSD-3-Clause
#include "config/schema.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <string_view>
#include <vector>

#include "config/config_values.hpp"

namespace slam::schema_test {
namespace {

/// One sentence: begins with a capital, a name (POSE, slam-web) or a number, ends with its only full stop, 25 words at
/// most.
void expectSentence(const std::string& text, const std::string& key) {
  ASSERT_GT(text.size(), 10U) << key;
  const bool named = text.starts_with("slam-web");
  EXPECT_TRUE(named || (std::isupper(static_cast<unsigned char>(text.front())) != 0)) << key << ": " << text;
  EXPECT_EQ(text.back(), '.') << key << ": " << text;
  const auto inner = [&] {  // full stops within: of numbers, keys, files, "e.g."
    for (auto at = text.find(". "); at != std::string::npos; at = text.find(". ", at + 1))
      if (!std::string_view(text).substr(0, at + 1).ends_with("e.g.")) return true;
    return false;
  };
  EXPECT_FALSE(inner()) << key << " has several: " << text;
  EXPECT_LE(1 + std::count(text.begin(), text.end(), ' '), 25) << key << ": " << text;
  EXPECT_EQ(text.find("  "), std::string::npos) << key << ": " << text;
}

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
  void field(const FieldInfo& info, std::string&) override { explained(info); }
  void field(const FieldInfo& info, std::vector<BearingRange>&) override { explained(info); }
  void choice(const FieldInfo& info, std::size_t& index, std::span<const char* const> words) override {
    explained(info);
    EXPECT_LT(index, words.size()) << section_ << "." << info.key;
    EXPECT_GE(words.size(), 2U) << section_ << "." << info.key;
  }

 private:
  void explained(const FieldInfo& info) const {
    const std::string key = section_ + "." + info.key;
    expectSentence(info.meaning, key);
    if (info.isShown()) {
      expectSentence(info.when, key + ", when to change it");
    } else {
      EXPECT_STREQ(info.when, "") << key << " is hidden";
    }
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
}  // namespace slam::schema_test
