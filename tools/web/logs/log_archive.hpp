// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "tools/common/zip_writer.hpp"
#include "tools/web/logs/log_folder.hpp"

namespace slam {

/// All field logs as one zip file, made while it is sent: neither memory nor disk for it. Logs are compressed already,
/// and go in as they are, each with what it has when its turn comes.
class LogArchive {
 public:
  /// @param folder of runs, which are folders of files; the oldest file comes first
  explicit LogArchive(LogFolder folder);

  /// Sends the next part of at most 256 KiB and what the zip file needs around it.
  /// @return whether there is more @throws std::runtime_error where `sink` takes no more
  bool next(const ZipWriter::Sink& sink);

 private:
  bool openNext();

  LogFolder folder_;
  std::deque<std::vector<std::string>> files_;  // still to be sent: run, file
  std::shared_ptr<OpenFile> file_;              // that is being sent
  std::uint64_t sent_ = 0;                      // [bytes] of it
  const ZipWriter::Sink* sink_ = nullptr;       // of this call of next()
  ZipWriter zip_;
};

}  // namespace slam
