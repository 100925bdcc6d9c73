// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <chrono>
#include <filesystem>
#include <optional>
#include <slam/ack_t.hpp>
#include <slam/health_t.hpp>
#include <slam/problems_t.hpp>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"

namespace slam {

// Where the service has what its configuration does not place.
inline constexpr const char *kServiceSocket = "/run/slamd/socket", *kServiceMaps = "/var/lib/slamd/maps",
                            *kServiceLog = "/var/lib/slamd/log";

/// slamd's answer to a command.
struct Acknowledged : ack_t {
  Acknowledged(ack_t ack = {}, std::vector<problem_t> rows = {}) : ack_t(std::move(ack)), parts(std::move(rows)) {}
  std::vector<problem_t> parts;  ///< rows of slamd's tables that its message is made of; empty: of none
};

/// Where slamd listens that runs with this configuration; empty: nowhere.
/// @param file that it was read from
std::string socketOf(const Config& config, const std::filesystem::path& file);

/// A running slamd: over its local socket where that is there and may be opened, else over LCM. Each call finds its way
/// anew, so that a slamd that was started again is found, too, and a Remote that waits costs nothing.
class Remote {
 public:
  /// @param socket of slamd; empty: LCM alone @param url of LCM
  Remote(std::string socket, std::string url) : socket_(std::move(socket)), url_(std::move(url)) {}

  /// Sends a command and waits for its answer. @param pose [m, m, rad] of set_pose
  /// @return nothing when none came in time; silence() says what to look at
  /// @throws std::runtime_error where neither way is open
  std::optional<Acknowledged> ask(const std::string& verb, const std::string& argument,
                                  const std::array<double, 3>& pose, std::chrono::milliseconds limit);
  /// The next health message. @return, @throws as ask()
  std::optional<health_t> health(std::chrono::milliseconds limit);
  /// What came with it.
  const problems_t& problems() const { return problems_; }
  /// Of the last call, when nothing came: what was tried, and what to look at.
  const std::string& silence() const { return silence_; }

 private:
  const std::string socket_, url_;
  std::string silence_;
  problems_t problems_{};
};

}  // namespace slam
