// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/ros_source.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

namespace slam {
namespace {

/// A name by which "bag_2" lies before "bag_10": each number of it with as many digits.
std::string inOrder(const std::filesystem::path& file) {
  constexpr std::size_t kDigits = 20;
  const std::string name = file.filename().string();
  std::string key;
  for (std::size_t i = 0; i < name.size();) {
    const std::size_t end = std::min(name.find_first_not_of("0123456789", i), name.size());
    key += std::string(end > i && end - i < kDigits ? kDigits - (end - i) : 0, '0') + name.substr(i, end - i);
    i = end;
    if (i < name.size()) key += name[i++];
  }
  return key;
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
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return std::pair(inOrder(a), a) < std::pair(inOrder(b), b); });
  return files;
}

}  // namespace slam
