// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/rplidar_dialogue.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace slam::rplidar {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostInput = 8192;    // [bytes] of an old stream that are searched for an answer
constexpr std::uint32_t kMostAnswer = 256;  // [bytes] of a single answer
constexpr std::ptrdiff_t kMostRecent = 2048;
constexpr Duration kCancelPeriod = 100ms;  // the longest that a request to stop waits

}  // namespace

/// One read into the input. @return false when nothing came, or the port is gone
bool Dialogue::read(Duration timeout) {
  std::array<std::uint8_t, 1024> chunk;
  const ReadResult result = stream_.read(chunk, std::clamp<Duration>(timeout, 0ns, kCancelPeriod));
  if (result.status == ReadResult::kClosed) hung_up_ = true;
  for (std::size_t i = 0; i < result.size; ++i) {
    saw_boot_ = boot_text_.push(chunk[i]) || saw_boot_;
    saw_boot_end_ = boot_end_text_.push(chunk[i]) || saw_boot_end_;
    input_.push_back(chunk[i]);
  }
  bytes_ = bytes_ || result.size > 0;
  recent_.insert(recent_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(result.size));
  if (std::ssize(recent_) > kMostRecent) recent_.erase(recent_.begin(), recent_.end() - kMostRecent);
  return result.size > 0;
}

template <typename Accept>
std::optional<Descriptor> Dialogue::awaitDescriptor(Timestamp end, const Accept& accept) {
  for (;;) {
    std::size_t at = 0;
    for (; at + kDescriptorSize <= input_.size(); ++at) {
      const auto found = parseDescriptor({input_.data() + at, kDescriptorSize});
      if (!found || !accept(*found)) continue;
      input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(at + kDescriptorSize));
      return found;
    }
    if (input_.size() > kMostInput) input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(at));
    const Duration left = end - now_();
    if (left <= 0ns || cancelled() || hung_up_) return std::nullopt;
    read(left);
  }
}

std::vector<std::uint8_t> Dialogue::ask(std::span<const std::uint8_t> request, AnswerType type, std::size_t size,
                                        Duration timeout) {
  const Timestamp end = now_() + timeout;
  input_.clear();
  if (!send(request)) return {};
  const auto descriptor = awaitDescriptor(end, [&](const Descriptor& d) {
    return d.type == static_cast<std::uint8_t>(type) && !d.stream &&
           (size == 0 ? d.length <= kMostAnswer : d.length == size);
  });
  if (!descriptor) return {};
  while (input_.size() < descriptor->length) {
    const Duration left = end - now_();
    if (left <= 0ns || cancelled() || hung_up_) return {};
    read(left);
  }
  std::vector<std::uint8_t> answer = takeInput();
  answer.resize(descriptor->length);
  return answer;
}

std::optional<Descriptor> Dialogue::awaitStream(Duration timeout) {
  return awaitDescriptor(now_() + timeout, [](const Descriptor& d) { return d.stream && d.type >= 0x80; });
}

void Dialogue::drain(Duration silence, Duration limit) {
  const Timestamp end = now_() + limit;
  for (Timestamp quiet = now_() + silence; now_() < std::min(end, quiet) && !cancelled() && !hung_up_;) {
    if (read(std::min(end, quiet) - now_())) quiet = now_() + silence;
    input_.clear();
  }
}

bool Dialogue::awaitBoot(Duration timeout) {
  const Timestamp end = now_() + timeout;
  for (saw_boot_end_ = false; !saw_boot_end_ && now_() < end && !cancelled() && !hung_up_;) {
    read(end - now_());
    input_.clear();
  }
  return saw_boot_end_;
}

}  // namespace slam::rplidar
