// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/convert/text_file.hpp"

namespace slam {

enum class RosEncoding { kRos1, kCdr, kOther };

/// A topic of a bag, as the bag describes it.
struct RosTopic {
  std::string name = {};
  std::string type = {};        ///< package/Type, without the "msg" that ROS 2 writes between
  std::string definition = {};  ///< text of the message and of those in it; empty: not in the bag
  std::string md5 = {};         ///< of ROS 1; empty or "*": not in the bag
  std::string publisher = {};   ///< node of ROS 1; empty: not in the bag
  RosEncoding encoding = RosEncoding::kOther;
  std::string remark = {};  ///< why its messages cannot be read; empty: they can
};

struct RosMessage {
  const RosTopic* topic = nullptr;     ///< lives as long as the source
  std::int64_t received = 0;           ///< [us since the epoch] by the recorder
  std::span<const std::uint8_t> data;  ///< until the next one
};

/// Messages of a bag in the order of the file. A damaged part is left out and counted; what is behind it is read.
class RosSource {
 public:
  explicit RosSource(const std::filesystem::path& file)
      : name_(file.filename().string()), most_unpacked_(mostUnpacked(std::filesystem::file_size(file))) {}
  virtual ~RosSource() = default;
  /// @return false at the end
  /// @throws std::runtime_error where a small file unpacks to more than anybody recorded
  virtual bool next(RosMessage& message) = 0;
  int damages() const { return damages_; }
  const std::string& firstDamage() const { return first_damage_; }  ///< where and what

 protected:
  const std::string& name() const { return name_; }
  /// So many bytes more were unpacked.
  void countUnpacked(std::size_t bytes) {
    unpacked_ += bytes;
    if (unpacked_ > most_unpacked_)
      throw std::runtime_error(name_ + ": unpacks to more than 200 times its size, which no recording does");
  }
  void damage(const std::string& what) {
    if (damages_++ == 0) first_damage_ = what;
  }

 private:
  std::string name_;
  std::uint64_t most_unpacked_, unpacked_ = 0;  // [bytes]
  int damages_ = 0;
  std::string first_damage_;
};

inline constexpr std::size_t kMostTopics = 10000;  ///< of a bag; more are damage

/// package/Type of "package/msg/Type".
std::string rosTypeName(std::string type);

/// Bag of ROS 1, format 2.0, plain, bz2 or lz4. Read from front to end, so that it needs no index.
std::unique_ptr<RosSource> openRosBag(const std::filesystem::path& file);
/// Bag of ROS 2 in SQLite.
std::unique_ptr<RosSource> openDb3(const std::filesystem::path& file);
/// MCAP, plain, lz4 or zstd. Read from front to end, so that it needs no index.
std::unique_ptr<RosSource> openMcap(const std::filesystem::path& file);

/// A bag of any of these kinds, recognised by its content; nullptr: it is none.
/// @throws std::runtime_error when it cannot be opened
std::unique_ptr<RosSource> openRosFile(const std::filesystem::path& file);

/// The files of a bag: itself, or those of a folder in the order of their numbers.
std::vector<std::filesystem::path> rosFiles(const std::filesystem::path& path);

}  // namespace slam
