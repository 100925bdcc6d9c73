// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus/command_desk.hpp"

#include <algorithm>
#include <charconv>
#include <slam/ack_t.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "core/plausibility.hpp"
#include "slam/edits/edit_json.hpp"

namespace slam {
namespace {

constexpr const char* kTooMany = "too many commands at once";

/// @throws std::runtime_error with one sentence where it is none
std::int32_t editIdOf(const std::string& text) {
  std::int32_t id = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, id);
  if (error != std::errc{} || rest != end) throw std::runtime_error("\"" + text + "\" is no number of an edit");
  return id;
}

}  // namespace

struct CommandDesk::Verb {
  std::string_view name;
  /// @throws std::runtime_error with one sentence where the command's argument cannot be
  void (*take)(CommandDesk& desk, const command_t& command);
};

CommandDesk::CommandDesk(const Config& config, const BusEnds& ends, const WallClock& clock, Publisher& publisher)
    : ends_(ends),
      clock_(clock),
      publisher_(publisher),
      output_map_(config.output.map),
      socket_(config.runtime.socket) {
  if (config.lcm.commands)
    publisher.link().subscribe(channel::kCommand, [this](Publisher::Bytes data) { onCommand(data, std::nullopt); });
  socket_.subscribe(channel::kCommand,
                    [this](LocalSocket::Client from, Publisher::Bytes data) { onCommand(data, from); });
  socket_.tend(monotonicNow());  // so that it is there when systemd hears that slamd is
}

void CommandDesk::answer() {
  acknowledgeSave();
  const auto acknowledge_all = [this](const MapAnswer& answer) {
    acknowledge(answer.id, answer.accepted, answer.message);
  };
  ends_.answers.drain(acknowledge_all);
  if (FieldLog* const log = publisher_.fieldLog()) log->answers().drain(acknowledge_all);
}

void CommandDesk::report() {
  ends_.counters.socket_clients = socket_.clients();
  ends_.counters.socket_bad = socket_.counts().bad;
  ends_.counters.socket_dropped = socket_.counts().dropped;
  ends_.counters.socket_refused = socket_.counts().refused;
  problem_.set(socket_.problem());
}

void CommandDesk::acknowledgeSave() {
  const SaveOutcome outcome = ends_.requests.saved;
  if (!saving_ || outcome == SaveOutcome::kNone) return;
  const bool saved = outcome == SaveOutcome::kSaved;
  acknowledge(*saving_, saved, saved ? "saved to " + output_map_ + ".yaml" : "not saved; the log says why");
  saving_.reset();
}

std::int32_t CommandDesk::ticketFor(const Asker& asker) {
  constexpr std::size_t kMostOpen = 256;  // more than all queues hold: those were never answered
  if (asked_.size() >= kMostOpen) asked_.erase(asked_.begin());
  const auto ticket = static_cast<std::int32_t>(next_ticket_++);
  asked_[ticket] = asker;
  return ticket;
}

void CommandDesk::acknowledge(std::int32_t ticket, bool accepted, const std::string& message) {
  if (!accepted) ++ends_.counters.refused_commands;
  const auto asked = asked_.extract(ticket);
  const Asker asker = asked ? asked.mapped() : Asker{std::nullopt, ticket};
  ack_t ack{};
  ack.utime = clock_.utime(monotonicNow());
  ack.id = asker.id;
  ack.accepted = accepted;
  ack.message = message;
  if (!asker.client) return publisher_.publish(channel::kAck, ack);
  std::vector<std::uint8_t> encoded;
  encode(ack, encoded);
  socket_.send(*asker.client, channel::kAck, encoded);
}

void CommandDesk::onCommand(Publisher::Bytes data, std::optional<LocalSocket::Client> from) {
  auto command = decodeChecked<command_t>(data);
  if (!command) {
    ++ends_.counters.bad_messages;
    return;
  }
  publisher_.record(channel::kCommand, data);
  command->id = ticketFor({from, command->id});
  const auto known = verbs();
  const auto verb = std::find_if(known.begin(), known.end(), [&](const Verb& v) { return v.name == command->verb; });
  const bool of_log = command->verb.starts_with("log_");
  if (of_log && publisher_.fieldLog() == nullptr)
    return acknowledge(command->id, false, "log.directory is not set in the configuration");
  if (verb == known.end())
    return refuseVerb(*command, of_log ? "log_" : command->verb.starts_with("map_") ? "map_" : "");
  try {
    verb->take(*this, *command);
  } catch (const std::runtime_error& error) {
    acknowledge(command->id, false, error.what());
  }
}

template <MapCommand::Kind kind>
void CommandDesk::takeMap(CommandDesk& desk, const command_t& command) {
  desk.changeMap({kind, command.id, command.argument});
}

std::span<const CommandDesk::Verb> CommandDesk::verbs() {
  using Desk = CommandDesk;
  using Command = command_t;
  static constexpr Verb kVerbs[] = {
      {"save", takeMap<MapCommand::kSave>},
      {"load", takeMap<MapCommand::kLoad>},
      {"rename", takeMap<MapCommand::kRename>},
      {"delete", takeMap<MapCommand::kDelete>},
      {"restore", takeMap<MapCommand::kRestore>},
      {"set_pose", [](Desk& desk, const Command& c) { desk.setPose(c); }},
      {"reset", takeMap<MapCommand::kReset>},
      {"mode",
       [](Desk& desk, const Command& c) {
         const bool slam = c.argument == "slam";
         if (!slam && c.argument != "localise") throw std::runtime_error("a mode is slam or localise");
         desk.changeMap({slam ? MapCommand::kSlam : MapCommand::kLocalise, c.id, ""});
       }},
      {"save_map", [](Desk& desk, const Command& c) { desk.saveFiles(c); }},
      {"log_start",
       [](Desk& desk, const Command& c) {
         desk.changeLog({LogCommand::kStart, c.id, c.argument});
       }},
      {"log_stop",
       [](Desk& desk, const Command& c) {
         desk.changeLog({LogCommand::kStop, c.id, c.argument});
       }},
      {"log_mark",
       [](Desk& desk, const Command& c) {
         if (c.argument.empty()) throw std::runtime_error("say what has happened: log_mark needs an argument");
         desk.changeLog({LogCommand::kMark, c.id, c.argument});
       }},
      {"map_edit", [](Desk& desk, const Command& c) { desk.edit(c, {.request = editRequestOf(c.argument)}); }},
      {"map_undo", [](Desk& desk, const Command& c) { desk.edit(c, {.kind = EditCommand::kUndo, .request = {}}); }},
      {"map_redo", [](Desk& desk, const Command& c) { desk.edit(c, {.kind = EditCommand::kRedo, .request = {}}); }},
      {"map_remove",
       [](Desk& desk, const Command& c) {
         desk.edit(c, {.kind = EditCommand::kRemove, .request = {}, .id = editIdOf(c.argument)});
       }},
      {"map_straighten", takeMap<MapCommand::kStraighten>},
  };
  return kVerbs;
}

void CommandDesk::refuseVerb(const command_t& command, std::string_view prefix) {
  std::string known;
  for (const Verb& verb : verbs())
    if (verb.name.starts_with(prefix)) known.append(known.empty() ? "" : ", ").append(verb.name);
  acknowledge(command.id, false, "unknown verb; known are " + known);
}

void CommandDesk::setPose(const command_t& command) {
  const Pose2 pose{command.pose[0], command.pose[1], command.pose[2]};
  if (const std::string words = implausibilityOf(pose); !words.empty())
    throw std::runtime_error(
        words + "; the pose stays as it was; give x and y in metres from the map's origin, theta in radians");
  const bool taken = ends_.commands.set_poses.tryPush({pose});
  acknowledge(command.id, taken, taken ? "pose set" : kTooMany);
}

void CommandDesk::saveFiles(const command_t& command) {
  if (output_map_.empty()) throw std::runtime_error("output.map is not set in the configuration");
  if (!command.argument.empty()) throw std::runtime_error("the place is output.map; give no argument");
  if (saving_) throw std::runtime_error("a map is being saved already");
  ends_.requests.saved = SaveOutcome::kNone;
  saving_ = command.id;
  ends_.requests.save = true;
}

/// The graph thread answers, unless it has no room.
void CommandDesk::changeMap(const MapCommand& command) {
  if (!ends_.commands.map.tryPush(command)) acknowledge(command.id, false, kTooMany);
}

void CommandDesk::edit(const command_t& command, EditCommand edit) {
  changeMap({MapCommand::kEdit, command.id, "", std::make_shared<const EditCommand>(std::move(edit))});
}

void CommandDesk::changeLog(const LogCommand& command) {
  if (!publisher_.fieldLog()->command(command)) acknowledge(command.id, false, kTooMany);
}

}  // namespace slam
