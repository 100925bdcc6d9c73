// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/logs/log_archive.hpp"

#include <algorithm>
#include <vector>

namespace slam {

LogArchive::LogArchive(LogFolder folder)
    : folder_(std::move(folder)),
      zip_([this](std::string_view bytes) { return (*sink_)(bytes); }, ZipWriter::Method::kStore) {
  const auto runs = folder_.list({}).value_or(std::vector<LogFolder::Entry>());
  for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
    if (!run->is_folder) continue;
    const auto files = folder_.list({run->name}).value_or(std::vector<LogFolder::Entry>());
    for (auto file = files.rbegin(); file != files.rend(); ++file)
      if (!file->is_folder) files_.push_back({run->name, file->name});
  }
}

bool LogArchive::next(const ZipWriter::Sink& sink) {
  sink_ = &sink;
  if (!file_ && !openNext()) {
    zip_.close();
    return false;
  }
  std::vector<char> part(std::min<std::uint64_t>(256 * 1024, file_->size() - sent_));
  const std::size_t got = part.empty() ? 0 : file_->read(sent_, part.data(), part.size());
  if (got == 0) {
    file_.reset();
    return true;
  }
  zip_.write({part.data(), got});
  sent_ += got;
  return true;
}

/// What was removed meanwhile is passed over.
bool LogArchive::openNext() {
  while (!files_.empty()) {
    const std::vector<std::string> parts = files_.front();
    files_.pop_front();
    file_ = folder_.open(parts);
    if (!file_) continue;
    sent_ = 0;
    zip_.begin(parts[0] + "/" + parts[1], file_->modified());
    return true;
  }
  return false;
}

}  // namespace slam
