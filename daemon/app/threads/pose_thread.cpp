// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/pose_thread.hpp"

#include <poll.h>

#include "app/device_configs.hpp"
#include "app/threads/pose_messages.hpp"

namespace slam {
namespace {

constexpr int kWait = 100;                 // [ms] the longest wait for a request to stop
constexpr std::size_t kLargest = 1 << 12;  // [bytes] more than any of its messages

}  // namespace

PoseThread::PoseThread(const Config& config, const PoseEnds& ends, const WallClock& clock, LcmSender& sender)
    : ends_(ends), clock_(clock), sender_(sender), worker_(poseWorker(config), [this] { tick(); }) {
  buffer_.reserve(kLargest);
}

void PoseThread::tick() {
  pollfd waiting{ends_.wakeup.descriptor(), POLLIN, 0};
  ::poll(&waiting, 1, kWait);
  ends_.wakeup.clear();
  if (!ends_.pose.load(snapshot_)) return;
  SentPose pose{.pose = snapshot_.pose,
                .odometry = snapshot_.odometry,
                .map_id = snapshot_.map_id,
                .utime = clock_.utime(snapshot_.pose.stamp),
                .sent = monotonicNow(),
                .before = outcome_};
  ends_.sent.tryPush(pose);  // first: its copies come back over the network, and the bus thread must know them
  encodeEach(pose, buffer_, [this](const char* channel) {
    outcome_ = sender_.publish(channel, buffer_);
    ++(outcome_.sent ? ends_.counters.published : ends_.counters.failures);
  });
  if (snapshot_.scans != scans_published_) {
    scans_published_ = snapshot_.scans;
    ends_.scan_to_pose.add(monotonicNow() - snapshot_.scan_received);
  }
  ends_.bus_wakeup.notify();
}

}  // namespace slam
