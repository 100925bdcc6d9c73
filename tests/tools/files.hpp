// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <unistd.h>

#include "build_paths.hpp"

namespace slam::test {

/// A folder of its own for each test, removed with all that is in it.
class Folder {
 public:
  Folder() : path_(testing::TempDir() + "slamd_tools_" + std::to_string(getpid()) + "_" + std::to_string(++count)) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  /// A new file with this text.
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

 private:
  static inline int count = 0;
  std::filesystem::path path_;
};

inline std::string contentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in.good()) << file << " is missing";
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Recorded data of real robots, which not everybody has.
inline std::filesystem::path recorded(const std::string& name) {
  const char* folder = std::getenv("SLAMD_DATA");
  return (folder ? std::filesystem::path(folder) : std::filesystem::path(SLAMD_SOURCE_DIR) / "../shared/data") / name;
}

/// Message of what `body` throws; empty when it throws nothing.
template <typename Body>
std::string refusalOf(Body&& body) {
  try {
    body();
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace slam::test

#define SLAM_SKIP_WITHOUT(file) \
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "recorded data missing: " << (file) << " (set SLAMD_DATA)"
