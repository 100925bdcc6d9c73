// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_manifest.hpp"

#include <sstream>

#include "store/durable_file.hpp"

namespace slam {
namespace {

constexpr int kVersion = 2, kWithoutEdits = 1;
constexpr std::string_view kSeal = "crc32 ";

std::string sealed(std::string_view lines) {
  return std::string(lines).append(kSeal).append(std::to_string(crc32Of(lines))) + "\n";
}

}  // namespace

std::string encodeManifest(const MapManifest& manifest) {
  std::ostringstream text;
  text << "slamd map\nversion " << (manifest.files.contains(kEditsFile) ? kVersion : kWithoutEdits) << "\nutime "
       << manifest.utime << "\nkeyframes " << manifest.keyframes << "\n";
  if (manifest.order > 0) text << "order " << manifest.order << "\n";
  for (const auto& [name, file] : manifest.files)
    text << "file " << name << " " << file.size << " " << file.crc << "\n";
  return sealed(text.str());
}

MapManifest decodeManifest(std::string_view text) {
  const std::string_view body = text.substr(0, text.rfind(kSeal));
  if (sealed(body) != text) throw std::runtime_error("is damaged (its CRC differs)");
  std::istringstream lines{std::string(body)};
  MapManifest manifest;
  int version = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "version") {
      words >> version;
    } else if (word == "utime") {
      words >> manifest.utime;
    } else if (word == "order") {
      words >> manifest.order;
    } else if (word == "keyframes") {
      words >> manifest.keyframes;
    } else if (word == "file") {
      std::string name;
      MapManifest::File file;
      if (words >> name >> file.size >> file.crc) manifest.files[name] = file;
    } else {
      continue;  // nothing that this format knows
    }
    if (!words) throw std::runtime_error("has a line without its value: " + line);
  }
  if (version > kVersion) {
    throw NewerMap("format " + std::to_string(version) + " is of a newer slamd, this one reads " +
                       std::to_string(kVersion) + "; update slamd",
                   manifest.order);
  }
  if (version < 1) throw std::runtime_error("names no format");
  return manifest;
}

}  // namespace slam
