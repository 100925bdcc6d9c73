// SPDX-License-Identifier: BSD-3-Clause
#include "config/file_edit.hpp"

#include <optional>
#include <sstream>
#include <stdexcept>
#include <toml++/toml.h>
#include <vector>

#include "config/loader.hpp"
#include "config/printer.hpp"

namespace slam {
namespace {

using Lines = std::vector<std::string>;

Lines linesOf(const std::string& text) {
  Lines lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string_view withoutBlanks(std::string_view line) {
  const auto begin = line.find_first_not_of(" \t");
  return begin == std::string_view::npos ? std::string_view() : line.substr(begin);
}

/// The byte at which a character of a line begins. @param column from 1, in characters
std::size_t byteOf(const std::string& line, std::size_t column) {
  std::size_t at = 0;
  for (std::size_t character = 1; at < line.size() && character < column; ++character) {
    do ++at;
    while (at < line.size() && (static_cast<unsigned char>(line[at]) & 0xC0) == 0x80);
  }
  return at;
}

/// Puts a value in the place of another one, of one line.
bool replaceValue(Lines& lines, const toml::node& old, const std::string& value) {
  const auto& [begin, end, path] = old.source();
  if (begin.line != end.line || begin.line == 0 || begin.line > lines.size()) return false;
  std::string& line = lines[begin.line - 1];
  const std::size_t from = byteOf(line, begin.column), to = byteOf(line, end.column);
  line = line.substr(0, from) + value + line.substr(to);
  return true;
}

/// Lines [begin, end) of a section, without its head.
struct Range {
  std::size_t begin, end;
};
std::optional<Range> sectionIn(const Lines& lines, const std::string& section) {
  std::optional<std::size_t> begin = section.empty() ? std::optional<std::size_t>(0) : std::nullopt;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = withoutBlanks(lines[i]);
    if (!line.starts_with('[')) continue;
    if (begin) return Range{*begin, i};
    if (line.starts_with("[" + section + "]")) begin = i + 1;
  }
  return begin ? std::optional(Range{*begin, lines.size()}) : std::nullopt;
}

/// "#key = ", as a template has it.
bool showsKey(std::string_view line, const std::string& key) {
  if (!line.starts_with('#')) return false;
  line = withoutBlanks(line.substr(1));
  return line.starts_with(key) && withoutBlanks(line.substr(key.size())).starts_with('=');
}

void addKey(Lines& lines, const std::string& section, const std::string& key, const std::string& value) {
  const std::string text = key + " = " + value;
  auto range = sectionIn(lines, section);
  if (!range) {
    lines.insert(lines.end(), {"", "[" + section + "]"});
    range = Range{lines.size(), lines.size()};
  }
  for (std::size_t i = range->begin; i < range->end; ++i) {
    if (showsKey(lines[i], key)) return void(lines[i] = text);
  }
  lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(range->begin), text);
}

/// @return std::nullopt: that text cannot be changed so
std::optional<std::string> edited(const std::string& text, const Config& wanted) {
  try {
    std::string changed = text;
    const auto have = settingsOf(parseConfig(text, "file")), want = settingsOf(wanted);
    for (std::size_t i = 0; i < want.size(); ++i) {
      if (have[i] == want[i]) continue;
      const std::size_t dot = want[i].key.find('.');
      const bool top = dot == std::string::npos;
      const std::string section = top ? "" : want[i].key.substr(0, dot),
                        key = top ? want[i].key : want[i].key.substr(dot + 1);
      const toml::table root = toml::parse(changed);
      Lines lines = linesOf(changed);
      const auto node = top ? root[key] : root[section][key];
      if (node && !replaceValue(lines, *node.node(), want[i].value)) return std::nullopt;
      if (!node) addKey(lines, section, key, want[i].value);
      changed = joined(lines);
    }
    return settingsOf(parseConfig(changed, "file")) == want ? std::optional(changed) : std::nullopt;
  } catch (const ConfigError&) {
  } catch (const toml::parse_error&) {
  }
  return std::nullopt;
}

}  // namespace

std::string editedConfig(const std::string& text, const Config& wanted) {
  const std::string shown = printTemplate();
  if (const auto changed = edited(text.empty() ? shown : text, wanted)) return *changed;
  if (const auto filled = edited(shown, wanted)) return *filled;
  std::string whole;
  for (const auto& [key, value] : settingsOf(wanted)) whole += key + " = " + value + "\n";
  parseConfig(whole, "configuration");  // throws what is wrong
  throw std::runtime_error("the configuration cannot be written as a file that is read back to the same values");
}

}  // namespace slam
