// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/ros_source.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>

namespace slam {
namespace {

/// "bag_2" before "bag_10".
bool byNumber(const std::filesystem::path& a, const std::filesystem::path& b) {
  const std::string s = a.filename().string(), t = b.filename().string();
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  for (std::size_t i = 0, k = 0; i < s.size() && k < t.size();) {
    if (!digit(s[i]) || !digit(t[k])) {
      if (s[i] != t[k]) return s[i] < t[k];
      ++i, ++k;
      continue;
    }
    std::size_t end_i = i, end_k = k;
    while (end_i < s.size() && digit(s[end_i])) ++end_i;
    while (end_k < t.size() && digit(t[end_k])) ++end_k;
    while (i + 1 < end_i && s[i] == '0') ++i;
    while (k + 1 < end_k && t[k] == '0') ++k;
    if (end_i - i != end_k - k) return end_i - i < end_k - k;
    const int order = s.compare(i, end_i - i, t, k, end_k - k);
    if (order != 0) return order < 0;
    i = end_i, k = end_k;
  }
  return s.size() < t.size();
}

}  // namespace

std::string rosTypeName(std::string type) {
  const std::size_t at = type.find("/msg/");
  if (at != std::string::npos) type.erase(at, 4);
  return type;
}

std::unique_ptr<RosSource> openRosFile(const std::filesystem::path& file) {
  using namespace std::string_view_literals;
  std::string begin(16, '\0');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  if (begin.starts_with("#ROSBAG V2.0\n")) return openRosBag(file);
  if (begin.starts_with("\x89MCAP0\r\n")) return openMcap(file);
  if (begin == "SQLite format 3\0"sv) return openDb3(file);
  return nullptr;
}

std::vector<std::filesystem::path> rosFiles(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    const std::string extension = entry.path().extension();
    if (extension == ".bag" || extension == ".active" || extension == ".db3" || extension == ".mcap") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end(), byNumber);
  return files;
}

}  // namespace slam
