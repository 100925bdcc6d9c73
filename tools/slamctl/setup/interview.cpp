// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/interview.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <ostream>
#include <sstream>

#include "config/loader.hpp"
#include "config/printer.hpp"
#include "store/durable_file.hpp"

namespace slam {
namespace {

constexpr std::uint64_t kMostAnswers = 1 << 20;  // [bytes]

/// Numbers, lists, texts in quotes, true and false.
bool isToml(const std::string& value) {
  if (value.empty()) return false;
  if (value == "true" || value == "false") return true;
  return std::isdigit(static_cast<unsigned char>(value[0])) != 0 ||
         std::string_view("+-.\"'[").find(value[0]) != std::string_view::npos;
}

/// A number as people write it: TOML has none that begins or ends with its point. What follows it stays.
std::string numberOf(const std::string& value) {
  const std::size_t end = std::min(value.find_first_of(" \t#"), value.size());
  std::string number = value.substr(0, end);
  const std::size_t first = number.find_first_of(".0123456789");
  if (first == std::string::npos || number.find_first_not_of("+-.0123456789") != std::string::npos) return value;
  if (number[first] == '.') number.insert(first, 1, '0');
  if (number.back() == '.') number += '0';
  return number + value.substr(end);
}

}  // namespace

std::string trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlanks);
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::string settingLine(const std::string& key, const std::string& value) {
  if (isToml(value)) return key + " = " + numberOf(value);
  std::string text = value.substr(0, value.find(" #"));
  std::string quoted;
  for (const char c : trimmed(text)) quoted += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return key + " = \"" + quoted + "\"";
}

void Interview::readAnswers(const std::filesystem::path& file) {
  std::istringstream in(readFile(file, kMostAnswers));
  std::string text;
  for (std::string line; std::getline(in, line);) {
    const std::string bare = trimmed(line);
    const std::size_t equals = bare.find('=');
    const bool plain = equals != std::string::npos && bare[0] != '#' && bare[0] != '[';
    text += (plain ? settingLine(trimmed(bare.substr(0, equals)), trimmed(bare.substr(equals + 1))) : bare) + "\n";
  }
  for (const std::string& key : setFrom(text, file.string(), config_)) answered_.insert(key);
}

std::string Interview::valueOf(const std::string& key) const {
  for (const auto& [name, value] : settingsOf(config_)) {
    if (name == key) return value;
  }
  return "";
}

void Interview::takeDefault(const std::string& key, const std::string& value) {
  if (!isAnswered(key)) setFrom(settingLine(key, value), "set-up", config_);
}

void Interview::take(const std::string& key, const std::string& value) {
  takeDefault(key, value);
  set_.insert(key);
}

void Interview::ask(const std::string& key, const std::string& question) {
  if (isSet(key)) return;
  if (!hasPerson()) {
    out() << key << " = " << valueOf(key) << ", a default: " << question << "\n";
    return;
  }
  for (Question asked{.kind = Question::kText, .id = key, .text = question, .otherwise = valueOf(key)};;) {
    const std::string typed = console_.answerTo(asked);
    if (typed.empty()) return;
    try {
      return take(key, typed);
    } catch (const ConfigError& error) {
      asked.error = error.what();
    }
  }
}

bool Interview::agrees(const std::string& id, const std::string& question, bool otherwise) {
  if (!hasPerson()) return otherwise;
  const std::string typed = console_.answerTo({.kind = Question::kYesNo, .id = id, .text = question});
  return typed == "y" || typed == "Y" || typed == "yes";
}

std::size_t Interview::choose(const std::string& id, const std::string& question, std::vector<std::string> choices) {
  const std::string typed =
      console_.answerTo({.kind = Question::kChoice, .id = id, .text = question, .choices = std::move(choices)});
  const bool is_number =
      !typed.empty() && typed.size() < 3 && typed.find_first_not_of("0123456789") == std::string::npos;
  return is_number ? std::stoul(typed) - 1 : SIZE_MAX;
}

}  // namespace slam
