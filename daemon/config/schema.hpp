// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
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

/// What the file may say for one key. Declared once, in the visitSettings() of its struct.
struct FieldInfo {
  const char* key;
  const char* unit;     ///< "" for none
  const char* meaning;  ///< one sentence of 25 words at most, which is understood without its section
  Tier tier = Tier::kExpert;
  const char* when = "";  ///< one sentence: when to change a key that is shown
  bool secret = false;    ///< is never printed

  bool isShown() const { return tier != Tier::kExpert; }
};

/// Visits every key of the configuration, section by section. Each struct declares its settings beside its fields, in
/// `void visitSettings(auto& v)`, and needs nothing of this library:
///
///     v.section(name, meaning);
///     v.robot(key, number, unit, least, most, meaning, when to change it);  // or site()
///     v.expert(key, text, meaning);  // or a flag, a choice, a list of bearings
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

  template <typename Value, typename... About>
  void robot(const char* key, Value& value, About... about) {
    declare(Tier::kRobot, key, value, about...);
  }
  template <typename Value, typename... About>
  void site(const char* key, Value& value, About... about) {
    declare(Tier::kSite, key, value, about...);
  }
  template <typename Value, typename... About>
  void expert(const char* key, Value& value, About... about) {
    declare(Tier::kExpert, key, value, about...);
  }
  /// As expert(), of a text that is never printed.
  void secret(const char* key, std::string& value, const char* meaning) {
    field({key, "", meaning, Tier::kExpert, "", true}, value);
  }

 private:
  template <typename Number>
  void declare(Tier tier, const char* key, Number& value, const char* unit, Number min, Number max, const char* meaning,
               const char* when = "") {
    field({key, unit, meaning, tier, when}, value, min, max);
  }
  template <typename Value>
  void declare(Tier tier, const char* key, Value& value, const char* meaning, const char* when = "") {
    field({key, std::is_same_v<Value, std::vector<BearingRange>> ? "deg" : "", meaning, tier, when}, value);
  }
  template <Chosen Enum>
  void field(const FieldInfo& info, Enum& value) {
    auto index = static_cast<std::size_t>(value);
    choice(info, index, kWords<Enum>);
    value = static_cast<Enum>(index);
  }
};

inline void visitConfig(Config& config, ConfigVisitor& visitor) { config.visitSettings(visitor); }

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
