// SPDX-License-Identifier: BSD-3-Clause
#include "config/loader.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <grp.h>
#include <initializer_list>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <sys/stat.h>
#include <toml++/toml.h>
#include <utility>

#include "bus/local_socket.hpp"
#include "bus/udpm/udpm_url.hpp"
#include "config/closest_word.hpp"
#include "config/schema.hpp"

namespace slam {
namespace {

constexpr std::array kRetired = std::to_array<RetiredKey>({
    {"search", "max_doubt", "the match starts from several poses where its overlap drops, or the wheels are ignored"},
    {"search", "wheel_guidance",
     "the match starts from several poses where its overlap drops, or the wheels are ignored"},
    {"keyframe", "overlap", "a scan becomes a keyframe by the motion since the last one, however much of it matches"},
    {"localisation", "kidnap_distance", "a robot is carried away when its scans see through the walls around it"},
    {"relocalisation", "min_seen", "that the robot is in no place of the map is one of the places compared"},
});

constexpr std::array kRenamed = std::to_array<RenamedKey>({
    {"ekf", "doubt_memory", "nis_memory"},
    {"match", "sliding_observations", "grazing_observations"},
    {"keyframe", "familiarity", "known_ratio"},
    {"keyframe", "look_period", "refresh_period"},
    {"relocalisation", "min_lead", "min_margin"},
});

std::string join(const std::vector<std::string>& lines, const char* separator) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : separator) + line;
  return text;
}

/// Where each key was set last, as file:line:column.
using Places = std::map<std::string, std::string>;

class TomlLoader : public ConfigVisitor {
 public:
  TomlLoader(const toml::table& root, std::string name, Places& places)
      : root_(root), name_(std::move(name)), places_(places) {}

  void section(const char* name, const char*) override {
    section_ = name;
    table_ = nullptr;
    if (section_.empty()) {  // keys before the first section
      table_ = &root_;
      return;
    }
    known_[section_];
    const toml::node* node = root_.get(section_);
    if (node == nullptr) return;
    table_ = node->as_table();
    if (table_ == nullptr) problem(*node, section_, "must be a table", "write [" + section_ + "]");
  }
  void field(const FieldInfo& info, double& value, double min, double max) override {
    const toml::node* node = find(info);
    if (node == nullptr) return;
    const auto number = node->value<double>();
    if (!node->is_number() || !number) return wrongType(*node, info, "a number");
    if (!(*number >= min && *number <= max)) return outOfRange(*node, info, *number, min, max);
    value = *number;
  }
  void field(const FieldInfo& info, int& value, int min, int max) override {
    const toml::node* node = find(info);
    if (node == nullptr) return;
    const auto number = node->value_exact<std::int64_t>();
    if (!number) return wrongType(*node, info, "a whole number");
    if (*number < min || *number > max) return outOfRange(*node, info, static_cast<double>(*number), min, max);
    value = static_cast<int>(*number);
  }
  void field(const FieldInfo& info, bool& value) override {
    const toml::node* node = find(info);
    if (node == nullptr) return;
    const auto boolean = node->value_exact<bool>();
    if (!boolean) return wrongType(*node, info, "true or false");
    value = *boolean;
  }
  void field(const FieldInfo& info, std::string& value) override {
    const toml::node* node = find(info);
    if (node == nullptr) return;
    const auto text = node->value_exact<std::string>();
    if (!text) return wrongType(*node, info, "text in quotes");
    value = *text;
  }
  void field(const FieldInfo& info, std::vector<BearingRange>& value) override {
    const toml::node* node = find(info);
    if (node == nullptr) return;
    const toml::array* list = node->as_array();
    if (list == nullptr) return wrongType(*node, info, "a list of pairs, such as [[150, 210]]");
    std::vector<BearingRange> ranges;
    for (const toml::node& item : *list) {
      const toml::array* pair = item.as_array();
      const bool two = pair != nullptr && pair->size() == 2 && (*pair)[0].is_number() && (*pair)[1].is_number();
      if (!two) return wrongType(item, info, "a pair of angles, such as [150, 210]");
      const BearingRange range{*(*pair)[0].value<double>(), *(*pair)[1].value<double>()};
      for (const double angle : {range.from, range.to})
        if (!(std::abs(angle) <= 360.0)) return outOfRange(item, info, angle, -360.0, 360.0);
      const double width = range.to - range.from;
      if (!(width > 0.0 && width < 360.0)) {
        return problem(item, fullKey(info.key), "spans no part of a turn",
                       "let the second angle be larger than the first, by less than 360");
      }
      ranges.push_back(range);
    }
    value = std::move(ranges);
  }
  void choice(const FieldInfo& info, std::size_t& index, std::span<const char* const> words) override {
    const toml::node* node = find(info);
    if (node == nullptr) return;
    const auto text = node->value_exact<std::string>();
    if (!text) return wrongType(*node, info, "text in quotes");
    const auto word = std::find(words.begin(), words.end(), *text);
    if (word == words.end()) {
      return problem(*node, fullKey(info.key), "\"" + *text + "\" is not a choice",
                     "use one of: " + join({words.begin(), words.end()}, ", "));
    }
    index = static_cast<std::size_t>(word - words.begin());
  }

  /// To be called after the visit, when all keys are known.
  void checkUnknown() {
    std::vector<std::string> sections;
    for (const auto& [name, keys] : known_) sections.push_back(name);
    sections.insert(sections.end(), top_level_.begin(), top_level_.end());
    for (const auto& [key, node] : root_) {
      const std::string name(key.str());
      if (isTopLevel(name)) continue;
      if (!known_.count(name)) {
        const std::string section = node.is_table() ? "" : elsewhere(name);
        unknown(node, name, section.empty() ? closestWord(name, sections) : "", section);
        continue;
      }
      const toml::table* table = node.as_table();
      if (table == nullptr) continue;
      for (const auto& [inner, inner_node] : *table) {
        const std::string word(inner.str());
        const auto& keys = known_[name];
        const auto retired = std::find_if(retiredKeys().begin(), retiredKeys().end(), [&](const RetiredKey& one) {
          return one.section == name && one.key == word;
        });
        if (retired != retiredKeys().end()) {
          notices_.push_back(placeOf(inner_node) + ": " + name + "." + word + ": has no effect any more, because " +
                             retired->instead + "; remove it");
        } else if (std::find(keys.begin(), keys.end(), word) == keys.end() && !isOldName(name, word)) {
          unknown(inner_node, name + "." + word, closestWord(word, keys), elsewhere(word));
        }
      }
    }
  }

  /// Of keys that were renamed or have no effect any more.
  const std::vector<std::string>& notices() const { return notices_; }

  std::vector<std::string> takeProblems() {
    std::stable_sort(problems_.begin(), problems_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> lines;
    for (auto& [position, line] : problems_) lines.push_back(std::move(line));
    return lines;
  }

 private:
  std::string fullKey(const char* key) const { return (section_.empty() ? "" : section_ + ".") + key; }

  bool isTopLevel(const std::string& key) const {
    return std::find(top_level_.begin(), top_level_.end(), key) != top_level_.end();
  }

  static bool isOldName(const std::string& section, const std::string& key) {
    return std::any_of(renamedKeys().begin(), renamedKeys().end(),
                       [&](const RenamedKey& one) { return one.section == section && one.old_key == key; });
  }

  /// The value of a key, under whichever name it is set; null: not set.
  const toml::node* find(const FieldInfo& info) {
    (section_.empty() ? top_level_ : known_[section_]).push_back(info.key);
    const toml::node* node = table_ == nullptr ? nullptr : table_->get(info.key);
    for (const RenamedKey& renamed : renamedKeys()) {
      const bool same = renamed.section == section_ && info.key == std::string_view(renamed.key);
      const toml::node* old = same && table_ != nullptr ? table_->get(renamed.old_key) : nullptr;
      if (old == nullptr) continue;
      if (node != nullptr) {
        problem(*old, fullKey(renamed.old_key), "is set under its new name, too", "remove the old one");
      } else {
        notices_.push_back(placeOf(*old) + ": " + fullKey(renamed.old_key) + ": is called " + fullKey(info.key) +
                           " now; the old name still works in this release");
        node = old;
      }
    }
    if (node != nullptr) places_[fullKey(info.key)] = placeOf(*node);
    return node;
  }
  std::string elsewhere(const std::string& word) const {
    for (const auto& [name, keys] : known_) {
      if (std::find(keys.begin(), keys.end(), word) != keys.end()) return name;
    }
    return "";
  }
  void unknown(const toml::node& node, const std::string& key, const std::string& like, const std::string& section) {
    std::string fix = "remove it, or see slamd --print-config for all keys";
    if (!like.empty()) fix = "did you mean '" + like + "'?";
    if (like.empty() && !section.empty()) fix = "it belongs into [" + section + "]";
    problem(node, key, "unknown key", fix);
  }
  void wrongType(const toml::node& node, const FieldInfo& info, const char* wanted) {
    std::ostringstream is;
    is << node.type();
    problem(node, fullKey(info.key), "is " + is.str(), std::string("must be ") + wanted);
  }
  void outOfRange(const toml::node& node, const FieldInfo& info, double value, double min, double max) {
    std::ostringstream what, fix;
    what << value << " is out of range";
    fix << "use " << min << " to " << max << (*info.unit ? " " : "") << info.unit;
    problem(node, fullKey(info.key), what.str(), fix.str());
  }
  std::string placeOf(const toml::node& node) const {
    const auto at = node.source().begin;
    return name_ + ":" + std::to_string(at.line) + ":" + std::to_string(at.column);
  }
  void problem(const toml::node& node, const std::string& key, const std::string& what, const std::string& fix) {
    const auto at = node.source().begin;
    problems_.emplace_back(std::pair(at.line, at.column), placeOf(node) + ": " + key + ": " + what + "; " + fix);
  }

  const toml::table& root_;
  std::string name_;
  Places& places_;
  std::string section_;
  const toml::table* table_ = nullptr;
  std::map<std::string, std::vector<std::string>> known_;  // keys by section
  std::vector<std::string> top_level_;                     // keys before the first section
  std::vector<std::string> notices_;
  std::vector<std::pair<std::pair<toml::source_index, toml::source_index>, std::string>> problems_;
};

void load(const std::string& text, const std::string& name, Config& config, Places& places,
          std::vector<std::string>& problems) {
  try {
    const toml::table root = toml::parse(text, name);
    TomlLoader loader(root, name, places);
    visitConfig(config, loader);
    loader.checkUnknown();
    for (std::string& line : loader.takeProblems()) problems.push_back(std::move(line));
    for (const std::string& line : loader.notices()) config.notices.push_back(line);
  } catch (const toml::parse_error& error) {
    std::ostringstream line;
    line << name << ":" << error.source().begin.line << ":" << error.source().begin.column << ": "
         << error.description() << "; fix the TOML syntax there";
    problems.push_back(line.str());
  }
}

/// Takes the keys that do not go together, and why; the problem is placed at the first of them that was set.
using Complain = std::function<void(std::initializer_list<std::string> keys, const std::string& what)>;

void checkDevices(const Config& config, const Complain& complain) {
  if (config.lidar_device.model != LdsModel::kAuto && config.lidar_device.driver != LidarDriver::kLds) {
    complain({"lidar.model", "lidar.driver"}, "is of lidar.driver = \"lds\", but that is \"" +
                                                  std::string(wordOf(config.lidar_device.driver)) +
                                                  "\"; remove the one or change the other");
  }
  if (config.imu_device.driver == ImuDriver::kHandsfree && config.base_device.driver != BaseDriver::kHandsfree) {
    complain({"imu.driver", "base.driver"}, "\"handsfree\" means the base's board, but base.driver is \"" +
                                                std::string(wordOf(config.base_device.driver)) +
                                                "\"; set imu.driver to the gyro that there is, or to \"none\"");
  }
  if (config.imu_device.driver == ImuDriver::kBase && !config.base_device.hasGyro()) {
    complain({"imu.driver", "base.driver"},
             "\"base\" means the gyro of the base, but a base of base.driver = \"" +
                 std::string(wordOf(config.base_device.driver)) +
                 "\" has none; set imu.driver to the gyro that there is, or to \"none\"");
  }
  if (config.base_device.needsCounts() && !(config.base_device.counts_per_turn > 0.0)) {
    complain({"base.counts_per_turn", "base.driver"},
             "is not set, but such a base has no model that says it; set it to what the encoder counts in one turn of "
             "the wheel (enc_counts_per_rev of diffdrive_arduino; of a VESC 6 * pole pairs * gear)");
  }
  const bool any_type = config.base_device.driver == BaseDriver::kHandsfree ||
                        config.base_device.driver == BaseDriver::kLcm || config.base_device.driver == BaseDriver::kNone;
  if (!any_type && config.base_device.type != BaseType::kDifferential) {
    complain({"base.type", "base.driver"}, "\"" + std::string(wordOf(config.base_device.type)) +
                                               "\" has more wheels than the two of such a base; set it to "
                                               "\"differential\"");
  }
  const bool has_nodes =
      config.base_device.driver == BaseDriver::kCan || config.base_device.driver == BaseDriver::kVesc;
  if (has_nodes && config.can.left_node == config.can.right_node) {
    complain({"can.right_node", "can.left_node"}, "is the left wheel's, too; give each its own");
  }
  const bool is_vesc = config.can.protocol == can::Protocol::kVesc;
  if (config.base_device.driver == BaseDriver::kCan && is_vesc && config.can.pole_pairs == 0)
    complain({"can.pole_pairs", "can.protocol"}, "is not set; set it to half the magnets of the motor's rotor");
  for (const auto& [key, node] :
       {std::pair{"can.left_node", config.can.left_node}, {"can.right_node", config.can.right_node}}) {
    if (config.base_device.driver == BaseDriver::kCan && !is_vesc && node > can::odrive::kMaxNode)
      complain({key, "can.protocol"}, "is above 63, the greatest node of an ODrive");
  }
}

/// What no single key can be asked for. What has been refused by itself is not compared with anything.
void checkTogether(const Config& config, const std::string& name, const Places& places, const ServiceReach* reach,
                   std::vector<std::string>& problems) {
  const LidarModel& lidar = config.front_end.lidar;
  const std::string refused = join(problems, "\n");
  // Left out where one of the keys has been refused.
  const Complain complain = [&](std::initializer_list<std::string> keys, const std::string& what) {
    std::string place = name + ":1:1";
    for (auto key = std::rbegin(keys); key != std::rend(keys); ++key) {
      if (refused.find(": " + *key + ": ") != std::string::npos) return;
      if (const auto at = places.find(*key); at != places.end()) place = at->second;
    }
    problems.push_back(place + ": " + *keys.begin() + ": " + what);
  };
  if (reach != nullptr) {
    for (const ServiceReach::Problem& problem : reach->problemsOf(config))
      complain({problem.key}, problem.what + "; " + problem.fix);
  }
  if (lidar.range_min >= lidar.range_max) {
    complain({"lidar.range_min", "lidar.range_max"}, "is not below lidar.range_max; lower the one or raise the other");
  }
  checkDevices(config, complain);
  const DepthProjectionConfig& depth = config.depth_device.projection;
  const bool below = config.depth_device.isMounted() && depth.floor_clearance >= depth.extrinsics.z;
  if (depth.floor_clearance >= depth.robot_height || below) {
    complain({"depth.floor_clearance", "depth.robot_height", "depth.z"},
             "is not below depth.robot_height and depth.z; lower it");
  }
  if (depth.range_min >= depth.range_max) {
    complain({"depth.range_min", "depth.range_max"}, "is not below depth.range_max; lower the one or raise the other");
  }
  if (depth.median == 2) complain({"depth.median"}, "2 images have no median; use 1 or 3");
  try {
    parseUdpmUrl(config.lcm.url);
  } catch (const std::invalid_argument& problem) {
    complain({"lcm.url"}, problem.what());
  }
  if (config.runtime.socket.size() > LocalSocket::kLongestPath) {
    complain({"runtime.socket"}, "is longer than the " + std::to_string(LocalSocket::kLongestPath) +
                                     " bytes of a socket's path; shorten it");
  }
  if (config.web.needsToken() && !config.web.token.empty() && config.web.token.size() < WebConfig::kShortestToken) {
    complain({"web.token", "web.commands", "web.read"},
             "is shorter than " + std::to_string(WebConfig::kShortestToken) +
                 " characters, so that it could be guessed; set it, e.g. to what openssl rand -hex 16 prints, or "
                 "leave it empty for the one in web.token_file");
  }
  if (config.web.certificate.empty() != config.web.key.empty()) {
    complain({"web.certificate", "web.key"}, "belong together; set both, or none for one that slam-web makes");
  }
  if (config.lcm.pose_rate > config.runtime.estimator_rate) {
    complain({"lcm.pose_rate", "runtime.estimator_rate"},
             "is above runtime.estimator_rate; lower the one or raise the other");
  }
  if (config.base_device.mileage_rate + config.base_device.imu_rate + 1.0 > config.runtime.base_rate) {
    complain({"base.mileage_rate", "base.imu_rate", "runtime.base_rate"},
             "with base.imu_rate it is more than runtime.base_rate can ask for; lower one of them");
  }
  if (config.front_end.match.final_pair_distance > config.front_end.match.initial_pair_distance) {
    complain({"match.final_pair_distance", "match.initial_pair_distance"},
             "is above match.initial_pair_distance; lower the one or raise the other");
  }
}

/// @param error of opening the file
std::string fixOf(int error, const std::filesystem::path& file) {
  struct stat status {};
  const bool group_reads = error == EACCES && stat(file.c_str(), &status) == 0 && (status.st_mode & S_IRGRP) != 0;
  const group* readers = group_reads ? getgrgid(status.st_gid) : nullptr;
  if (readers != nullptr && status.st_gid != 0)
    return std::string("sudo usermod -aG ") + readers->gr_name + " $USER, and log in again";
  return "give the path of a config file (config/slamd.toml is a template)";
}

}  // namespace

std::span<const RetiredKey> retiredKeys() { return kRetired; }
std::span<const RenamedKey> renamedKeys() { return kRenamed; }

ConfigError::ConfigError(const std::vector<std::string>& problems) : std::runtime_error(join(problems, "\n")) {}

Config parseConfig(const std::string& text, const std::string& name, const std::vector<std::string>& overrides,
                   const ServiceReach* reach) {
  Config config;
  std::vector<std::string> problems;
  Places places;
  load(text, name, config, places, problems);
  for (const std::string& line : overrides) {
    if (line.find('=') == std::string::npos || line.find('\n') != std::string::npos) {
      problems.push_back("--set " + line + ":1:1: is not one setting; write section.key=value");
    } else {
      load(line, "--set " + line, config, places, problems);
    }
  }
  checkTogether(config, name, places, reach, problems);
  if (!problems.empty()) throw ConfigError(problems);
  return config;
}

std::vector<std::string> setFrom(const std::string& text, const std::string& name, Config& config) {
  Config changed = config;
  std::vector<std::string> problems, keys;
  Places places;
  load(text, name, changed, places, problems);
  if (!problems.empty()) throw ConfigError(problems);
  config = changed;
  for (const auto& [key, place] : places) keys.push_back(key);
  return keys;
}

Config loadConfig(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                  const ServiceReach* reach) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  const int error = errno;
  if (!in || std::filesystem::is_directory(file)) {
    throw ConfigError({file.string() + ":1:1: cannot read: " + (error != 0 ? std::strerror(error) : "is it a file?") +
                       "; " + fixOf(error, file)});
  }
  return parseConfig(text.str(), file.string(), overrides, reach);
}

}  // namespace slam
