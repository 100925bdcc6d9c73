// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/thread_use.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>

namespace slam {

std::optional<ThreadUse> threadUse(pid_t id, const std::filesystem::path& root) {
  const std::filesystem::path thread = root / "proc/self/task" / std::to_string(id);
  std::ifstream stat(thread / "stat"), times(thread / "schedstat");
  const std::string text{std::istreambuf_iterator<char>(stat), {}};
  const auto name_end = text.rfind(')');  // a name may hold brackets itself
  if (name_end == std::string::npos || name_end + 2 >= text.size()) return std::nullopt;
  ThreadUse use{.is_ready = text[name_end + 2] == 'R'};
  std::int64_t ran = 0, waited = 0;
  if (times >> ran >> waited) {
    use.ran = Duration(ran);
    use.waited = Duration(waited);
  }
  return use;
}

Duration starvedBetween(const ThreadUse& before, const ThreadUse& now, Duration step) {
  const Duration under_way = now.is_ready ? step - (now.ran - before.ran) : Duration(0);
  return std::clamp(std::max(now.waited - before.waited, under_way), Duration(0), step);
}

void BlockedTime::begin(Timestamp now) {
  const pid_t thread = gettid();
  const auto use = threadUse(thread);
  since_ns_ = 0;  // who looks meanwhile sees no work rather than a wrong time
  thread_ = thread;
  used_ns_ = use ? (use->ran + use->waited).count() : 0;
  since_ns_ = now.time_since_epoch().count();
}

Duration BlockedTime::until(Timestamp now) const {
  const std::int64_t since = since_ns_;
  if (since == 0) return Duration(0);
  const Duration used_before(used_ns_);
  const auto use = threadUse(thread_);
  if (since_ns_ != since || !use || use->is_ready) return Duration(0);
  return std::max(now - Timestamp(Duration(since)) - (use->ran + use->waited - used_before), Duration(0));
}

}  // namespace slam
