// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "app/channels.hpp"
#include "app/map/graph_work.hpp"
#include "app/map/map_keeper.hpp"

namespace slam {

/// Commands about the map, one at a time. An edit is made at once, and answered when it is stored. Each is carried out
/// by the disk's thread, behind a checkpoint of the present map; all else belongs to the graph thread.
class MapCommands {
 public:
  /// One that is under way.
  struct Command {
    explicit Command(const MapCommand& command) : asked(command) {}
    MapCommand asked;
    std::atomic_flag taken;  // by the disk's thread, which carries it out, or by the graph's, which refuses it
    std::optional<MapAnswer> answer;
    std::optional<MapState> next;                    // to change to
    std::optional<Pose2> T_next_map = std::nullopt;  // where that is the present map in another frame
  };

  MapCommands(MapKeeper& keeper, GraphWork& work, const Producer<MapAnswer>& answers)
      : keeper_(keeper), work_(work), answers_(answers) {}
  /// Refuses it, or has it wait for the next checkpoint.
  void take(const MapCommand& command, bool disk_hangs);
  /// What no job has taken yet is refused, because the disk hangs.
  void refuseAll();
  bool isWaiting() const { return waiting_.has_value(); }

  /// The checkpoint for the one that waits begins. @return it; nullptr: none waits
  std::shared_ptr<Command> begin();
  /// In the disk's thread, behind the checkpoint of the present map. @param saved whether that was written
  void carryOut(Command& command, const MapState& map, bool saved);
  /// The job has ended: answers. @return it, with the map to change to, if any; nullptr: there was none
  std::shared_ptr<Command> end();

 private:
  Problem problemWith(const MapCommand& command, bool disk_hangs) const;
  void refuse(const MapCommand& command, const Problem& why);
  void giveUp(const MapCommand& command);
  void answer(const MapCommand& command, bool accepted, const Answer& answer);
  void straighten(Command& command, const MapState& map);

  MapKeeper& keeper_;
  GraphWork& work_;
  Producer<MapAnswer> answers_;
  std::optional<MapCommand> waiting_;  // for the disk or the grid
  std::shared_ptr<Command> under_way_;
};

}  // namespace slam
