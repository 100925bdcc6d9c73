// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/timestamp.hpp"

namespace slam {

/// A list of what lies in a folder, as JSON. It is read when somebody asks, by one thread at a time and no more often
/// than each 10 s, however many ask. Safe from several threads.
class StoredList {
 public:
  static constexpr Duration kAge = std::chrono::seconds(10);
  using Read = std::function<nlohmann::json(const std::filesystem::path& folder)>;

  /// @param folder empty: there is none
  StoredList(std::filesystem::path folder, Read read) : folder_(std::move(folder)), read_(std::move(read)) {}

  bool isThere() const { return !folder_.empty(); }
  /// @throws std::runtime_error where the folder cannot be read
  std::string text(Timestamp now) const;
  /// What lies there has changed: the next one who asks gets it.
  void forget() const;

 private:
  std::filesystem::path folder_;
  Read read_;
  mutable std::mutex reading_;  // of the two below
  mutable std::string text_;
  mutable Timestamp read_at_{};
};

}  // namespace slam
