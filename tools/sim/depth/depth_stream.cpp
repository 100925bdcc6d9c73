// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_stream.hpp"

#include <algorithm>
#include <cstring>
#include <random>

namespace slam::sim {
namespace {

double uniform(std::uint64_t seed, double low, double high) {
  std::mt19937_64 random(seed);
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace

DepthStream::DepthStream(const World& world, const DepthMode& mode, std::uint64_t seed, Timestamp start,
                         Viewpoint viewpoint)
    : world_(world),
      mode_(mode),
      seed_(seed),
      start_(start),
      viewpoint_(std::move(viewpoint)),
      camera_(mode.width, mode.height, seed),
      drift_(uniform(seed ^ 0xA0761D6478BD642FULL, -kMaxDrift, kMaxDrift)) {}

std::uint64_t DepthStream::deviceTime(std::uint32_t frame) const {
  return static_cast<std::uint64_t>(frame) * 1000000U / static_cast<std::uint64_t>(mode_.rate);
}

Timestamp DepthStream::captureTime(std::uint32_t frame) const {
  return start_ + fromSeconds(1e-6 * static_cast<double>(deviceTime(frame)) / (1.0 + drift_));
}

DepthStream::Frame DepthStream::encode(Timestamp captured) const {
  DepthFrameHeader header;
  header.width = static_cast<std::uint32_t>(mode_.width);
  header.height = static_cast<std::uint32_t>(mode_.height);
  header.frame = frame_;
  header.time = deviceTime(frame_);
  header.size = static_cast<std::uint32_t>(image_.depth.size() * sizeof(std::uint16_t));
  header.horizontal_fov = kDepthHorizontalFov;
  header.vertical_fov = kDepthVerticalFov;
  const double share = uniform(seed_ ^ (0x8EBC6AF09C88C6E3ULL * frame_), 0.0, 1.0);
  Frame frame{captured + kMinDelay + fromSeconds(share * toSeconds(kMaxDelay - kMinDelay)), {}};
  frame.bytes.resize(sizeof header + header.size);
  std::memcpy(frame.bytes.data(), &header, sizeof header);
  std::memcpy(frame.bytes.data() + sizeof header, image_.depth.data(), header.size);
  return frame;
}

void DepthStream::capture(Timestamp now) {
  while (captureTime(frame_ + 1) + kLag < now) ++frame_;
  const Timestamp captured = captureTime(frame_);
  if (now < captured + kLag) return;
  const auto viewpoint = viewpoint_(captured);
  retry_ = viewpoint ? Timestamp::min() : now + kRetry;
  if (!viewpoint) return;
  world_.setTime(viewpoint->drive_time);
  camera_.capture(world_, viewpoint->T_world_base, frame_, captured, image_);
  if (waiting_.size() == kPending) waiting_.pop_front();
  waiting_.push_back(encode(captured));
  ++frame_;
}

std::vector<std::uint8_t> DepthStream::take(Timestamp now) {
  if (waiting_.empty() || now < waiting_.front().due) return {};
  std::vector<std::uint8_t> bytes = std::move(waiting_.front().bytes);
  waiting_.pop_front();
  return bytes;
}

Timestamp DepthStream::next() const {
  const Timestamp capture = std::max(captureTime(frame_) + kLag, retry_);
  return waiting_.empty() ? capture : std::min(capture, waiting_.front().due);
}

}  // namespace slam::sim
