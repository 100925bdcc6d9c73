// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/log/storage_report.hpp"
#include "app/log/trouble_log.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// Watches whatever is kept on a disk.
class StorageWatch {
 public:
  void add(const char* name, std::function<StorageReport(Timestamp)> report) {
    stored_.push_back({.name = name, .report = std::move(report)});
  }
  /// What is not stored, and which disk hangs.
  std::vector<Trouble> troubles(Timestamp now) const;

 private:
  struct Stored {
    const char* name;
    std::function<StorageReport(Timestamp)> report;
  };
  std::vector<Stored> stored_;
};

}  // namespace slam
