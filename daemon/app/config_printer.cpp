// SPDX-License-Identifier: BSD-3-Clause
#include "app/config_printer.hpp"

#include <array>
#include <charconv>
#include <cstdio>

#include "app/config_schema.hpp"

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

constexpr const char* kBasicMark = "ROBOT";
constexpr const char* kHidden = "(not printed)";  // a log that everybody may read keeps the configuration

class Printer : public ConfigVisitor {
 public:
  explicit Printer(bool as_template) : as_template_(as_template) {}

  void section(const char* name, const char* meaning) override {
    finish();
    head_ = std::string(meaning) + "\n";
    if (*name != '\0') head_ += std::string("[") + name + "]\n";
  }
  void field(const FieldInfo& info, double& value, double min, double max) override {
    line(info, number(value), number(min) + " to " + number(max));
  }
  void field(const FieldInfo& info, int& value, int min, int max) override {
    line(info, std::to_string(value), std::to_string(min) + " to " + std::to_string(max));
  }
  void field(const FieldInfo& info, bool& value) override { line(info, value ? "true" : "false", "true or false"); }
  void field(const FieldInfo& info, std::string& value, const std::vector<std::string>& choices) override {
    if (info.secret && !value.empty()) return line(info, quoted(kHidden), "text");
    std::string range = choices.empty() ? "text" : "";
    for (const std::string& choice : choices) range += (range.empty() ? "" : " | ") + quoted(choice);
    line(info, quoted(value), range);
  }

  /// The whole text.
  const std::string& finish() {
    if (head_.empty()) return text_;
    if (!text_.empty()) text_ += "\n";
    text_ += std::string("# ") + (as_template_ && !basic_ ? "expert: " : "") + head_ + body_;
    head_.clear();
    body_.clear();
    basic_ = false;
    return text_;
  }

 private:
  void line(const FieldInfo& info, const std::string& value, const std::string& range) {
    if (!as_template_) {
      body_ += std::string(info.key) + " = " + value + "\n";
      return;
    }
    const std::string unit = *info.unit ? std::string(" [") + info.unit + "]" : "";
    const std::string mark = info.basic ? std::string(kBasicMark) + ": " : "";
    basic_ |= info.basic;
    body_ += "\n# " + mark + info.meaning + unit + "; " + range + "\n#" + info.key + " = " + value + "\n";
  }

  bool as_template_;
  std::string text_, head_, body_;  // what is done; the present section
  bool basic_ = false;              // the present section has a key that is
};

}  // namespace

std::string printConfig(const Config& config) {
  Config copy = config;
  Printer printer(false);
  visitConfig(copy, printer);
  return printer.finish();
}

std::string printTemplate() {
  Config defaults;
  Printer printer(true);
  visitConfig(defaults, printer);
  return "# slamd's configuration, with every key at its default. Take the # off a line and change it. An unknown key "
         "or a\n"
         "# value out of range refuses to start: check with  slamd --config FILE --check-config\n"
         "# What slamd must be told of a robot is marked \"" +
         std::string(kBasicMark) +
         "\"; all other keys are for experts, and hold for most robots.\n"
         "# Written by  slamd --print-template\n\n" +
         printer.finish();
}

}  // namespace slam
