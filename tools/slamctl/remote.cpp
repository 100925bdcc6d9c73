// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/remote.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <stdexcept>
#include <unistd.h>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/local_client.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "config/service_reach.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Why a socket cannot be opened, and the fix.
std::string wordsOf(int error, const std::string& path) {
  switch (error) {
    case ENOENT:
      return "there is no " + path + ": slamd does not run, or has another runtime.socket (systemctl status slamd)";
    case ECONNREFUSED:
      return "nobody listens on " + path + ": slamd has ended (journalctl -u slamd -n 50)";
    case EACCES:
      return "no right to open " + path + ": sudo usermod -aG " + LocalClient::kGroup + " $USER, and log in again";
    case EAGAIN:
      return path + " takes nobody in: slamd hangs (journalctl -u slamd -n 50)";
    default:
      return path + ": " + std::strerror(error);
  }
}

/// One question to slamd, over the way that is open.
class Call {
 public:
  /// @throws std::runtime_error where neither way is
  Call(const std::string& socket, const std::string& url) : socket_(socket), link_(url) {
    subscribe<ack_t>(channel::kAck, ack);
    subscribe<problems_t>(channel::kAnswer, parts);
    subscribe<health_t>(channel::kHealth, health);
    subscribe<problems_t>(channel::kProblems, problems);
    const int error = socket.empty() ? 0 : local_.open(socket);
    if (local_.isOpen()) return;
    if (error != 0) not_local_ = wordsOf(error, socket) + "; and ";
    link_.tend(monotonicNow());
    refuseFault();
  }

  bool send(const std::string& channel, Bytes data) {
    return local_.isOpen() ? local_.send(channel, data) : link_.publish(channel, data, monotonicNow());
  }
  /// @throws std::runtime_error where the way is closed before the condition holds
  template <typename Done>
  void handleUntil(std::chrono::milliseconds limit, Done&& done) {
    const Timestamp end = monotonicNow() + limit;
    while (!done() && monotonicNow() < end) local_.isOpen() ? receiveLocally() : receiveOverLcm();
    if (!done() && !local_.isOpen()) refuseFault();
  }
  std::string silence() const {
    if (local_.isOpen())
      return "no answer on " + socket_ + ": slamd hangs or is overloaded (journalctl -u slamd -n 50)";
    const std::string lcm = "no slamd answers on " + link_.url().text;
    return not_local_.empty() ? lcm + "; is it running (systemctl status slamd)? commands need lcm.commands = true"
                              : not_local_ + lcm;
  }

  std::optional<ack_t> ack;
  std::optional<health_t> health;
  std::optional<problems_t> problems, parts;

 private:
  static constexpr std::chrono::milliseconds kLongestWait{100};  // after it, the link is tended

  template <typename Message>
  void subscribe(const char* channel, std::optional<Message>& last) {
    const auto keep = [&last](Bytes data) {
      if (auto message = decodeChecked<Message>(data)) last = std::move(*message);
    };
    link_.subscribe(channel, keep);
    dispatcher_.subscribe(channel, keep);
  }
  void refuseFault() const {
    const LinkState state = link_.state(monotonicNow());
    if (!isFault(state)) return;
    const Problem why = problemOf(state, link_.url());
    throw std::runtime_error(not_local_ + link_.url().text + ": LCM: " + why.cause() + "; fix: " + why.fix());
  }
  void receiveLocally() {
    if (const auto packet = local_.next(kLongestWait)) dispatcher_.take(*packet);
    if (!local_.isOpen())
      throw std::runtime_error(socket_ + ": slamd closed the connection: it ends, or has too many clients");
  }
  void receiveOverLcm() {
    link_.tend(monotonicNow());
    pollfd waiting{link_.descriptor(), POLLIN, 0};
    ::poll(&waiting, 1, static_cast<int>(kLongestWait.count()));
    link_.receive();
  }

  const std::string& socket_;
  LocalClient local_;
  std::string not_local_;        // why the socket is not the way, and the fix
  PacketDispatcher dispatcher_;  // of what comes over the socket
  LcmLink link_;
};

}  // namespace

std::string socketOf(const Config& config, const std::filesystem::path& file) {
  if (!config.runtime.socket.empty()) return config.runtime.socket;
  return isServiceConfig(file) ? kServiceSocket : "";
}

std::optional<Acknowledged> Remote::ask(const std::string& verb, const std::string& argument,
                                        const std::array<double, 3>& pose, std::chrono::milliseconds limit) {
  Call call(socket_, url_);
  command_t command{};
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  command.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  command.id = static_cast<std::int32_t>((command.utime / 1000) ^ (::getpid() << 8)) & 0x7FFFFFFF;
  command.verb = verb;
  command.argument = argument;
  std::copy(pose.begin(), pose.end(), command.pose);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(command.getEncodedSize()));
  command.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  if (!call.send(channel::kCommand, bytes)) {
    throw std::runtime_error("the command could not be sent; slamctl doctor looks for the cause");
  }
  const auto answered = [&] { return call.ack && call.ack->id == command.id; };
  call.handleUntil(limit, answered);
  silence_ = call.silence();
  if (!answered()) return std::nullopt;
  const bool has_parts = call.parts && call.parts->utime == call.ack->utime;
  return Acknowledged(*call.ack, has_parts ? call.parts->problems : std::vector<problem_t>());
}

std::optional<health_t> Remote::health(std::chrono::milliseconds limit) {
  Call call(socket_, url_);
  call.handleUntil(limit, [&] { return call.health.has_value(); });
  problems_ = call.problems.value_or(problems_t{});
  silence_ = call.silence();
  return call.health;
}

}  // namespace slam
