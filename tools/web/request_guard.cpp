// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/request_guard.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cctype>
#include <charconv>
#include <cmath>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/plausibility.hpp"
#include "problems/answers.hpp"
#include "store/map_store.hpp"
#include "tools/web/maps/map_request.hpp"

namespace slam {
namespace {

bool isLetterOrDigit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

bool isPort(std::string_view text) {
  return !text.empty() && text.size() <= 5 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool isFileName(std::string_view name) {
  const auto allowed = [](char c) { return isLetterOrDigit(c) || c == '.' || c == '_' || c == '-' || c == '+'; };
  return !name.empty() && name.size() <= 128 && name.front() != '.' && std::all_of(name.begin(), name.end(), allowed);
}

}  // namespace

std::optional<std::string> hostOf(std::string_view header) {
  std::string_view name = header;
  if (header.starts_with('[')) {
    const auto end = header.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    name = header.substr(1, end - 1);
    const std::string_view rest = header.substr(end + 1);
    if (!rest.empty() && (rest.front() != ':' || !isPort(rest.substr(1)))) return std::nullopt;
    in6_addr address{};
    if (inet_pton(AF_INET6, std::string(name).c_str(), &address) != 1) return std::nullopt;
  } else if (const auto colon = header.find(':'); colon != std::string_view::npos) {
    name = header.substr(0, colon);
    if (!isPort(header.substr(colon + 1))) return std::nullopt;
  }
  const auto allowed = [](char c) { return isLetterOrDigit(c) || c == '.' || c == '-' || c == '_' || c == ':'; };
  if (name.empty() || name.size() > 255 || !std::all_of(name.begin(), name.end(), allowed)) return std::nullopt;
  return lowerCase(name);
}

std::vector<std::string> ownNames(const std::string& address) {
  std::vector<std::string> names = {"localhost", "127.0.0.1", "::1"};
  if (address != "0.0.0.0" && address != "::") names.push_back(lowerCase(address));  // those mean "all", and name none
  char name[256] = {};
  if (gethostname(name, sizeof name - 1) == 0 && *name != '\0') {
    names.push_back(lowerCase(name));
    names.push_back(lowerCase(name) + ".local");
  }
  ifaddrs* interfaces = nullptr;
  if (getifaddrs(&interfaces) != 0) return names;
  for (const ifaddrs* i = interfaces; i != nullptr; i = i->ifa_next) {
    const int family = i->ifa_addr != nullptr ? i->ifa_addr->sa_family : AF_UNSPEC;
    if (family != AF_INET && family != AF_INET6) continue;
    const socklen_t size = family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
    char text[NI_MAXHOST];
    if (getnameinfo(i->ifa_addr, size, text, sizeof text, nullptr, 0, NI_NUMERICHOST) != 0) continue;
    const std::string_view whole(text);
    names.emplace_back(whole.substr(0, whole.find('%')));  // without the interface of a link-local address
  }
  freeifaddrs(interfaces);
  return names;
}

bool isSameSecret(std::string_view given, std::string_view secret) {
  if (secret.empty()) return false;
  unsigned difference = given.size() == secret.size() ? 0U : 1U;
  for (std::size_t i = 0; i < given.size(); ++i) {
    difference |= static_cast<unsigned>(static_cast<unsigned char>(given[i]) ^
                                        static_cast<unsigned char>(secret[i % secret.size()]));
  }
  return difference == 0;
}

std::string_view bearerOf(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  return authorization.starts_with(kScheme) ? authorization.substr(kScheme.size()) : std::string_view();
}

std::optional<std::uint64_t> versionOf(std::string_view text) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 53;  // what the page counts to
  std::uint64_t version = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), version);
  const bool whole = error == std::errc() && end == text.data() + text.size() && version < kMost;
  return whole ? std::optional(version) : std::nullopt;
}

std::optional<std::vector<std::string>> logPathOf(std::string_view path) {
  constexpr std::string_view kRoot = "/logs/";
  constexpr std::size_t kDeepest = 2;  // a run's folder and its file
  if (!path.starts_with(kRoot)) return std::nullopt;
  path.remove_prefix(kRoot.size());
  std::vector<std::string> parts;
  while (!path.empty()) {
    const auto end = std::min(path.find('/'), path.size());
    if (parts.size() == kDeepest || !isFileName(path.substr(0, end))) return std::nullopt;
    parts.emplace_back(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return parts;
}

std::optional<WebCommand> commandOf(const std::string& body, Answer& problem) {
  using nlohmann::json;
  constexpr std::size_t kLongestMark = 200;
  const json request = json::parse(body, nullptr, false);
  const auto textAt = [&](const char* key) {
    const auto at = request.find(key);
    return at != request.end() && at->is_string() ? at->get<std::string>() : std::string();
  };
  if (!request.is_object()) {
    problem = {"the body is not a JSON object"};
    return std::nullopt;
  }
  WebCommand command{.verb = textAt("verb"), .argument = ""};
  if (command.verb == "save") {
    command.argument = textAt("name");
    if (command.argument.empty() || MapStore::isName(command.argument)) return command;
    problem = answerOf({{answer::kNoMapName, {}, {command.argument}}});
  } else if (command.verb == "set_pose") {
    const char* const keys[] = {"x", "y", "theta"};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = request.find(keys[i]);
      command.pose[i] = at != request.end() && at->is_number() ? at->get<double>() : std::nan("");
    }
    if (std::any_of(command.pose.begin(), command.pose.end(), [](double value) { return std::isnan(value); })) {
      problem = {"\"x\", \"y\" [m] and \"theta\" [rad] are not three numbers"};
      return std::nullopt;
    }
    const std::string words = implausibilityOf({command.pose[0], command.pose[1], command.pose[2]});
    if (words.empty()) return command;
    problem = answerOf({{answer::kPoseAbsurd, {}, {words}}});
  } else if (command.verb == "mode") {
    command.argument = textAt("mode");
    if (command.argument == "localise" || command.argument == "slam") return command;
    problem = {"\"mode\" is not localise or slam"};
  } else if (command.verb == "log_mark") {
    command.argument = textAt("text");
    const bool sound = !command.argument.empty() && command.argument.size() <= kLongestMark &&
                       std::none_of(command.argument.begin(), command.argument.end(),
                                    [](char c) { return static_cast<unsigned char>(c) < 0x20; });
    if (sound) return command;
    problem = {"\"text\" is not one line of 1 to 200 bytes"};
  } else if (const auto of_maps = mapRequestOf(request, command.verb, problem); of_maps || !problem.words.empty()) {
    return of_maps;
  } else {
    problem = {"unknown verb; known are save, set_pose, mode, log_mark, and those of maps and edits (docs/api.md)"};
  }
  return std::nullopt;
}

}  // namespace slam
