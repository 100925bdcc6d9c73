// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus/command_desk.hpp"

#include <algorithm>
#include <charconv>
#include <slam/ack_t.hpp>
#include <slam/problems_t.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/problem_message.hpp"
#include "core/plausibility.hpp"
#include "problems/answers.hpp"
#include "slam/edits/edit_json.hpp"

namespace slam {
namespace {

/// @throws std::runtime_error with one sentence where it is none
std::int32_t editIdOf(const std::string& text) {
  std::int32_t id = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, id);
  if (error != std::errc{} || rest != end) throw CommandRefused({answer::kNoEditNumber, {}, {text}});
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
    acknowledge(answer.id, answer.accepted, answer.answer);
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
  acknowledge(*saving_, saved, answerOf({{saved ? answer::kFilesSaved : answer::kFilesNotSaved, {}, {output_map_}}}));
  saving_.reset();
}

std::int32_t CommandDesk::ticketFor(const Asker& asker) {
  constexpr std::size_t kMostOpen = 256;  // more than all queues hold: those were never answered
  if (asked_.size() >= kMostOpen) asked_.erase(asked_.begin());
  const auto ticket = static_cast<std::int32_t>(next_ticket_++);
  asked_[ticket] = asker;
  return ticket;
}

void CommandDesk::acknowledge(std::int32_t ticket, bool accepted, const Answer& answer) {
  if (!accepted) ++ends_.counters.refused_commands;
  const auto asked = asked_.extract(ticket);
  const Asker asker = asked ? asked.mapped() : Asker{std::nullopt, ticket};
  ack_t ack{};
  ack.utime = clock_.utime(monotonicNow());
  ack.id = asker.id;
  ack.accepted = accepted;
  ack.message = answer.words;
  problems_t parts{};  // the same as data, found by its stamp
  parts.utime = ack.utime;
  for (const Problem& part : answer.parts) parts.problems.push_back(toMessage("command", part, false));
  parts.nproblems = static_cast<std::int32_t>(parts.problems.size());
  const auto send = [&](const char* channel, const auto& message) {
    if (!asker.client) return publisher_.publish(channel, message);
    std::vector<std::uint8_t> encoded;
    encode(message, encoded);
    socket_.send(*asker.client, channel, encoded);
  };
  if (parts.nproblems > 0) send(channel::kAnswer, parts);
  send(channel::kAck, ack);
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
    return acknowledge(command->id, false, answerOf({answer::kLogNotSet}));
  if (verb == known.end())
    return refuseVerb(*command, of_log ? "log_" : command->verb.starts_with("map_") ? "map_" : "");
  try {
    verb->take(*this, *command);
  } catch (const std::runtime_error& error) {
    acknowledge(command->id, false, answerOf(error));
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
         if (!slam && c.argument != "localise") throw CommandRefused(answer::kNoMode);
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
         if (c.argument.empty()) throw CommandRefused(answer::kMarkNoWords);
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
  acknowledge(command.id, false, answerOf({{answer::kUnknownVerb, {}, {known}}}));
}

void CommandDesk::setPose(const command_t& command) {
  const Pose2 pose{command.pose[0], command.pose[1], command.pose[2]};
  if (const std::string words = implausibilityOf(pose); !words.empty())
    throw CommandRefused({answer::kPoseAbsurd, {}, {words}});
  const bool taken = ends_.commands.set_poses.tryPush({pose});
  acknowledge(command.id, taken, answerOf({taken ? answer::kPoseSet : answer::kTooMany}));
}

void CommandDesk::saveFiles(const command_t& command) {
  if (output_map_.empty()) throw CommandRefused(answer::kFilesNowhere);
  if (!command.argument.empty()) throw CommandRefused(answer::kFilesHavePlace);
  if (saving_) throw CommandRefused(answer::kFilesUnderWay);
  ends_.requests.saved = SaveOutcome::kNone;
  saving_ = command.id;
  ends_.requests.save = true;
}

/// The graph thread answers, unless it has no room.
void CommandDesk::changeMap(const MapCommand& command) {
  if (!ends_.commands.map.tryPush(command)) acknowledge(command.id, false, answerOf({answer::kTooMany}));
}

void CommandDesk::edit(const command_t& command, EditCommand edit) {
  changeMap({MapCommand::kEdit, command.id, "", std::make_shared<const EditCommand>(std::move(edit))});
}

void CommandDesk::changeLog(const LogCommand& command) {
  if (!publisher_.fieldLog()->command(command)) acknowledge(command.id, false, answerOf({answer::kTooMany}));
}

}  // namespace slam
