// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus/command_desk.hpp"

#include <charconv>
#include <slam/ack_t.hpp>
#include <stdexcept>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "core/plausibility.hpp"
#include "slam/edits/edit_json.hpp"

namespace slam {
namespace {

/// @return std::nullopt for what is no command about the map, or no mode
std::optional<MapCommand> mapCommandOf(const command_t& command) {
  const std::string &verb = command.verb, &argument = command.argument;
  if (verb == "save") return MapCommand{MapCommand::kSave, command.id, argument};
  if (verb == "load") return MapCommand{MapCommand::kLoad, command.id, argument};
  if (verb == "reset") return MapCommand{MapCommand::kReset, command.id, argument};
  if (verb == "rename") return MapCommand{MapCommand::kRename, command.id, argument};
  if (verb == "delete") return MapCommand{MapCommand::kDelete, command.id, argument};
  if (verb == "restore") return MapCommand{MapCommand::kRestore, command.id, ""};
  if (verb == "mode" && argument == "slam") return MapCommand{MapCommand::kSlam, command.id, ""};
  if (verb == "mode" && argument == "localise") return MapCommand{MapCommand::kLocalise, command.id, ""};
  return std::nullopt;
}

/// @return std::nullopt for what is no command about edits
/// @throws std::runtime_error with one sentence where its argument cannot be
std::optional<MapCommand> editCommandOf(const command_t& command) {
  const std::string &verb = command.verb, &argument = command.argument;
  EditCommand edit;
  if (verb == "map_straighten") return MapCommand{MapCommand::kStraighten, command.id, argument};
  if (verb == "map_edit") {
    edit.request = editRequestOf(argument);
  } else if (verb == "map_remove") {
    edit.kind = EditCommand::kRemove;
    const char* const end = argument.data() + argument.size();
    const auto [rest, error] = std::from_chars(argument.data(), end, edit.id);
    if (error != std::errc{} || rest != end) throw std::runtime_error("\"" + argument + "\" is no number of an edit");
  } else if (verb == "map_undo" || verb == "map_redo") {
    edit.kind = verb == "map_undo" ? EditCommand::kUndo : EditCommand::kRedo;
  } else {
    return std::nullopt;
  }
  return MapCommand{MapCommand::kEdit, command.id, "", std::make_shared<const EditCommand>(std::move(edit))};
}

std::optional<LogCommand> logCommandOf(const command_t& command) {
  if (command.verb == "log_start") return LogCommand{LogCommand::kStart, command.id, command.argument};
  if (command.verb == "log_stop") return LogCommand{LogCommand::kStop, command.id, command.argument};
  if (command.verb == "log_mark") return LogCommand{LogCommand::kMark, command.id, command.argument};
  return std::nullopt;
}

}  // namespace

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
  const Pose2 pose{command->pose[0], command->pose[1], command->pose[2]};
  if (command->verb == "save_map") {
    if (output_map_.empty()) return acknowledge(command->id, false, "output.map is not set in the configuration");
    if (!command->argument.empty()) return acknowledge(command->id, false, "the place is output.map; give no argument");
    if (saving_) return acknowledge(command->id, false, "a map is being saved already");
    ends_.requests.saved = SaveOutcome::kNone;
    saving_ = command->id;
    ends_.requests.save = true;
  } else if (command->verb == "set_pose") {
    if (const std::string words = implausibilityOf(pose); !words.empty())
      return acknowledge(
          command->id, false,
          words + "; the pose stays as it was; give x and y in metres from the map's origin, theta in radians");
    const bool taken = ends_.commands.set_poses.tryPush({pose});
    acknowledge(command->id, taken, taken ? "pose set" : "too many commands at once");
  } else if (command->verb.starts_with("map_")) {
    onEdit(*command);
  } else if (const auto map_command = mapCommandOf(*command)) {
    const bool taken = ends_.commands.map.tryPush(*map_command);
    if (!taken) acknowledge(command->id, false, "too many commands at once");  // otherwise the graph thread answers
  } else if (command->verb == "mode") {
    acknowledge(command->id, false, "a mode is slam or localise");
  } else if (command->verb.starts_with("log_")) {
    onLogCommand(*command);
  } else {
    acknowledge(
        command->id, false,
        "unknown verb; known are save, load, rename, delete, restore, set_pose, reset, mode, save_map, log_start, "
        "log_stop, log_mark, map_edit, map_undo, map_redo, map_remove, map_straighten");
  }
}

void CommandDesk::onEdit(const command_t& command) {
  try {
    const auto wanted = editCommandOf(command);
    if (!wanted)
      return acknowledge(command.id, false,
                         "unknown verb; known are map_edit, map_undo, map_redo, map_remove, "
                         "map_straighten");
    const bool taken = ends_.commands.map.tryPush(*wanted);
    if (!taken) acknowledge(command.id, false, "too many commands at once");  // otherwise the graph thread answers
  } catch (const std::runtime_error& error) {
    acknowledge(command.id, false, error.what());
  }
}

void CommandDesk::onLogCommand(const command_t& command) {
  FieldLog* const log = publisher_.fieldLog();
  if (log == nullptr) return acknowledge(command.id, false, "log.directory is not set in the configuration");
  const auto wanted = logCommandOf(command);
  if (!wanted) return acknowledge(command.id, false, "unknown verb; known are log_start, log_stop, log_mark");
  if (wanted->kind == LogCommand::kMark && wanted->what.empty())
    return acknowledge(command.id, false, "say what has happened: log_mark needs an argument");
  if (!log->command(*wanted)) acknowledge(command.id, false, "too many commands at once");
}

}  // namespace slam
