// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/history/history_file.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "store/durable_file.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam {

HistoryFile::HistoryFile(const std::filesystem::path& folder) {
  if (!folder.empty()) file_ = folder / "history.json";
}

std::optional<DayHistory> HistoryFile::read() const {
  constexpr std::uintmax_t kLargest = 32 << 20;  // [bytes] ten times what the most happenings take
  if (file_.empty() || !std::filesystem::exists(file_)) return std::nullopt;
  std::ifstream in(file_, std::ios::binary);
  if (!in || std::filesystem::file_size(file_) > kLargest)
    throw std::runtime_error(file_.string() + ": cannot read it");
  auto history = historyOf(nlohmann::json::parse(in, nullptr, false));
  if (!history) throw std::runtime_error(file_.string() + ": it is damaged; the day begins anew");
  return history;
}

void HistoryFile::write(const DayHistory& history) const {
  if (file_.empty() || history.since() == 0) return;
  Replacement next(file_);
  writeDurably(next.draft(), textOf(historyJson(history)));
  next.putInPlace();
}

}  // namespace slam
