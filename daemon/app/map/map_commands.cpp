// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/map_commands.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <numbers>
#include <utility>

#include "app/log/log.hpp"
#include "runtime/clock.hpp"
#include "slam/edits/straighten.hpp"
#include "store/map_folders.hpp"

namespace slam {
namespace {

const char* const kNoAnswer = "the disk does not answer; try again when it does";

bool isOfTheFolder(const MapCommand& command) {
  return command.kind == MapCommand::kRename || command.kind == MapCommand::kDelete ||
         command.kind == MapCommand::kRestore;
}

/// Another name for a map that is not the present one, or none. @return what was done, in words
/// @throws std::runtime_error with one sentence; then all maps are as they were
std::string carryOutInFolder(const MapCommand& command, const MapKeeper& keeper) {
  if (keeper.directory().empty()) throw std::runtime_error("store.directory is not set in the configuration");
  if (command.kind == MapCommand::kRestore) return "map " + restoreMap(keeper.directory()) + " is back";
  const auto blank = std::min(command.name.find(' '), command.name.size());
  const std::string name = command.name.substr(0, blank);
  if (name == keeper.name()) throw std::runtime_error("slamd has map " + name + " open; load another one first");
  if (name == keeper.configuredName())
    throw std::runtime_error("store.map names map " + name + ", with which slamd begins; set another one first");
  try {
    if (command.kind == MapCommand::kDelete) {
      putMapAside(keeper.directory(), name);
      return "map " + name + " is deleted; until the next one is, it can be restored";
    }
    const std::string to = command.name.substr(std::min(blank + 1, command.name.size()));
    renameMap(keeper.directory(), name, to);
    return "map " + name + " is now " + to;
  } catch (const FolderLocked&) {
    throw std::runtime_error("another program has map " + name + " open");
  }
}

}  // namespace

void MapCommands::take(const MapCommand& command, bool disk_hangs) {
  const std::string problem = problemWith(command, disk_hangs);
  if (!problem.empty()) return refuse(command, problem);
  MapCommand next = command;
  if (command.kind == MapCommand::kEdit) {
    int edit = 0;
    if (const std::string why = work_.edit(*command.edit, &edit); !why.empty()) return refuse(command, why);
    constexpr const char* kDone[] = {"made", "undone (its last step)", "done again (its last step)", "removed"};
    next.name = "edit " + std::to_string(edit) + " is " + kDone[command.edit->kind];
  }
  waiting_ = next;  // the present map is stored first
}

std::string MapCommands::problemWith(const MapCommand& command, bool disk_hangs) const {
  const bool localises = keeper_.localises(), localise = command.kind == MapCommand::kLocalise;
  if ((localise || command.kind == MapCommand::kSlam) && localise == localises)
    return std::string("mode is \"") + (localise ? "localise" : "slam") + "\" already";
  if (command.kind == MapCommand::kStraighten && !work_.isLocalised())
    return "the robot is not localised: it would be lost in the turned map; try again when it is";
  if ((command.kind == MapCommand::kEdit || command.kind == MapCommand::kStraighten) && localises)
    return "mode is \"localise\": the map stays as it is; slamctl mode slam, edit it, and slamctl mode localise";
  if (command.kind == MapCommand::kReset && localises)
    return "mode is \"localise\": the map stays; use set-pose to say where the robot is";
  if (command.kind == MapCommand::kSave && !command.name.empty() && !MapStore::isName(command.name))
    return "\"" + command.name + "\" is no name of a map; use letters, digits, - and _";
  if (command.kind == MapCommand::kSave && !keeper_.writes()) {
    return localises ? "mode is \"localise\": the map does not change"
                     : "store.directory is not set in the configuration";
  }
  if (disk_hangs) return kNoAnswer;
  return waiting_ || under_way_ ? "another command about the map is being carried out" : "";
}

void MapCommands::refuse(const MapCommand& command, const std::string& problem) { answer(command, false, problem); }

void MapCommands::answer(const MapCommand& command, bool accepted, const std::string& message) {
  if (!command.floor) return static_cast<void>(answers_.tryPush({command.id, accepted, message}));
  accepted ? logInfo(message) : logWarning("the robot is in map " + command.name + ", which is not loaded: " + message);
}

void MapCommands::refuseAll() {
  if (waiting_) giveUp(*std::exchange(waiting_, std::nullopt));
  if (under_way_ && !under_way_->taken.test_and_set()) giveUp(under_way_->asked);
}

/// What was to be stored before the answer is not, as yet.
void MapCommands::giveUp(const MapCommand& command) {
  if (command.kind != MapCommand::kEdit) return refuse(command, kNoAnswer);
  answer(command, true, command.name + ", but not stored yet: the disk does not answer");
}

std::shared_ptr<MapCommands::Command> MapCommands::begin() {
  if (waiting_) under_way_ = std::make_shared<Command>(*std::exchange(waiting_, std::nullopt));
  return under_way_;
}

std::shared_ptr<MapCommands::Command> MapCommands::end() {
  auto ended = std::exchange(under_way_, nullptr);
  if (ended && ended->answer) answer(ended->asked, ended->answer->accepted, ended->answer->message);
  return ended;
}

void MapCommands::carryOut(Command& command, const MapState& map, bool saved) {
  if (command.taken.test_and_set()) return;
  const MapCommand& asked = command.asked;
  const std::string loss = "not stored: " + keeper_.problem().words();
  const auto answer = [&](bool accepted, const std::string& message) {
    command.answer = {asked.id, accepted, message};
  };
  try {
    if (asked.kind == MapCommand::kSave) {
      if (asked.name.empty() || asked.name == keeper_.name())
        return saved ? answer(true, "saved as " + keeper_.name()) : answer(false, loss);
      keeper_.saveAs(asked.name, map);
      return answer(true, "saved as " + asked.name);
    }
    if (isOfTheFolder(asked)) return answer(true, carryOutInFolder(asked, keeper_));
    if (asked.kind == MapCommand::kEdit) {
      return answer(true, saved              ? asked.name + " and stored in " + keeper_.name()
                          : keeper_.writes() ? asked.name + ", but " + loss
                                             : asked.name + ", and lost at the end: store.directory is not set");
    }
    const bool lost = !saved && keeper_.writes() && map.keyframes.size() > 0;
    const std::string before = lost ? "; the one before is " + loss : "";
    if (asked.kind == MapCommand::kStraighten) {
      if (lost) return answer(false, "the map is " + loss);
      const Pose2 T_next_map = straightFrame(map, asked.name);
      MapState next = transformed(map, T_next_map, keeper_.gridConfig());
      const bool stored = !keeper_.writes() || keeper_.checkpoint(monotonicNow(), next);
      if (!stored) return answer(false, "the map stays as it is: the straightened one is " + loss);
      command.next = std::move(next);
      command.T_next_map = T_next_map;
      char text[120];
      std::snprintf(text, sizeof text, "the map is turned by %.2f deg; its origin was at x %.3f m, y %.3f m",
                    T_next_map.theta * 180.0 / std::numbers::pi, T_next_map.inverse().x, T_next_map.inverse().y);
      return answer(true, text);
    }
    if (asked.kind == MapCommand::kLoad) {
      command.next = keeper_.load(asked.name, monotonicNow());
      answer(true, asked.floor ? "the robot was found in map " + asked.name + ", which is loaded" + before
                               : "loaded " + asked.name + "; looking for the robot in it" + before);
    } else if (asked.kind == MapCommand::kLocalise || asked.kind == MapCommand::kSlam) {
      const bool localise = asked.kind == MapCommand::kLocalise;
      if (lost) return answer(false, "the map is " + loss);  // the stored one lacks what is new
      command.next = keeper_.changeMode(localise, monotonicNow());
      const std::string& name = keeper_.name();
      answer(true, (localise ? "localises in " + name + ", which stays as it is" : "extends " + name) +
                       "; the next start takes mode from the configuration");
    } else {
      keeper_.beginNew(monotonicNow());
      command.next.emplace();
      answer(true, "a new map begins" + before);
    }
  } catch (const std::exception& error) {
    answer(false, error.what());
  }
}

}  // namespace slam
