// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <slam/command_t.hpp>
#include <span>
#include <string>
#include <string_view>

#include "app/bus/publisher.hpp"
#include "bus/local_socket.hpp"
#include "runtime/shared_value.hpp"

namespace slam {

/// Takes commands over LCM and the local socket, hands each to the thread that carries it out, and gives its answer to
/// who asked. Belongs to the bus thread.
class CommandDesk {
 public:
  CommandDesk(const Config& config, const BusEnds& ends, const WallClock& clock, Publisher& publisher);
  LocalSocket& socket() { return socket_; }
  /// What other threads have answered since.
  void answer();
  void report();
  Problem problem() const { return problem_.get(); }  ///< of the socket; from any thread

 private:
  /// Who sent a command, and its number there: two may choose the same.
  struct Asker {
    std::optional<LocalSocket::Client> client;  ///< none: it came over LCM
    std::int32_t id = 0;
  };
  struct Verb;
  static std::span<const Verb> verbs();

  void onCommand(Publisher::Bytes data, std::optional<LocalSocket::Client> from);
  /// @param prefix of the verbs that are named
  void refuseVerb(const command_t& command, std::string_view prefix);
  void setPose(const command_t& command);
  void saveFiles(const command_t& command);
  template <MapCommand::Kind kind>
  static void takeMap(CommandDesk& desk, const command_t& command);
  void changeMap(const MapCommand& command);
  void edit(const command_t& command, EditCommand edit);
  void changeLog(const LogCommand& command);
  void acknowledgeSave();
  /// @param ticket of the command, as ticketFor() gave it
  void acknowledge(std::int32_t ticket, bool accepted, const Answer& answer);
  std::int32_t ticketFor(const Asker& asker);

  const BusEnds& ends_;
  const WallClock& clock_;
  Publisher& publisher_;
  const std::string output_map_;  // prefix of its files; empty: none
  LocalSocket socket_;
  SharedValue<Problem> problem_;
  std::map<std::int32_t, Asker> asked_;  // by the tickets of commands that are not answered yet
  std::uint32_t next_ticket_ = 1;
  std::optional<std::int32_t> saving_;  // ticket of a save_map command that the mapper works on
};

}  // namespace slam
