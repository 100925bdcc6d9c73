// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/counter_info.hpp"
#include "core/pose2.hpp"
#include "graph/optimiser.hpp"
#include "relocalisation/loop_closure.hpp"
#include "relocalisation/relocalisation.hpp"

namespace slam {

struct BackEndConfig {
  LoopClosureConfig closure;
  RelocalisationConfig relocalisation;
  OptimiserConfig optimiser;
  ReferenceConfig reference;
  MatchConfig match;
  bool close_loops = true;
  bool localise_only = false;  ///< the map stays as it was loaded
  Pose2 T_base_depth;          ///< of the levelled depth camera
  double link_distance = 1.0;  ///< [m] a new keyframe is joined to the nearest of the reference up to here ...
  int link_age = 10;           ///< ... that is so many keyframes older: both were matched to one reference
  double link_translation_sigma = 0.02;  ///< [m] of such an edge
  double link_rotation_sigma = 0.005;    ///< [rad]
  double reference_radius = 25.0;        ///< [m] keyframes this near to the robot are put into its reference
  double renewal_travel = 8.0;           ///< [m] in a given map the reference follows the robot in such steps
  int given_attempts = 3;                ///< keyframes that are compared with the map around a pose that a person gave
  double join_travel = 3.0;              ///< [m] driven on without getting lost, a robot that was found extends the map
  double renewal_radius = 8.0;           ///< [m] what becomes known or unknown within this distance renews it
  int few_keyframes = 10;                ///< a map of no more, and made by this robot since its start, is forgotten ...
  double outgrown = 4.0;                 ///< ... for a session that is not in it and has so many times its keyframes
  double renewal_shift = 0.01;           ///< [m] a keyframe of the reference that moved further renews it ...
  double renewal_turn = 0.01;            ///< [rad] ... or that turned by more: a robot may have turned on the spot
};

struct BackEndCounters {
  int keyframes = 0, loop_closures = 0, revoked = 0, optimisations = 0, corrections = 0;
  int placed = 0;      ///< sessions found in the map
  int taken_back = 0;  ///< of these, because the robot got lost on the way
  int begun_anew = 0;  ///< maps of a few keyframes that a session has outgrown
  LoopClosureSearch::Counters search;
  Relocalisation::Counters relocalisation;

  template <typename Visitor>
  friend void visitCounters(const BackEndCounters& c, Visitor&& visit) {
    visit(CounterInfo{"graph.keyframes", "keyframes", "Keyframes that were put into this graph."}, c.keyframes);
    visit(CounterInfo{"loop_closures", "closures", "Loop closures that stand."}, c.loop_closures);
    visit(CounterInfo{"loop_closures.revoked", "closures", "Loop closures that were taken back.", "revoked"},
          c.revoked);
    visit(CounterInfo{"loop_closures.searches", "searches", "Searches for a loop closure."}, c.search.searches);
    visit(CounterInfo{"loop_closures.found", "searches", "Of these: one was found."}, c.search.found);
    visit(CounterInfo{"loop_closures.ambiguous", "matches", "Refused because a second place fits as well."},
          c.search.ambiguous);
    visit(CounterInfo{"loop_closures.accepted", "closures", "Loop closures that were believed."}, c.search.accepted);
    visit(CounterInfo{"loop_closures.inconsistent", "matches", "Refused because others contradict them."},
          c.search.inconsistent);
    visit(CounterInfo{"optimisations", "times", "The graph was optimised."}, c.optimisations);
    visit(CounterInfo{"corrections", "times", "The front end was given another local map."}, c.corrections);
    visit(CounterInfo{"relocalised", "times", "A lost robot was found in the map."}, c.placed);
    visit(CounterInfo{"relocalised.taken_back", "times",
                      "Of these: lost again soon, so that nothing of it was put into the map.", "taken_back"},
          c.taken_back);
    visit(CounterInfo{"relocalisation.searches", "searches", "Searches for a lost robot."}, c.relocalisation.searches);
    visit(CounterInfo{"relocalisation.found", "searches", "Of these: the robot was found."}, c.relocalisation.found);
    visit(CounterInfo{"relocalisation.ambiguous", "searches", "Of these: a second place fits as well."},
          c.relocalisation.ambiguous);
    visit(CounterInfo{"relocalisation.refused", "searches", "Of these: what was found was not sure enough."},
          c.relocalisation.refused);
    visit(CounterInfo{"relocalisation.interrupted", "times",
                      "A search had used the work that it may do at once, and went on with a later scan."},
          c.relocalisation.interrupted);
    visit(CounterInfo{"maps.begun_anew", "times", "A map of a few keyframes was forgotten.", "begun_anew"},
          c.begun_anew);
  }
};

}  // namespace slam
