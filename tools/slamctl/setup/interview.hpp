// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "tools/slamctl/setup/console.hpp"

namespace slam {

/// The configuration that a set-up comes to: of a file, of answers, of what was found, and of what a person says, who
/// is asked one question at a time. What the answers set, nothing else changes.
class Interview {
 public:
  /// @param set keys that the file of `start` sets @param console without a person each default is taken
  Interview(Config start, const std::vector<std::string>& set, Console& console)
      : config_(std::move(start)), set_(set.begin(), set.end()), console_(console) {}

  const Config& config() const { return config_; }
  Console& console() const { return console_; }
  std::ostream& out() const { return console_.out(); }
  bool hasPerson() const { return console_.hasPerson(); }

  /// Takes answers: lines of `section.key = value`. A text needs no quotes.
  /// @throws ConfigError as a configuration has it, for an unknown key or a value that cannot be
  void readAnswers(const std::filesystem::path& file);
  bool isAnswered(const std::string& key) const { return answered_.contains(key); }
  /// By the file, by an answer or by what was found.
  bool isSet(const std::string& key) const { return isAnswered(key) || set_.contains(key); }
  /// The value as the file would have it.
  std::string valueOf(const std::string& key) const;

  /// Takes what was found out. @param value as a person types it @throws ConfigError
  void take(const std::string& key, const std::string& value);
  /// The same for a guess: it is the default of the question that follows.
  void takeDefault(const std::string& key, const std::string& value);
  /// Asks for a key that is not set; an empty line takes the value that it has.
  void ask(const std::string& key, const std::string& question);
  /// @param id of the decision @param otherwise where nobody can be asked
  bool agrees(const std::string& id, const std::string& question, bool otherwise);
  /// Which of them. @return their index; any other number: none of them
  std::size_t choose(const std::string& id, const std::string& question, std::vector<std::string> choices);

 private:
  Config config_;
  std::set<std::string> set_, answered_;
  Console& console_;
};

/// Without the blanks around it.
std::string trimmed(const std::string& text);

/// `key = value` with the quotes that TOML wants around a text. @param value as a person types it
std::string settingLine(const std::string& key, const std::string& value);

}  // namespace slam
