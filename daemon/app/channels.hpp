// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <slam/map_edit_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <string>
#include <vector>

#include "app/threads/thread_messages.hpp"
#include "bus/refusal.hpp"
#include "core/counter_info.hpp"
#include "core/keyframe.hpp"
#include "core/pseudo_laser.hpp"
#include "drivers/can/can_link.hpp"
#include "frontend/map_correction.hpp"
#include "runtime/latency_histogram.hpp"
#include "runtime/latest_value.hpp"
#include "runtime/spsc_queue.hpp"
#include "runtime/wakeup.hpp"
#include "slam/back_end.hpp"

namespace slam {

class FrontEnd;

/// What the threads bus and pose count. Read by any.
struct BusCounters {
  std::atomic<std::uint64_t> published{0}, failures{0}, bad_messages{0}, messages{0}, fragments{0}, other_packets{0};
  std::array<std::atomic<std::uint64_t>, kRefusals - 1> refused{};  // of sensors and speeds, by the reason
  std::atomic<std::uint64_t> drives_not_followed{0}, refused_commands{0};
  std::atomic<std::uint64_t> dropped{0}, socket_clients{0}, socket_bad{0}, socket_dropped{0}, socket_refused{0};

  void refuse(Refusal refusal) {
    ++bad_messages;
    ++refused[static_cast<std::size_t>(refusal) - 1];
  }

  template <typename Visitor>
  friend void visitCounters(const BusCounters& c, Visitor&& visit) {
    visit(CounterInfo{"lcm.published", "messages", "Sent over LCM."}, c.published);
    visit(CounterInfo{"lcm.failures", "messages", "Could not be sent over LCM."}, c.failures);
    visit(CounterInfo{"lcm.bad_messages", "messages", "Received, but not used: damaged, or their stamp is impossible."},
          c.bad_messages);
    for (std::size_t i = 1; i < kRefusals; ++i) {
      const auto refusal = static_cast<Refusal>(i);
      visit(CounterInfo{std::string("lcm.refused_") + nameOf(refusal), "messages",
                        std::string("Refused: ") + meaningOf(refusal) + "."},
            c.refused[i - 1]);
    }
    visit(CounterInfo{"lcm.drives_not_followed", "messages",
                      "SLAM_DRIVE of a program that is not driven, because another one is, or stopped it."},
          c.drives_not_followed);
    visit(CounterInfo{"commands.refused", "commands", "Answered with a reason why they are not carried out."},
          c.refused_commands);
    visit(CounterInfo{"lcm.messages", "messages", "Received over LCM, on any channel."}, c.messages);
    visit(CounterInfo{"lcm.fragments", "packets", "Parts of messages that are larger than a packet."}, c.fragments);
    visit(CounterInfo{"lcm.other_packets", "packets", "Received, but none of LCM's."}, c.other_packets);
    visit(CounterInfo{"lcm.dropped", "packets", "Dropped by the kernel because its buffer was full."}, c.dropped);
    visit(CounterInfo{"socket.clients", "clients", "Connected to the local socket now."}, c.socket_clients);
    visit(CounterInfo{"socket.bad_packets", "packets", "Received there, but no message."}, c.socket_bad);
    visit(CounterInfo{"socket.dropped_clients", "clients", "Disconnected because they did not read."},
          c.socket_dropped);
    visit(CounterInfo{"socket.refused_clients", "clients", "Found no place, or gave theirs to a newer one."},
          c.socket_refused);
  }
};

/// How long each step takes. Each is written by one thread, read by any.
struct StageTimes {
  LatencyHistogram match, scan_work, scan_to_pose, depth, map, loop_closure;

  template <typename Visitor>
  friend void visitStages(const StageTimes& t, Visitor&& visit) {
    visit("match", t.match);
    visit("scan_work", t.scan_work);
    visit("scan_to_pose", t.scan_to_pose);
    visit("depth", t.depth);
    visit("map", t.map);
    visit("loop_closure", t.loop_closure);
  }
};

// Channels are declared once, whatever their ends: SpscQueue where they are kept, Producer and Consumer where they are
// handed out. ends() makes the latter of the former.

/// Samples, raw: one to the estimator, one to the bus.
template <template <typename> typename End>
struct SensorChannels {
  End<WheelReading> wheels{256};
  End<ImuSample> imu{256};
  End<ReceivedScan> scans{8};
  End<PseudoLaser> views{8};

  template <template <typename> typename Other>
  SensorChannels<Other> ends() {
    return {wheels, imu, scans, views};
  }
};

/// Forth: estimator -> graph; back: graph -> estimator.
template <template <typename> typename Forth, template <typename> typename Back>
struct FrontEndChannels {
  Forth<Keyframe> keyframes{MapCorrection::kMostAhead - 1};  // one more may come while a correction is handed over
  Forth<DepthObservation> sights{64};
  Back<MapCorrection*> corrections{2};  // who gets one gives it back; one at most is on its way
  Forth<MapCorrection*> used_corrections{2};
  Back<FrontEnd*> front_ends{2};  // begins in another map, and the old one is given back
  Forth<FrontEnd*> used_front_ends{2};

  template <template <typename> typename F, template <typename> typename B>
  FrontEndChannels<F, B> ends() {
    return {keyframes, sights, corrections, used_corrections, front_ends, used_front_ends};
  }
};

/// Forth: graph -> mapper; back: mapper -> graph.
template <template <typename> typename Forth, template <typename> typename Back>
struct MapChannels {
  Forth<std::shared_ptr<const MapChange>> changes{256};
  Back<std::shared_ptr<DrawnMap>> grids{2};  // copies, on request

  template <template <typename> typename F, template <typename> typename B>
  MapChannels<F, B> ends() {
    return {changes, grids};
  }
};

/// Mapper -> bus: the map, and its layers.
template <template <typename> typename End>
struct TileChannels {
  End<map_meta_t> meta{4};
  End<map_tile_t> map{256};
  End<map_tile_t> lidar{32};
  End<map_tile_t> depth{32};

  template <template <typename> typename Other>
  TileChannels<Other> ends() {
    return {meta, map, lidar, depth};
  }
};

/// Bus -> base, estimator, graph.
template <template <typename> typename End>
struct CommandChannels {
  End<DriveCommand> drives{8};
  End<SetPose> set_poses{8};
  End<MapCommand> map{8};

  template <template <typename> typename Other>
  CommandChannels<Other> ends() {
    return {drives, set_poses, map};
  }
};

/// All edits of the map, as messages.
using EditMessages = std::shared_ptr<const std::vector<map_edit_t>>;

/// Between bus and mapper.
struct MapRequests {
  std::atomic<bool> save{false};
  std::atomic<SaveOutcome> saved{SaveOutcome::kNone};  // of the last save
  std::atomic<bool> refresh{false};                    // all tiles again
};

/// Samples of a device of our own.
template <typename T>
struct SampleProducer {
  Producer<T> estimator, bus;
  Wakeup* wakeup = nullptr;  // of the estimator, where it shall not wait for its next tick

  void push(const T& sample) const {
    estimator.tryPush(sample);
    if (wakeup != nullptr) wakeup->notify();
    bus.tryPush(sample);
  }
};

// What each thread gets.
struct BaseEnds {
  SampleProducer<WheelReading> wheels;
  SampleProducer<ImuSample> imu;
  Consumer<DriveCommand> drives;
  LatestWriter<CanLinkCounters> can_counters;
};

struct DepthEnds {
  SampleProducer<PseudoLaser> views;
  const std::atomic<bool>& moving;
  LatencyHistogram& work;
};

struct EstimatorEnds {
  SensorChannels<Consumer> samples;
  Consumer<SetPose> set_poses;
  FrontEndChannels<Producer, Consumer> graph;
  LatestWriter<PoseSnapshot> pose, pose_for_supervisor, pose_for_graph;
  std::atomic<bool>&moving, &lidar_stuck;
  LatencyHistogram &match, &scan_work;
  Wakeup &wakeup, &pose_wakeup;
};

struct PoseEnds {
  LatestReader<PoseSnapshot> pose;
  Producer<SentPose> sent;
  BusCounters& counters;
  LatencyHistogram& scan_to_pose;
  Wakeup &wakeup, &bus_wakeup;
};

struct GraphEnds {
  FrontEndChannels<Consumer, Producer> front_end;
  MapChannels<Producer, Consumer> map;
  Consumer<MapCommand> commands;
  Producer<MapAnswer> answers;
  Producer<EditMessages> edits;
  LatestReader<PoseSnapshot> pose;
  LatestWriter<BackEndCounters> counters;
  LatencyHistogram& loop_closure;
};

struct MapperEnds {
  MapChannels<Consumer, Producer> map;
  TileChannels<Producer> tiles;
  MapRequests& requests;
  std::atomic<int>& keyframes;
  LatencyHistogram& update;
  Wakeup& bus_wakeup;
};

struct BusEnds {
  SensorChannels<Producer> samples;  // of sensors whose driver is "lcm": no other thread gives these
  SensorChannels<Consumer> raw;
  CommandChannels<Producer> commands;
  Consumer<MapAnswer> answers;
  Consumer<EditMessages> edits;
  TileChannels<Consumer> tiles;
  MapRequests& requests;
  Consumer<HealthReport> health;
  Consumer<SentPose> poses;
  BusCounters& counters;
  Wakeup &wakeup, &estimator_wakeup;
};

/// Keeps all that crosses threads, and hands each thread its ends.
struct Channels {
  Channels() = default;
  Channels(const Channels&) = delete;
  Channels& operator=(const Channels&) = delete;
  ~Channels();  ///< what is on its way between estimator and graph ends here

  BaseEnds base() { return {{samples.wheels, raw.wheels}, {samples.imu, raw.imu}, commands.drives, can_counters}; }
  SampleProducer<ReceivedScan> lidar() { return {samples.scans, raw.scans, &estimator_wakeup}; }
  DepthEnds depth() { return {{samples.views, raw.views}, moving, times.depth}; }
  EstimatorEnds estimator();
  PoseEnds pose() { return {newest_pose, sent_poses, bus_counters, times.scan_to_pose, pose_wakeup, bus_wakeup}; }
  GraphEnds graph();
  MapperEnds mapper();
  BusEnds bus();

  SensorChannels<SpscQueue> samples, raw;
  FrontEndChannels<SpscQueue, SpscQueue> front_end;
  MapChannels<SpscQueue, SpscQueue> map;
  TileChannels<SpscQueue> tiles;
  CommandChannels<SpscQueue> commands;
  SpscQueue<MapAnswer> answers{16};      // graph -> bus
  SpscQueue<EditMessages> edits{4};      // graph -> bus
  SpscQueue<HealthReport> health{4};     // supervisor -> bus
  SpscQueue<SentPose> sent_poses{1024};  // pose -> bus
  MapRequests requests;

  LatestValue<PoseSnapshot> newest_pose, pose_for_supervisor, pose_for_graph;  // estimator -> pose and each
  LatestValue<BackEndCounters> graph_counters;                                 // graph -> supervisor
  LatestValue<CanLinkCounters> can_counters;                                   // base -> supervisor
  Wakeup estimator_wakeup;                                                     // lidar or bus -> estimator
  Wakeup pose_wakeup;                                                          // estimator -> pose
  Wakeup bus_wakeup;                                                           // pose, mapper, supervisor -> bus
  std::atomic<bool> moving{false};       // estimator -> depth: wheels and gyro say so
  std::atomic<bool> lidar_stuck{false};  // estimator -> supervisor: it repeats a turn although the robot moves
  StageTimes times;
  BusCounters bus_counters;
  std::atomic<int> map_keyframes{0};  // mapper -> supervisor: drawn

  template <typename Visitor>
  friend void visitCounters(const Channels& c, Visitor&& visit) {
    visitCounters(c.bus_counters, visit);
    visit(CounterInfo{"map.keyframes", "keyframes", "Keyframes that are drawn in the map."}, c.map_keyframes);
    const auto drops = [&](const char* name, const auto& queue, const char* unit, const char* way) {
      visit(CounterInfo{std::string("drops.") + name, unit, std::string("Dropped: the queue ") + way + " was full."},
            queue.drops());
    };
    drops("scans", c.samples.scans, "scans", "to the estimator");
    drops("wheels", c.samples.wheels, "samples", "to the estimator");
    drops("imu", c.samples.imu, "samples", "to the estimator");
    drops("views", c.samples.views, "images", "to the estimator");
    drops("sights", c.front_end.sights, "images", "from the estimator to the graph");
    drops("keyframes", c.front_end.keyframes, "keyframes", "from the estimator to the graph");
    drops("raw_scans", c.raw.scans, "scans", "to the bus");
    drops("raw_wheels", c.raw.wheels, "samples", "to the bus");
    drops("raw_imu", c.raw.imu, "samples", "to the bus");
    drops("raw_views", c.raw.views, "images", "to the bus");
    drops("drives", c.commands.drives, "commands", "from the bus to the base");
    drops("set_poses", c.commands.set_poses, "commands", "from the bus to the estimator");
    drops("map_commands", c.commands.map, "commands", "from the bus to the graph");
    drops("map_answers", c.answers, "answers", "from the graph to the bus");
    drops("health", c.health, "messages", "from the supervisor to the bus");
    drops("poses", c.sent_poses, "poses", "from the pose thread to the records");
  }
};

}  // namespace slam
