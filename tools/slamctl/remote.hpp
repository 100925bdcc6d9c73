// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <chrono>
#include <optional>
#include <slam/ack_t.hpp>
#include <slam/health_t.hpp>
#include <string>

#include "bus/lcm_link.hpp"

namespace slam {

/// A running slamd, over LCM.
class Remote {
 public:
  /// @throws std::runtime_error where nothing can be sent
  explicit Remote(const std::string& url);

  /// Sends a command and waits for its answer. @param pose [m, m, rad] of set_pose
  /// @return nothing when none came in time
  /// @throws std::runtime_error where the network did not let it through
  std::optional<ack_t> ask(const std::string& verb, const std::string& argument, const std::array<double, 3>& pose,
                           std::chrono::milliseconds limit);
  /// The next health message. @return nothing when none came in time
  std::optional<health_t> health(std::chrono::milliseconds limit);

 private:
  /// @throws std::runtime_error with the cause, where the link has one
  void refuseFault() const;
  template <typename Done>
  void handleUntil(std::chrono::milliseconds limit, Done&& done);

  LcmLink link_;
  std::optional<ack_t> ack_;
  std::optional<health_t> health_;
};

}  // namespace slam
