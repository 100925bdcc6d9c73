// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <slam/ack_t.hpp>
#include <slam/health_t.hpp>
#include <string>

namespace slam {

/// A running slamd, over LCM.
class Remote {
 public:
  /// @throws std::runtime_error without a multicast route
  explicit Remote(const std::string& url);

  /// Sends a command and waits for its answer. @param pose [m, m, rad] of set_pose
  /// @return nothing when none came in time
  std::optional<ack_t> ask(const std::string& verb, const std::string& argument, const std::array<double, 3>& pose,
                           std::chrono::milliseconds limit);
  /// The next health message. @return nothing when none came in time
  std::optional<health_t> health(std::chrono::milliseconds limit);

 private:
  void onAck(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void onHealth(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  template <typename Done>
  void handleUntil(std::chrono::milliseconds limit, Done&& done);

  std::optional<lcm::LCM> lcm_;
  std::optional<ack_t> ack_;
  std::optional<health_t> health_;
};

}  // namespace slam
