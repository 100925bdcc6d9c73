// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "problems/answer.hpp"

/// Judges what a request brings, before anything is done about it. Pure.
namespace slam {

/// The host's name or address in a Host header, in lower case, without port and brackets.
/// @return std::nullopt for what is no such header
std::optional<std::string> hostOf(std::string_view header);

/// Names and addresses that this computer is reached by: localhost, its name (also with .local), its interfaces'
/// addresses, and `address` where it is a name or one address.
std::vector<std::string> ownNames(const std::string& address);

/// Whether two texts are equal, in a time that depends on the first one's length alone.
bool isSameSecret(std::string_view given, std::string_view secret);
/// The token of an Authorization header "Bearer TOKEN"; empty for any other.
std::string_view bearerOf(std::string_view authorization);

/// @return the number; std::nullopt for what is not one below 2^53
std::optional<std::uint64_t> versionOf(std::string_view text);

/// Parts of a path below /logs/: at most two names without a leading dot, of letters, digits, '.', '_', '-' and '+'.
/// @return std::nullopt for any other path; empty for the folder itself
std::optional<std::vector<std::string>> logPathOf(std::string_view path);

/// What the page may ask slamd to do.
struct WebCommand {
  std::string verb, argument;       ///< as of command_t
  std::array<double, 3> pose = {};  ///< [m, m, rad] of set_pose
};
/// @return std::nullopt, and why not, for a body that is no such command
std::optional<WebCommand> commandOf(const std::string& body, Answer& problem);

}  // namespace slam
