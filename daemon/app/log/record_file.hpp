// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <utility>

#include "app/log/record_sink.hpp"
#include "store/durable_file.hpp"

namespace slam {

/// One file (output.record), or a pipe. What is in it already stays; readers find the seam, wherever it was cut.
class RecordFile final : public RecordSink {
 public:
  explicit RecordFile(std::filesystem::path path) : path_(std::move(path)) {}

  void write(std::string_view records, std::int64_t) override {
    if (file_ && !file_->isThere()) file_.reset();
    if (!file_) {
      if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path());
      file_.emplace(path_, AppendFile::kAll);
    }
    if (records.empty()) return;
    try {
      file_->append(records);
    } catch (const std::exception&) {
      file_.reset();  // its disk may come back as another one
      throw;
    }
  }
  Problem problemOf(const std::exception& error) const override {
    return {problem::kRecordNotWritten, {}, {"", "", error.what()}};
  }

 private:
  std::filesystem::path path_;
  std::optional<AppendFile> file_;
};

}  // namespace slam
