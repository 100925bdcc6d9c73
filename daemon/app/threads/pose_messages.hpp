// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <bot_core/pose_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <vector>

#include "app/threads/thread_messages.hpp"
#include "bus/channels.hpp"
#include "bus/messages.hpp"

namespace slam {

template <typename Message>
void encode(const Message& message, std::vector<std::uint8_t>& into) {
  into.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(into.data(), 0, static_cast<int>(into.size()));
}

/// What is published of a pose: calls send(channel) for each message, which is in the buffer then. POSE has no field
/// for "not valid", so it is silent until there is a pose that is.
template <typename Send>
void encodeEach(const SentPose& pose, std::vector<std::uint8_t>& buffer, Send&& send) {
  encode(toMessage(pose.odometry, pose.utime), buffer);
  send(channel::kOdometry);
  encode(toMessage(pose.pose, pose.utime, pose.map_id), buffer);
  send(channel::kSlamPose);
  const LocalisationState state = pose.pose.state;
  if (state != LocalisationState::kLocalised && state != LocalisationState::kDegraded) return;
  encode(toPoseMessage(pose.pose, pose.utime), buffer);
  send(channel::kPose);
}

}  // namespace slam
