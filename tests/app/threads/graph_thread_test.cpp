// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/graph_thread.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/threads/mapper_thread.hpp"
#include "support/slow_disk.hpp"
#include "support/stored_map.hpp"
#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::graph_thread_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::ChangingMap;
using test::HangingDisk;
using test::waitUntil;
using testing::HasSubstr;

/// Graph and mapper threads of a slamd that stores its map, without the rest.
class GraphKeeping : public testing::Test {
 protected:
  GraphKeeping() {
    config.store.directory = folder / "maps";
    config.store.journal_period = 0.1;
    config.store.checkpoint_period = 5.0;
    config.map = test::smallGrid();
    config.front_end.lidar.T_base_lidar = ChangingMap().map.T_base_lidar;
  }
  ~GraphKeeping() override { stop(); }
  void start() {
    channels = std::make_unique<Channels>();
    graph = std::make_unique<GraphThread>(config, channels->graph(), clock);
    mapper = std::make_unique<MapperThread>(config, channels->mapper(), clock);
    graph->worker().start();
    mapper->worker().start();
  }
  void stop() {
    if (!graph) return;
    graph->worker().stop();
    mapper->worker().stop();
    graph.reset();
    mapper.reset();
  }
  /// The next keyframe, 0.3 m ahead of the last one; one that was not matched, so that nothing is searched for.
  void drive() {
    keyframe->id = next++;
    keyframe->observable = 0;
    keyframe->stamp += 1s;
    keyframe->T_base_lidar = config.front_end.lidar.T_base_lidar;
    keyframe->T_map_base = {0.3 * keyframe->id, 0.0, 0.0};
    keyframe->T_previous_base = keyframe->id == 0 ? Pose2{} : Pose2{0.3, 0.0, 0.0};
    keyframe->step_covariance = 1e-4 * Eigen::Matrix3d::Identity();
    keyframe->size = 0;
    for (int i = 0; i < 60; ++i) {
      const double angle = 0.1 * i;
      keyframe->storage[static_cast<std::size_t>(keyframe->size++)] = {static_cast<float>(2.0 * std::cos(angle)),
                                                                       static_cast<float>(2.0 * std::sin(angle))};
    }
    ASSERT_TRUE(channels->front_end.keyframes.tryPush(*keyframe));
  }
  int stored() const {
    const auto name = MapStore::newest(folder / "maps");
    return name ? MapStore::load(folder / "maps", *name, config.map).state.keyframes.size() : 0;
  }
  Duration waiting() const { return graph->jobs().report(monotonicNow()).waiting; }
  std::optional<MapAnswer> answer() {
    std::optional<MapAnswer> got;
    const bool there = waitUntil([&] {
      channels->answers.popOne([&](const MapAnswer& next_one) { got = next_one; });
      return got.has_value();
    });
    EXPECT_TRUE(there);
    return got;
  }

  const test::Folder folder;
  Config config;
  WallClock clock;
  std::unique_ptr<Channels> channels;
  std::unique_ptr<GraphThread> graph;
  std::unique_ptr<MapperThread> mapper;
  std::unique_ptr<Keyframe> keyframe = std::make_unique<Keyframe>();
  std::int32_t next = 0;
};

TEST_F(GraphKeeping, GoesOnWhileTheDiskHangsAndStoresAllOfItThen) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  for (int i = 0; i < 3; ++i) drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 3; }));
  HangingDisk disk;
  drive();
  ASSERT_TRUE(waitUntil([&] { return waiting() > 300ms; }));
  const std::uint64_t ticks = graph->worker().ticks();
  for (int i = 0; i < 5; ++i) drive();
  ASSERT_TRUE(waitUntil([&] { return graph->worker().ticks() > ticks + 10; })) << "the watchdog's thread ticks";
  ASSERT_TRUE(waitUntil([&] { return channels->map_keyframes == 9; })) << "the map is drawn";
  EXPECT_GT(waiting(), 300ms);
  disk.release();
  EXPECT_TRUE(waitUntil([&] { return stored() == 9; })) << stored() << " what came meanwhile is stored, too";
}

TEST_F(GraphKeeping, CallsAMapSavedWhenItIsOnTheDisk) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1; }));
  drive();
  HangingDisk disk;
  ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kSave, 7, ""}));
  ASSERT_TRUE(waitUntil([&] { return waiting() > 200ms; }));
  EXPECT_FALSE(channels->answers.popOne([](const MapAnswer& early) { ADD_FAILURE() << early.answer.words; }));
  disk.release();
  const auto saved = answer();
  ASSERT_TRUE(saved);
  EXPECT_TRUE(saved->accepted) << saved->answer.words;
  EXPECT_EQ(saved->id, 7);
  EXPECT_EQ(stored(), 2);
}

TEST_F(GraphKeeping, SavesThePresentMapUnderItsOwnNameAndGoesOn) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1; }));
  const std::string name = *MapStore::newest(folder / "maps");
  for (int i = 2; i < 5; ++i) {
    drive();
    ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kSave, i, name}));
    const auto saved = answer();
    ASSERT_TRUE(saved);
    EXPECT_EQ(saved->answer.words, "saved as " + name);
    EXPECT_EQ(graph->jobs().report(monotonicNow()).problem.words(), "");
  }
  EXPECT_EQ(stored(), 4);
}

TEST_F(GraphKeeping, RenamesDeletesAndRestoresOtherMapsThanThePresentOne) {
  config.store.map = "home";
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1; }));
  const std::string present = *MapStore::newest(folder / "maps");
  const auto ask = [&](MapCommand::Kind kind, const std::string& name) {
    EXPECT_TRUE(channels->commands.map.tryPush({kind, 5, name}));
    const auto given = answer();
    return given ? (given->accepted ? "" : "refused: ") + given->answer.words : "none";
  };
  EXPECT_EQ(ask(MapCommand::kSave, "copy"), "saved as copy");
  EXPECT_EQ(ask(MapCommand::kRename, "copy house"), "map copy is now house");
  EXPECT_THAT(ask(MapCommand::kRename, "house ../house"), HasSubstr("refused: "));
  EXPECT_THAT(ask(MapCommand::kRename, "house"), HasSubstr("refused: "));
  EXPECT_THAT(ask(MapCommand::kDelete, present), HasSubstr("refused: slamd has map " + present + " open"));
  EXPECT_THAT(ask(MapCommand::kRename, present + " other"), HasSubstr("refused: slamd has map"));
  EXPECT_THAT(ask(MapCommand::kRestore, ""), HasSubstr("refused: no deleted map"));
  EXPECT_THAT(ask(MapCommand::kDelete, "house"), HasSubstr("map house is deleted"));
  EXPECT_FALSE(fs::exists(folder / "maps/house"));
  EXPECT_EQ(ask(MapCommand::kRestore, ""), "map house is back");
  EXPECT_TRUE(fs::exists(folder / "maps/house"));
  drive();
  EXPECT_TRUE(waitUntil([&] { return stored() == 2; })) << "the present map goes on";
  EXPECT_THAT(ask(MapCommand::kLoad, "house"), testing::Not(HasSubstr("refused")));
  EXPECT_THAT(ask(MapCommand::kDelete, "home"), HasSubstr("refused: store.map names map home"));
}

TEST_F(GraphKeeping, RefusesCommandsThatADiskWouldKeepWaiting) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1; }));
  HangingDisk disk;
  drive();
  ASSERT_TRUE(waitUntil([&] { return waiting() > 100ms; }));
  ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kReset, 8, ""}));
  const auto refused = answer();  // before the one who asked has given up
  ASSERT_TRUE(refused);
  EXPECT_FALSE(refused->accepted);
  EXPECT_THAT(refused->answer.words, HasSubstr("disk does not answer"));
  disk.release();
  ASSERT_TRUE(waitUntil([&] { return stored() == 2; }));
  ASSERT_TRUE(waitUntil([&] { return waiting() < 1s; })) << "the job that hung has ended, too";
  ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kReset, 9, ""}));
  EXPECT_TRUE(answer()->accepted);
}

TEST_F(GraphKeeping, RefusesACommandWhoseCheckpointHangs) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1 && waiting() == Duration(0); }));
  HangingDisk disk;
  ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kReset, 8, ""}));
  const auto refused = answer();
  ASSERT_TRUE(refused);
  EXPECT_FALSE(refused->accepted);
  EXPECT_THAT(refused->answer.words, HasSubstr("disk does not answer"));
  disk.release();
  ASSERT_TRUE(waitUntil([&] {  // the next one is taken as soon as the job has ended
    EXPECT_TRUE(channels->commands.map.tryPush({MapCommand::kSave, 9, ""}));
    const auto saved = answer();
    return saved && saved->accepted;
  }));
  EXPECT_EQ(stored(), 1) << "what was refused was not done";
}

TEST_F(GraphKeeping, EndsInTimeOnADiskThatHangs) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1; }));
  HangingDisk disk;
  drive();
  graph->worker().stop();
  mapper->worker().stop();
  graph->finish();
  mapper->finish();
  graph->jobs().store(mapper->drawn());
  EXPECT_FALSE(graph->jobs().waitUntilStored(monotonicNow() + 50ms));
  EXPECT_TRUE(graph->jobs().isWriting());
  disk.release();
  EXPECT_TRUE(graph->jobs().waitUntilStored(monotonicNow() + 20s));
  EXPECT_FALSE(graph->jobs().isWriting());
  EXPECT_EQ(stored(), 2);
}

TEST_F(GraphKeeping, WritesAtTheEndOverNoMapThatCameLate) {
  MapStore(folder / "maps", "kitchen").checkpoint(ChangingMap(5).map);
  fs::rename(folder / "maps", folder / "disk in the drawer");
  folder.write("maps", "not mounted yet");
  config.store.map = "kitchen";
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return channels->map_keyframes == 1; }));
  graph->worker().stop();
  mapper->worker().stop();
  fs::remove(folder / "maps");
  fs::rename(folder / "disk in the drawer", folder / "maps");
  graph->finish();
  mapper->finish();
  graph->jobs().store(mapper->drawn());
  EXPECT_TRUE(graph->jobs().waitUntilStored(monotonicNow() + 20s));
  EXPECT_EQ(MapStore::load(folder / "maps", "kitchen", config.map).state.keyframes.size(), 5);
  EXPECT_EQ(stored(), 1) << "under a name of its own";
}

TEST_F(GraphKeeping, HasNoPoseInAnEmptyMapToLocaliseIn) {
  config.mode = RunMode::kLocalise;
  fs::create_directories(folder / "maps");
  start();
  EXPECT_THAT(graph->jobs().report(monotonicNow()).problem.words(), HasSubstr("no map to localise in"));
  EXPECT_NE(graph->firstFrontEnd()->estimate(Timestamp(1s)).state, LocalisationState::kLocalised);
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  keyframe->origin = KeyframeOrigin::kLost;
  drive();  // which has nothing to be found in
  MapStore(folder / "maps", "home").checkpoint(ChangingMap(5).map);
  FrontEnd* found = nullptr;
  ASSERT_TRUE(
      waitUntil([&] { return channels->front_end.front_ends.popOne([&](FrontEnd* fresh) { found = fresh; }); }));
  const std::unique_ptr<FrontEnd> owned(found);
  EXPECT_NE(found->mapId(), keyframe->map_id);
  EXPECT_EQ(graph->jobs().report(monotonicNow()).problem.words(), "");
}

TEST_F(GraphKeeping, LocalisesInTheMapAndExtendsItAgainByCommand) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  drive();
  ASSERT_TRUE(waitUntil([&] { return stored() == 1; }));
  drive();  // not yet in the checkpoint
  const auto changeTo = [&](MapCommand::Kind kind) {
    EXPECT_TRUE(channels->commands.map.tryPush({kind, 7, ""}));
    const auto done = answer();
    EXPECT_TRUE(done && done->accepted) << (done ? done->answer.words : "");
    FrontEnd* fresh = nullptr;
    EXPECT_TRUE(waitUntil(
        [&] { return channels->front_end.front_ends.popOne([&](FrontEnd* next_one) { fresh = next_one; }); }));
    const std::unique_ptr<FrontEnd> owned(fresh);
    if (owned) keyframe->map_id = owned->mapId();
  };
  changeTo(MapCommand::kLocalise);
  EXPECT_EQ(stored(), 2);
  ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kLocalise, 8, ""}));
  EXPECT_THAT(answer()->answer.words, HasSubstr("already"));
  ASSERT_TRUE(channels->commands.map.tryPush({MapCommand::kSave, 9, ""}));
  EXPECT_FALSE(answer()->accepted);
  changeTo(MapCommand::kSlam);
  keyframe->origin = KeyframeOrigin::kLost;  // as a front end begins in a known map
  keyframe->session = 1;
  drive();
  EXPECT_TRUE(waitUntil([&] { return stored() == 3; })) << stored();
}

TEST_F(GraphKeeping, StoresWhereTheRobotWasKnownToBeLastAndNotWhereALostOneThinksItIs) {
  start();
  keyframe->map_id = graph->firstFrontEnd()->mapId();
  const auto report = [&](LocalisationState state, const Pose2& T_map_base, double gyro_bias) {
    PoseSnapshot snapshot;
    snapshot.map_id = keyframe->map_id;
    snapshot.pose.state = state;
    snapshot.pose.T_map_base = T_map_base;
    snapshot.odometry.gyro_bias = gyro_bias;
    channels->pose_for_graph.store(snapshot);
    const std::uint64_t ticks = graph->worker().ticks();
    ASSERT_TRUE(waitUntil([&] { return graph->worker().ticks() > ticks + 2; })) << "it has seen it";
  };
  const Pose2 known{1.5, -0.5, 0.25}, guessed{7.0, 8.0, 1.0};
  report(LocalisationState::kLocalised, known, 0.01);
  for (const LocalisationState state :
       {LocalisationState::kInitialising, LocalisationState::kDegraded, LocalisationState::kLost}) {
    report(state, guessed, 0.02);
    drive();
    ASSERT_TRUE(waitUntil([&] { return stored() == next; }));
    const auto name = MapStore::newest(folder / "maps");
    const MapState map = MapStore::load(folder / "maps", *name, config.map).state;
    EXPECT_EQ(map.T_map_base, known) << static_cast<int>(state);
    EXPECT_EQ(map.gyro_bias, 0.02) << "which is known all the same";
  }
}

TEST_F(GraphKeeping, BeginsWithoutAMapThatTheDiskDoesNotGiveInTime) {
  fs::create_directories(folder / "maps");
  MapStore(folder / "maps", "home").checkpoint(ChangingMap(5).map);
  HangingDisk disk;
  start();
  EXPECT_GT(waiting(), 1s);
  const std::uint64_t ticks = graph->worker().ticks();
  EXPECT_TRUE(waitUntil([&] { return graph->worker().ticks() > ticks + 3; }));
  disk.release();
  FrontEnd* found = nullptr;
  ASSERT_TRUE(
      waitUntil([&] { return channels->front_end.front_ends.popOne([&](FrontEnd* fresh) { found = fresh; }); }));
  const std::unique_ptr<FrontEnd> owned(found);
  EXPECT_TRUE(waitUntil([&] { return channels->map_keyframes == 5; }));
}

}  // namespace
}  // namespace slam::graph_thread_test
