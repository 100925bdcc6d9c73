// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "config/schema.hpp"

namespace slam::test {

using Value = std::variant<double, int, bool, std::string>;

/// Reads every key of a configuration as `section.key`.
class ValueReader : public ConfigVisitor {
 public:
  void section(const char* name, const char*) override { section_ = name; }
  void field(const FieldInfo& info, double& value, double, double) override { add(info, value); }
  void field(const FieldInfo& info, int& value, int, int) override { add(info, value); }
  void field(const FieldInfo& info, bool& value) override { add(info, value); }
  void field(const FieldInfo& info, std::string& value) override { add(info, value); }
  void field(const FieldInfo& info, std::vector<BearingRange>& value) override {
    std::string list;
    for (const BearingRange& range : value) list += std::to_string(range.from) + " " + std::to_string(range.to) + " ";
    add(info, list);
  }
  void choice(const FieldInfo& info, std::size_t& index, std::span<const char* const> words) override {
    add(info, std::string(words[index]));
  }

  std::map<std::string, Value> values;
  std::vector<std::string> repeated;

 private:
  void add(const FieldInfo& info, const Value& value) {
    const std::string key = section_ + "." + info.key;
    if (!values.emplace(key, value).second) repeated.push_back(key);
  }
  std::string section_;
};

inline std::map<std::string, Value> valuesOf(Config config) {
  ValueReader reader;
  visitConfig(config, reader);
  return reader.values;
}

/// The keys in which two configurations differ.
inline std::vector<std::string> differences(const Config& a, const Config& b) {
  const auto values_a = valuesOf(a), values_b = valuesOf(b);
  std::vector<std::string> keys;
  for (const auto& [key, value] : values_a) {
    if (values_b.at(key) != value) keys.push_back(key);
  }
  return keys;
}

}  // namespace slam::test
