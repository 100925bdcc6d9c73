// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/stored_list.hpp"

#include <nlohmann/json.hpp>

#include "tools/slamctl/health_json.hpp"

namespace slam {

std::string StoredList::text(Timestamp now) const {
  const std::lock_guard lock(reading_);
  if (text_.empty() || now >= read_at_ + kAge) {
    text_ = textOf(read_(folder_));
    read_at_ = now;
  }
  return text_;
}

void StoredList::forget() const {
  const std::lock_guard lock(reading_);
  text_.clear();
}

}  // namespace slam
