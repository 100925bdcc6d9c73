// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "app/config.hpp"

namespace slam {

/// What the file may say for one key. Declared once, in config_schema.cpp, for loading, checking and printing.
struct FieldInfo {
  const char* key;
  const char* unit;  ///< "" for none
  const char* meaning;
  bool basic = false;   ///< to be set for a robot; all other keys are for experts
  bool secret = false;  ///< is never printed
};

/// Visits every key of the configuration, section by section.
class ConfigVisitor {
 public:
  virtual ~ConfigVisitor() = default;
  virtual void section(const char* name, const char* meaning) = 0;
  virtual void field(const FieldInfo& info, double& value, double min, double max) = 0;
  virtual void field(const FieldInfo& info, int& value, int min, int max) = 0;
  virtual void field(const FieldInfo& info, bool& value) = 0;
  /// @param choices allowed values; empty: any text
  virtual void field(const FieldInfo& info, std::string& value, const std::vector<std::string>& choices) = 0;
};

void visitConfig(Config& config, ConfigVisitor& visitor);

}  // namespace slam
