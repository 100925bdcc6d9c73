// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/map_commands.hpp"

#include <algorithm>
#include <exception>
#include <numbers>
#include <utility>

#include "app/log/log.hpp"
#include "problems/answers.hpp"
#include "runtime/clock.hpp"
#include "slam/edits/straighten.hpp"
#include "store/map_folders.hpp"

namespace slam {
namespace {

bool isOfTheFolder(const MapCommand& command) {
  return command.kind == MapCommand::kRename || command.kind == MapCommand::kDelete ||
         command.kind == MapCommand::kRestore;
}

/// Another name for a map that is not the present one, or none. @return what was done
/// @throws std::runtime_error with one sentence; then all maps are as they were
Problem carryOutInFolder(const MapCommand& command, const MapKeeper& keeper) {
  if (keeper.directory().empty()) throw CommandRefused(answer::kNoStore);
  if (command.kind == MapCommand::kRestore) return {answer::kRestored, {}, {restoreMap(keeper.directory())}};
  const auto blank = std::min(command.name.find(' '), command.name.size());
  const std::string name = command.name.substr(0, blank);
  if (name == keeper.name()) throw CommandRefused({answer::kMapOpen, {}, {name}});
  if (name == keeper.configuredName()) throw CommandRefused({answer::kMapBegins, {}, {name}});
  try {
    if (command.kind == MapCommand::kDelete) {
      putMapAside(keeper.directory(), name);
      return {answer::kDeleted, {}, {name}};
    }
    const std::string to = command.name.substr(std::min(blank + 1, command.name.size()));
    renameMap(keeper.directory(), name, to);
    return {answer::kRenamed, {}, {name, to}};
  } catch (const FolderLocked&) {
    throw CommandRefused({answer::kMapOfOthers, {}, {name}});
  }
}

/// What an edit has done. @param edit its number
Problem madeBy(const EditCommand& command, int edit) {
  switch (command.kind) {
    case EditCommand::kAdd:
      return {answer::kEditMade, {static_cast<double>(edit)}};
    case EditCommand::kUndo:
      return {answer::kEditUndone, {static_cast<double>(edit)}};
    case EditCommand::kRedo:
      return {answer::kEditRedone, {static_cast<double>(edit)}};
    case EditCommand::kRemove:
      return {answer::kEditRemoved, {static_cast<double>(edit)}};
  }
  return {};
}

}  // namespace

void MapCommands::take(const MapCommand& command, bool disk_hangs) {
  if (const Problem problem = problemWith(command, disk_hangs)) return refuse(command, problem);
  MapCommand next = command;
  if (command.kind == MapCommand::kEdit) {
    int edit = 0;
    if (const Problem why = work_.edit(*command.edit, &edit)) return refuse(command, why);
    next.done = madeBy(*command.edit, edit);
  }
  waiting_ = next;  // the present map is stored first
}

Problem MapCommands::problemWith(const MapCommand& command, bool disk_hangs) const {
  const bool localises = keeper_.localises(), localise = command.kind == MapCommand::kLocalise;
  if ((localise || command.kind == MapCommand::kSlam) && localise == localises)
    return {answer::kModeAlready, {}, {localise ? "localise" : "slam"}};
  if (command.kind == MapCommand::kStraighten && !work_.isLocalised()) return answer::kNotLocalised;
  if ((command.kind == MapCommand::kEdit || command.kind == MapCommand::kStraighten) && localises)
    return answer::kMapStays;
  if (command.kind == MapCommand::kReset && localises) return answer::kNoReset;
  if (command.kind == MapCommand::kSave && !command.name.empty() && !MapStore::isName(command.name))
    return {answer::kNoMapName, {}, {command.name}};
  if (command.kind == MapCommand::kSave && !keeper_.writes()) return localises ? answer::kMapSame : answer::kNoStore;
  if (disk_hangs) return answer::kDiskSilent;
  return waiting_ || under_way_ ? Problem(answer::kMapBusy) : Problem();
}

void MapCommands::refuse(const MapCommand& command, const Problem& why) { answer(command, false, answerOf({why})); }

void MapCommands::answer(const MapCommand& command, bool accepted, const Answer& answer) {
  if (!command.floor) return static_cast<void>(answers_.tryPush({command.id, accepted, answer}));
  accepted ? logInfo(answer.words)
           : logWarning("the robot is in map " + command.name + ", which is not loaded: " + answer.words);
}

void MapCommands::refuseAll() {
  if (waiting_) giveUp(*std::exchange(waiting_, std::nullopt));
  if (under_way_ && !under_way_->taken.test_and_set()) giveUp(under_way_->asked);
}

/// What was to be stored before the answer is not, as yet.
void MapCommands::giveUp(const MapCommand& command) {
  if (command.kind != MapCommand::kEdit) return refuse(command, answer::kDiskSilent);
  answer(command, true, answerOf({command.done, answer::kNotStoredYet}));
}

std::shared_ptr<MapCommands::Command> MapCommands::begin() {
  if (waiting_) under_way_ = std::make_shared<Command>(*std::exchange(waiting_, std::nullopt));
  return under_way_;
}

std::shared_ptr<MapCommands::Command> MapCommands::end() {
  auto ended = std::exchange(under_way_, nullptr);
  if (ended && ended->answer) answer(ended->asked, ended->answer->accepted, ended->answer->answer);
  return ended;
}

void MapCommands::carryOut(Command& command, const MapState& map, bool saved) {
  if (command.taken.test_and_set()) return;
  const MapCommand& asked = command.asked;
  const Problem disk = keeper_.problem().problem;
  const auto answer = [&](bool accepted, std::initializer_list<Problem> parts) {
    command.answer = {asked.id, accepted, answerOf(parts)};
  };
  try {
    if (asked.kind == MapCommand::kSave) {
      const bool present = asked.name.empty() || asked.name == keeper_.name();
      if (present && !saved) return answer(false, {answer::kNotStored, disk});
      if (!present) keeper_.saveAs(asked.name, map);
      return answer(true, {{answer::kSaved, {}, {present ? keeper_.name() : asked.name}}});
    }
    if (isOfTheFolder(asked)) return answer(true, {carryOutInFolder(asked, keeper_)});
    if (asked.kind == MapCommand::kEdit) {
      if (saved) return answer(true, {asked.done, {answer::kStoredIn, {}, {keeper_.name()}}});
      if (keeper_.writes()) return answer(true, {asked.done, answer::kNotStored, disk});
      return answer(true, {asked.done, answer::kLostAtEnd});
    }
    const bool lost = !saved && keeper_.writes() && map.keyframes.size() > 0;
    const Problem before = lost ? Problem(answer::kOldMapNotStored) : Problem(), why = lost ? disk : Problem();
    if (lost && asked.kind != MapCommand::kLoad && asked.kind != MapCommand::kReset)
      return answer(false, {answer::kMapNotStored, disk});  // the stored one lacks what is new
    if (asked.kind == MapCommand::kStraighten) return straighten(command, map);
    if (asked.kind == MapCommand::kLoad) {
      command.next = keeper_.load(asked.name, monotonicNow());
      answer(true, {{asked.floor ? answer::kFloorLoaded : answer::kLoaded, {}, {asked.name}}, before, why});
    } else if (asked.kind == MapCommand::kLocalise || asked.kind == MapCommand::kSlam) {
      const bool localise = asked.kind == MapCommand::kLocalise;
      command.next = keeper_.changeMode(localise, monotonicNow());
      answer(true, {{localise ? answer::kLocalises : answer::kExtends, {}, {keeper_.name()}}});
    } else {
      keeper_.beginNew(monotonicNow());
      command.next.emplace();
      answer(true, {answer::kNewMap, before, why});
    }
  } catch (const std::exception& error) {
    command.answer = {asked.id, false, answerOf(error)};
  }
}

void MapCommands::straighten(Command& command, const MapState& map) {
  const MapCommand& asked = command.asked;
  const Pose2 T_next_map = straightFrame(map, asked.name), T_map_next = T_next_map.inverse();
  MapState next = transformed(map, T_next_map, keeper_.gridConfig());
  if (keeper_.writes() && !keeper_.checkpoint(monotonicNow(), next)) {
    command.answer = {asked.id, false, answerOf({answer::kStraightNotStored, keeper_.problem().problem})};
    return;
  }
  command.next = std::move(next);
  command.T_next_map = T_next_map;
  const double turn = T_next_map.theta * 180.0 / std::numbers::pi;  // [deg]
  command.answer = {asked.id, true, answerOf({{answer::kStraightened, {turn, T_map_next.x, T_map_next.y}}})};
}

}  // namespace slam
