// SPDX-License-Identifier: BSD-3-Clause
#include "config/printer.hpp"

#include <array>
#include <charconv>
#include <cstdio>

#include "config/schema.hpp"

namespace slam {
namespace {

/// Shortest text that reads back to the same number, and reads as a TOML float.
std::string number(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  std::string shortest(text.data(), end);
  if (shortest.find_first_of(".en") == std::string::npos) shortest += ".0";
  return shortest;
}

std::string quoted(const std::string& value) {
  std::string text = "\"";
  for (const char c : value) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7F) {
      std::array<char, 8> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\u%04X", static_cast<unsigned>(code));
      text += escaped.data();
      continue;
    }
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

constexpr const char* kHidden = "(not printed)";  // a log that everybody may read keeps the configuration

/// Every key as text.
class TextVisitor : public ConfigVisitor {
 public:
  void field(const FieldInfo& info, double& value, double min, double max) override {
    line(info, number(value), number(min) + " to " + number(max));
  }
  void field(const FieldInfo& info, int& value, int min, int max) override {
    line(info, std::to_string(value), std::to_string(min) + " to " + std::to_string(max));
  }
  void field(const FieldInfo& info, bool& value) override { line(info, value ? "true" : "false", "true or false"); }
  void field(const FieldInfo& info, std::string& value) override {
    line(info, quoted(info.secret && hides_ && !value.empty() ? kHidden : value), "text");
  }
  void field(const FieldInfo& info, std::vector<BearingRange>& value) override {
    std::string list;
    for (const BearingRange& range : value)
      list += (list.empty() ? "[" : ", [") + number(range.from) + ", " + number(range.to) + "]";
    line(info, "[" + list + "]", "[[from, to], ...]");
  }
  void choice(const FieldInfo& info, std::size_t& index, std::span<const char* const> words) override {
    std::string range;
    for (const char* word : words) range += (range.empty() ? "" : " | ") + quoted(word);
    line(info, quoted(words[index]), range);
  }

 protected:
  /// @param range of the values that are allowed
  virtual void line(const FieldInfo& info, const std::string& value, const std::string& range) = 0;

  bool hides_ = true;  // a password
};

class SettingList : public TextVisitor {
 public:
  SettingList() { hides_ = false; }
  void section(const char* name, const char*) override { section_ = name; }
  const std::vector<Setting>& finish() const { return settings_; }

 protected:
  void line(const FieldInfo& info, const std::string& value, const std::string&) override {
    settings_.push_back({(section_.empty() ? "" : section_ + ".") + info.key, value});
  }

 private:
  std::string section_;
  std::vector<Setting> settings_;
};

/// Sections with their keys; a section without any is left out.
class SectionPrinter : public TextVisitor {
 public:
  void section(const char* name, const char* meaning) override {
    finish();
    name_ = name;
    meaning_ = meaning;
  }

  /// The whole text.
  const std::string& finish() {
    if (body_.empty()) return text_;
    if (!text_.empty()) text_ += '\n';
    text_ += head(name_, meaning_);
    text_ += body_;
    body_.clear();
    return text_;
  }

 protected:
  virtual std::string head(const std::string& name, const std::string& meaning) const = 0;

  const std::string& name() const { return name_; }

  std::string body_;  // of the present section

 private:
  std::string text_;  // the sections before it
  std::string name_, meaning_;
};

class TomlPrinter : public SectionPrinter {
 protected:
  std::string head(const std::string& name, const std::string& meaning) const override {
    return "# " + meaning + "\n" + (name.empty() ? "" : "[" + name + "]\n");
  }
  void line(const FieldInfo& info, const std::string& value, const std::string&) override {
    body_ += std::string(info.key) + " = " + value + "\n";
  }
};

class TemplatePrinter : public TomlPrinter {
 public:
  explicit TemplatePrinter(TemplateKeys keys) : keys_(keys) {}

 protected:
  void line(const FieldInfo& info, const std::string& value, const std::string& range) override {
    if (keys_ == TemplateKeys::kShown && !info.isShown()) return;
    const char* mark = info.tier == Tier::kRobot ? "ROBOT: " : info.tier == Tier::kExpert ? "EXPERT: " : "";
    const std::string unit = *info.unit ? std::string("[") + info.unit + "], " : "";
    body_ += std::string("\n# ") + mark + info.meaning + " (" + unit + range + ")\n";
    if (*info.when) body_ += std::string("# ") + info.when + "\n";
    body_ += std::string("#") + info.key + " = " + value + "\n";
  }

 private:
  TemplateKeys keys_;
};

class TuningPrinter : public SectionPrinter {
 protected:
  std::string head(const std::string& name, const std::string& meaning) const override {
    const std::string title = name.empty() ? meaning : "`[" + name + "]`: " + meaning;
    return "## " + title + "\n\n| key | default | range | meaning | when to change it |\n|---|---|---|---|---|\n";
  }
  void line(const FieldInfo& info, const std::string& value, const std::string& range) override {
    if (!info.isShown()) return;
    const std::string unit = *info.unit ? std::string(" ") + info.unit : "";
    const std::string mark = info.tier == Tier::kRobot ? " (robot)" : "";
    const std::string key = (name().empty() ? "" : name() + ".") + info.key;
    body_ += "| `" + key + "`" + mark + " | `" + value + "`" + unit + " | " + escaped(range) + " | " +
             escaped(info.meaning) + " | " + escaped(info.when) + " |\n";
  }

 private:
  static std::string escaped(const std::string& text) {
    std::string cell;
    for (const char c : text) cell += c == '|' ? "\\|" : std::string(1, c);
    return cell;
  }
};

template <typename Printer>
auto print(Config config, Printer printer) {
  visitConfig(config, printer);
  auto text = printer.finish();
  return text;
}

}  // namespace

std::string printConfig(const Config& config) { return print(config, TomlPrinter()); }

std::vector<Setting> settingsOf(const Config& config) { return print(config, SettingList()); }

std::string printTemplate(TemplateKeys keys) {
  const bool all = keys == TemplateKeys::kAll;
  const std::string whose =
      all ? "ROBOT: depends on the robot; EXPERT: holds for most robots; without mark: depends on "
            "where the robot works."
          : "ROBOT: depends on the robot; without mark: depends on where the robot works. The keys "
            "for experts:\n# slamd --print-template=all";
  return std::string("# slamd's configuration, with ") + (all ? "every key" : "the keys that a builder needs") +
         " at its default. Take the # off a line and change it.\n"
         "# An unknown key or a value out of range refuses to start: check with  slamd --config FILE "
         "--check-config\n# " +
         whose + "\n# Written by  slamd --print-template" + (all ? "=all" : "") + "\n\n" +
         print(Config(), TemplatePrinter(keys));
}

std::string printTuning() {
  return "# Tuning\n\n"
         "These are the keys that a builder needs; `slamd --print-template` prints them as a file to edit. Keys that "
         "are\n"
         "marked (robot) depend on the robot, the others on where it works. All other keys hold for most robots:\n"
         "`slamd --print-template=all` explains them, and [defaults.md](defaults.md) gives the reasons for their "
         "values.\n"
         "Numbers are in SI units. This page is written by `slamd --print-template=tuning`.\n\n" +
         print(Config(), TuningPrinter());
}

}  // namespace slam
