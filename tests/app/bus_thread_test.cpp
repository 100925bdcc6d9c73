// SPDX-License-Identifier: BSD-3-Clause
#include "app/bus_thread.hpp"

#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <slam/ack_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/event_log.hpp"
#include "bus/local_client.hpp"
#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using test::waitUntil;

/// The bus thread alone. Whether there is a network or none: what it publishes goes into its record, too.
class Bus : public testing::Test {
 protected:
  Bus() {
    config.lcm.url = "udpm://239.255.76.67:7669?ttl=0";
    config.output.record = folder / "record.lcm";
  }
  std::int64_t sent() const { return exchange->published + exchange->publish_failures; }
  /// Runs until so many messages are out. @return the record
  std::vector<LogEvent> recordOf(BusThread& bus, std::int64_t messages) {
    bus.worker().start();
    return restOf(bus, messages);
  }
  /// The same of one that runs already.
  std::vector<LogEvent> restOf(BusThread& bus, std::int64_t messages) {
    EXPECT_TRUE(waitUntil([&] { return sent() >= messages; })) << sent() << " of " << messages;
    bus.worker().stop();
    EXPECT_TRUE(bus.recorder()->finish(monotonicNow() + 20s));
    std::vector<LogEvent> events;
    EventLogReader reader(folder / "record.lcm");
    for (LogEvent event; reader.next(event);) events.push_back(event);
    return events;
  }
  template <typename Message>
  static Message decoded(const LogEvent& event) {
    Message message{};
    const int size = static_cast<int>(event.data.size());
    EXPECT_EQ(message.decode(event.data.data(), 0, size), size) << event.channel;
    return message;
  }

  const test::Folder folder;
  Config config;
  WallClock clock;
  std::unique_ptr<Exchange> exchange = std::make_unique<Exchange>();
};

TEST_F(Bus, SendsWhatTheOtherThreadsHandItEachOnItsChannel) {
  const Timestamp stamp = monotonicNow();
  WheelReading wheels;
  wheels.sample.stamp = stamp + 1ms;
  wheels.sample.T_wheels_base = {1.0, 2.0, 0.5};
  wheels.angles = {7.0, 8.0, 9.0, 10.0};
  wheels.count = 2;
  exchange->wheels_out.tryPush(wheels);
  exchange->imu_out.tryPush({stamp + 2ms, {0.1, 0.2, 0.3}, {1.0, 2.0, 9.0}});
  const auto scan = std::make_unique<ReceivedScan>();
  scan->scan.stamp = stamp + 3ms;
  scan->scan.push({.range = 2.5F, .bearing = 0.5F, .time_offset = 0.0F, .intensity = 15.0F});
  exchange->scans_out.tryPush(*scan);
  PseudoLaser laser;
  laser.stamp = stamp + 4ms;
  laser.size = 2;
  exchange->views_out.tryPush(laser);
  map_meta_t meta{};
  meta.tiles = 11;
  exchange->map_meta.tryPush(meta);
  map_tile_t tile{};
  tile.column = 12;
  exchange->map_tiles.tryPush(tile);
  tile.column = 14;
  exchange->lidar_tiles.tryPush(tile);
  tile.column = 15;
  exchange->depth_tiles.tryPush(tile);
  health_t health{};
  health.summary = "well";
  exchange->health.tryPush(health);
  exchange->map_answers.tryPush({.id = 13, .accepted = true, .message = "saved"});
  BusThread bus(config, *exchange, clock);
  std::map<std::string, LogEvent> record;
  for (const LogEvent& event : recordOf(bus, 11)) EXPECT_TRUE(record.emplace(event.channel, event).second);
  ASSERT_EQ(record.size(), 11U);

  const auto w = decoded<wheels_t>(record[channel::kWheels]);
  EXPECT_EQ(w.utime, clock.utime(stamp + 1ms));
  EXPECT_EQ((Pose2{w.x, w.y, w.theta}), wheels.sample.T_wheels_base);
  EXPECT_THAT(w.angles, testing::ElementsAre(7.0, 8.0));
  const auto i = decoded<imu_t>(record[channel::kImu]);
  EXPECT_EQ(i.utime, clock.utime(stamp + 2ms));
  EXPECT_EQ(i.accel[2], 9.0);
  const auto s = decoded<scan_t>(record[channel::kScan]);
  EXPECT_EQ(s.utime, clock.utime(stamp + 3ms));
  EXPECT_THAT(s.ranges, testing::ElementsAre(2.5F));
  EXPECT_EQ(decoded<bot_core::planar_lidar_t>(record[channel::kLaser]).utime, s.utime);
  const auto d = decoded<depth_t>(record[channel::kDepth]);
  EXPECT_EQ(d.utime, clock.utime(stamp + 4ms));
  EXPECT_EQ(d.nbeams, 2);
  EXPECT_EQ(decoded<map_meta_t>(record[channel::kMapMeta]).tiles, 11);
  EXPECT_EQ(decoded<map_tile_t>(record[channel::kMapTile]).column, 12);
  EXPECT_EQ(decoded<map_tile_t>(record[channel::kMapLidar]).column, 14);
  EXPECT_EQ(decoded<map_tile_t>(record[channel::kMapDepth]).column, 15);
  EXPECT_EQ(decoded<health_t>(record[channel::kHealth]).summary, "well");
  const auto ack = decoded<ack_t>(record[channel::kAck]);
  EXPECT_EQ(ack.id, 13);
  EXPECT_TRUE(ack.accepted);
  EXPECT_EQ(ack.message, "saved");
}

TEST_F(Bus, SendsPoseOnlyWhileThePoseIsValid) {
  using enum LocalisationState;
  BusThread bus(config, *exchange, clock);
  PoseSnapshot snapshot;
  snapshot.map_id = 5;
  bus.worker().start();
  std::int64_t messages = 0;
  for (const LocalisationState state : {kInitialising, kLocalised, kDegraded, kLost}) {
    snapshot.pose.state = state;
    snapshot.pose.stamp = snapshot.odometry.stamp = monotonicNow();
    snapshot.pose.T_map_base = {1.0 * static_cast<int>(state), 0.0, 0.0};
    snapshot.odometry.T_odom_base = {0.0, 1.0 * static_cast<int>(state), 0.0};
    snapshot.scans = state == kInitialising ? 0 : 1;  // one scan, which three snapshots tell of
    snapshot.scan_received = monotonicNow();
    exchange->pose_for_bus.store(snapshot);
    exchange->bus_wakeup.notify();
    messages += state == kLocalised || state == kDegraded ? 3 : 2;
    ASSERT_TRUE(waitUntil([&] { return sent() >= messages; }));
  }
  std::map<std::string, std::vector<LogEvent>> record;
  for (const LogEvent& event : restOf(bus, messages)) record[event.channel].push_back(event);
  ASSERT_EQ(record[channel::kPose].size(), 2U);
  ASSERT_EQ(record[channel::kSlamPose].size(), 4U);
  ASSERT_EQ(record[channel::kOdometry].size(), 4U);
  EXPECT_EQ(decoded<bot_core::pose_t>(record[channel::kPose][0]).pos[0], 1.0);
  EXPECT_EQ(decoded<bot_core::pose_t>(record[channel::kPose][1]).pos[0], 2.0);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pose = decoded<pose_estimate_t>(record[channel::kSlamPose][i]);
    EXPECT_EQ(pose.state, i);
    EXPECT_EQ(pose.map_id, 5);
    EXPECT_EQ(pose.x, static_cast<double>(i));
    EXPECT_EQ(decoded<odometry_t>(record[channel::kOdometry][i]).y, static_cast<double>(i));
  }
  EXPECT_EQ(exchange->scan_to_pose.summary().count, 1) << "each scan counts once";
}

TEST_F(Bus, AsksForTheWholeMapAsOftenAsConfigured) {
  for (const auto& [period, again] : {std::pair(0.002, true), {3600.0, false}}) {
    config.lcm.map_refresh = period;
    exchange->refresh_map = false;
    BusThread bus(config, *exchange, clock);
    bus.worker().start();
    ASSERT_TRUE(waitUntil([&] { return exchange->refresh_map.exchange(false); })) << "once at the start";
    int asked = 0;
    const std::uint64_t ticks = bus.worker().ticks();
    ASSERT_TRUE(waitUntil([&] {
      exchange->bus_wakeup.notify();
      asked += exchange->refresh_map.exchange(false);
      return again ? asked >= 30 : bus.worker().ticks() > ticks + 50;
    })) << period;
    EXPECT_EQ(asked > 0, again) << period;
  }
}

/// A client of the bus thread's socket.
class Asking {
 public:
  explicit Asking(const std::string& path) { EXPECT_EQ(client_.open(path), 0); }
  bool ask(std::int32_t id, const std::string& verb) {
    command_t command{};
    command.id = id;
    command.verb = verb;
    return client_.send(channel::kCommand, test::encoded(command));
  }
  template <typename Message>
  std::optional<Message> next(const std::string& channel, std::chrono::milliseconds wait = 10s) {
    const auto datagram = client_.next(wait);
    const Packet packet = datagram ? parsePacket(*datagram) : Packet{};
    return packet.channel == channel ? decodeChecked<Message>(packet.data) : std::nullopt;
  }

 private:
  LocalClient client_;
};

TEST_F(Bus, AnswersWhoAskedOverTheSocket) {
  config.runtime.socket = folder / "socket";
  config.lcm.commands = false;
  BusThread bus(config, *exchange, clock);
  Asking first(config.runtime.socket), second(config.runtime.socket);  // it is there before the thread runs
  bus.worker().start();
  std::vector<MapCommand> commands;
  const auto taken = [&](std::size_t count) {
    return waitUntil([&] {
      exchange->map_commands.drain([&](const MapCommand& command) { commands.push_back(command); });
      return commands.size() >= count;
    });
  };
  EXPECT_TRUE(first.ask(7, "save"));  // both by the same number
  ASSERT_TRUE(taken(1));
  EXPECT_TRUE(second.ask(7, "reset"));
  ASSERT_TRUE(taken(2));
  EXPECT_EQ(commands[0].kind, MapCommand::kSave);
  EXPECT_EQ(commands[1].kind, MapCommand::kReset);
  exchange->map_answers.tryPush({commands[1].id, true, "a new map"});
  exchange->map_answers.tryPush({commands[0].id, false, "the disk is full"});
  exchange->bus_wakeup.notify();
  const auto of_second = second.next<ack_t>(channel::kAck), of_first = first.next<ack_t>(channel::kAck);
  ASSERT_TRUE(of_first && of_second);
  EXPECT_EQ(of_second->id, 7);
  EXPECT_TRUE(of_second->accepted);
  EXPECT_EQ(of_second->message, "a new map");
  EXPECT_EQ(of_first->id, 7);
  EXPECT_FALSE(of_first->accepted);
  EXPECT_EQ(of_first->message, "the disk is full");

  EXPECT_TRUE(first.ask(-8, "make_coffee"));
  const auto unknown = first.next<ack_t>(channel::kAck);
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->id, -8);
  EXPECT_FALSE(unknown->accepted);
  EXPECT_FALSE(second.next<ack_t>(channel::kAck, 0ms));

  health_t health{};
  health.summary = "well";
  exchange->health.tryPush(health);
  exchange->bus_wakeup.notify();
  EXPECT_EQ(first.next<health_t>(channel::kHealth).value_or(health_t{}).summary, "well");
  EXPECT_EQ(second.next<health_t>(channel::kHealth).value_or(health_t{}).summary, "well");
  EXPECT_EQ(exchange->socket_clients, 2U);
}

TEST_F(Bus, CountsWhatIsNoCommandOnTheSocket) {
  config.runtime.socket = folder / "socket";
  BusThread bus(config, *exchange, clock);
  bus.worker().start();
  LocalClient client;
  ASSERT_EQ(client.open(config.runtime.socket), 0);
  EXPECT_TRUE(client.send(channel::kCommand, std::vector<std::uint8_t>{1, 2, 3}));
  EXPECT_TRUE(client.send(std::string(70, 'x'), {}));  // names no channel
  EXPECT_TRUE(waitUntil([&] { return exchange->bad_messages == 1 && exchange->socket_bad == 1; }));
  EXPECT_EQ(bus.socketProblem(), "");
}

TEST_F(Bus, SaysWhyItsSocketIsNotOpen) {
  config.runtime.socket = folder / "missing/socket";
  BusThread bus(config, *exchange, clock);
  bus.worker().start();
  EXPECT_TRUE(waitUntil([&] { return bus.socketProblem().find("missing/socket: No such file") != std::string::npos; }));
  std::filesystem::create_directory(folder / "missing");
  EXPECT_TRUE(waitUntil([&] { return bus.socketProblem().empty(); }));
}

TEST_F(Bus, TalksToTheGroupThatIsConfigured) {
  for (const char* url : {"udpm://239.255.76.67:7669?ttl=0", "udpm://239.255.76.70:7700?ttl=0"}) {
    config.lcm.url = url;
    const BusThread bus(config, *exchange, clock);
    EXPECT_EQ(bus.url().text, url);
    EXPECT_NE(std::string(url).find(bus.url().name()), std::string::npos) << bus.url().name();
  }
}

}  // namespace
}  // namespace slam
