// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "config/choices.hpp"
#include "config/config.hpp"

namespace slam {

/// Who sets a key. Templates show the first two; the others hold for most robots, and load as well.
enum class Tier : std::uint8_t {
  kRobot,   ///< depends on the robot
  kSite,    ///< depends on where the robot works, or on a device that few have
  kExpert,  ///< hidden
};

/// What the file may say for one key. Declared once, in schema.cpp, for loading, checking and printing.
struct FieldInfo {
  const char* key;
  const char* unit;     ///< "" for none
  const char* meaning;  ///< one sentence of 25 words at most, which is understood without its section
  Tier tier = Tier::kExpert;
  const char* when = "";  ///< one sentence: when to change a key that is shown
  bool secret = false;    ///< is never printed

  bool isShown() const { return tier != Tier::kExpert; }
};

/// Visits every key of the configuration, section by section.
class ConfigVisitor {
 public:
  virtual ~ConfigVisitor() = default;
  virtual void section(const char* name, const char* meaning) = 0;
  virtual void field(const FieldInfo& info, double& value, double min, double max) = 0;
  virtual void field(const FieldInfo& info, int& value, int min, int max) = 0;
  virtual void field(const FieldInfo& info, bool& value) = 0;
  virtual void field(const FieldInfo& info, std::string& value) = 0;
  virtual void field(const FieldInfo& info, std::vector<BearingRange>& value) = 0;
  /// @param index of the value's word; to be set to that of another
  virtual void choice(const FieldInfo& info, std::size_t& index, std::span<const char* const> words) = 0;

  template <Chosen Enum>
  void field(const FieldInfo& info, Enum& value) {
    auto index = static_cast<std::size_t>(value);
    choice(info, index, kWords<Enum>);
    value = static_cast<Enum>(index);
  }
};

void visitConfig(Config& config, ConfigVisitor& visitor);

/// A key of an earlier release. A file that sets it stays valid; it has no effect.
struct RetiredKey {
  const char* section;
  const char* key;
  const char* instead;  ///< what does its work now, as the end of a sentence
};
std::span<const RetiredKey> retiredKeys();

/// A key that had another name in an earlier release. The old name is an alias.
struct RenamedKey {
  const char* section;
  const char* old_key;
  const char* key;
};
std::span<const RenamedKey> renamedKeys();

}  // namespace slam
