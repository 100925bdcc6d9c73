// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/bus_thread.hpp"

#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <memory>
#include <optional>
#include <poll.h>
#include <slam/ack_t.hpp>
#include <slam/drive_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <utility>
#include <vector>

#include "app/threads/pose_thread.hpp"
#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/event_log.hpp"
#include "bus/local_client.hpp"
#include "core/plausibility.hpp"
#include "problems/answers.hpp"
#include "support/absurd.hpp"
#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::bus_thread_test {
namespace {

using namespace std::chrono_literals;
using test::waitUntil;

/// The bus thread alone. Whether there is a network or none: what it publishes goes into its record, too.
class Bus : public testing::Test {
 protected:
  Bus() {
    config.lcm.url = "udpm://239.255.76.67:" + std::to_string(20000 + getpid() % 20000) + "?ttl=0";
    config.output.record = folder / "record.lcm";
  }
  std::int64_t sent() const { return channels->bus_counters.published + channels->bus_counters.failures; }
  /// Runs until so many messages are out. @return the record
  std::vector<LogEvent> recordOf(BusThread& bus, std::int64_t messages) {
    bus.worker().start();
    return restOf(bus, messages);
  }
  /// The same of one that runs already.
  std::vector<LogEvent> restOf(BusThread& bus, std::int64_t messages) {
    EXPECT_TRUE(waitUntil([&] { return sent() >= messages; })) << sent() << " of " << messages;
    bus.worker().stop();
    EXPECT_TRUE(bus.publisher().recorder()->finish(monotonicNow() + 20s));
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
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
};

TEST_F(Bus, TwoThatPublishThePoseNoticeEachOtherWithinTwoSeconds) {
  const auto other_channels = std::make_unique<Channels>();
  config.output.record.clear();
  config.runtime.realtime = false;
  BusThread bus(config, channels->bus(), clock), other(config, other_channels->bus(), clock);
  PoseThread pose(config, channels->pose(), clock, bus.poseSender());
  PoseThread other_pose(config, other_channels->pose(), clock, other.poseSender());
  for (Worker* worker : {&bus.worker(), &other.worker(), &pose.worker(), &other_pose.worker()}) worker->start();
  std::int64_t count = 0;
  const auto publish = [&](bool both) {
    PoseSnapshot snapshot;
    snapshot.pose.stamp = monotonicNow();
    snapshot.pose.T_map_base.x = static_cast<double>(++count);
    channels->newest_pose.store(snapshot);
    channels->pose_wakeup.notify();
    snapshot.pose.T_map_base.x = -1.0;
    if (both) other_channels->newest_pose.store(snapshot), other_channels->pose_wakeup.notify();
  };
  const auto publishUntil = [&](bool both, auto&& condition, Duration limit) {
    for (const Timestamp end = monotonicNow() + limit; !condition() && monotonicNow() < end;) {
      publish(both);
      ::poll(nullptr, 0, 20);
    }
    return condition();
  };
  if (!publishUntil(
          false, [&] { return bus.publisher().linkState() == LinkState::kConnected; }, 5s))
    GTEST_SKIP() << "this machine has no multicast";
  EXPECT_FALSE(bus.publisher().hasRival()) << "its own come back";
  EXPECT_TRUE(publishUntil(
      true, [&] { return bus.publisher().hasRival() && other.publisher().hasRival(); }, 2s));
  EXPECT_TRUE(publishUntil(
      false, [&] { return !bus.publisher().hasRival(); }, 6s));
}

TEST_F(Bus, SendsWhatTheOtherThreadsHandItEachOnItsChannel) {
  const Timestamp stamp = monotonicNow();
  WheelReading wheels;
  wheels.sample.stamp = stamp + 1ms;
  wheels.sample.T_wheels_base = {1.0, 2.0, 0.5};
  wheels.angles = {7.0, 8.0, 9.0, 10.0};
  wheels.count = 2;
  channels->raw.wheels.tryPush(wheels);
  channels->raw.imu.tryPush({stamp + 2ms, {0.1, 0.2, 0.3}, {1.0, 2.0, 9.0}});
  const auto scan = std::make_unique<ReceivedScan>();
  scan->scan.stamp = stamp + 3ms;
  scan->scan.push({.range = 2.5F, .bearing = 0.5F, .time_offset = 0.0F, .intensity = 15.0F});
  channels->raw.scans.tryPush(*scan);
  PseudoLaser laser;
  laser.stamp = stamp + 4ms;
  laser.size = 2;
  channels->raw.views.tryPush(laser);
  map_meta_t meta{};
  meta.tiles = 11;
  channels->tiles.meta.tryPush(meta);
  map_tile_t tile{};
  tile.column = 12;
  channels->tiles.map.tryPush(tile);
  tile.column = 14;
  channels->tiles.lidar.tryPush(tile);
  tile.column = 15;
  channels->tiles.depth.tryPush(tile);
  HealthReport report{};
  report.health.summary = "well";
  channels->health.tryPush(report);
  channels->answers.tryPush({.id = 13, .accepted = true, .answer = {"saved"}});
  BusThread bus(config, channels->bus(), clock);
  std::map<std::string, LogEvent> record;
  for (const LogEvent& event : recordOf(bus, 12)) EXPECT_TRUE(record.emplace(event.channel, event).second);
  ASSERT_EQ(record.size(), 12U);

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
  EXPECT_EQ(decoded<problems_t>(record[channel::kProblems]).nproblems, 0);
  EXPECT_EQ(decoded<health_t>(record[channel::kHealth]).summary, "well");
  const auto ack = decoded<ack_t>(record[channel::kAck]);
  EXPECT_EQ(ack.id, 13);
  EXPECT_TRUE(ack.accepted);
  EXPECT_EQ(ack.message, "saved");
}

TEST_F(Bus, RecordsThePosesThatThePoseThreadSends) {
  SentPose pose;
  pose.pose.state = LocalisationState::kLocalised;
  pose.map_id = 5;
  BusThread bus(config, channels->bus(), clock);
  for (pose.utime = 1; pose.utime <= 3; ++pose.utime) channels->sent_poses.tryPush(pose);
  channels->raw.imu.tryPush({monotonicNow(), {0.1, 0.2, 0.3}, {1.0, 2.0, 9.0}});  // which it sends itself
  std::map<std::string, std::vector<LogEvent>> record;
  for (const LogEvent& event : recordOf(bus, 1)) record[event.channel].push_back(event);
  for (const char* name : {channel::kOdometry, channel::kSlamPose, channel::kPose}) {
    EXPECT_EQ(record[name].size(), 3U) << name;
  }
  EXPECT_EQ(decoded<pose_estimate_t>(record[channel::kSlamPose][2]).utime, 3);
  EXPECT_EQ(sent(), 1) << "they are counted by who sends them";
}

TEST_F(Bus, AsksForTheWholeMapAsOftenAsConfigured) {
  for (const auto& [period, again] : {std::pair(0.002, true), {3600.0, false}}) {
    config.lcm.map_refresh = period;
    channels->requests.refresh = false;
    BusThread bus(config, channels->bus(), clock);
    bus.worker().start();
    ASSERT_TRUE(waitUntil([&] { return channels->requests.refresh.exchange(false); })) << "once at the start";
    int asked = 0;
    const std::uint64_t ticks = bus.worker().ticks();
    ASSERT_TRUE(waitUntil([&] {
      channels->bus_wakeup.notify();
      asked += channels->requests.refresh.exchange(false);
      return again ? asked >= 30 : bus.worker().ticks() > ticks + 50;
    })) << period;
    EXPECT_EQ(asked > 0, again) << period;
  }
}

/// A client of the bus thread's socket.
class Asking {
 public:
  explicit Asking(const std::string& path) { EXPECT_EQ(client_.open(path), 0); }
  bool ask(std::int32_t id, const std::string& verb, const Pose2& pose = {}) {
    command_t command{};
    command.id = id;
    command.verb = verb;
    command.pose[0] = pose.x, command.pose[1] = pose.y, command.pose[2] = pose.theta;
    return client_.send(channel::kCommand, test::encoded(command));
  }
  template <typename Message>
  std::optional<Message> next(const std::string& channel, std::chrono::milliseconds wait = 10s) {
    const auto datagram = client_.next(wait);
    const Packet packet = datagram ? parsePacket(*datagram) : Packet{};
    if (packet.channel == channel::kAnswer && channel != channel::kAnswer) return next<Message>(channel, wait);
    return packet.channel == channel ? decodeChecked<Message>(packet.data) : std::nullopt;
  }

 private:
  LocalClient client_;
};

TEST_F(Bus, AnswersWhoAskedOverTheSocket) {
  config.runtime.socket = folder / "socket";
  config.lcm.commands = false;
  BusThread bus(config, channels->bus(), clock);
  Asking first(config.runtime.socket), second(config.runtime.socket);  // it is there before the thread runs
  bus.worker().start();
  std::vector<MapCommand> commands;
  const auto taken = [&](std::size_t count) {
    return waitUntil([&] {
      channels->commands.map.drain([&](const MapCommand& command) { commands.push_back(command); });
      return commands.size() >= count;
    });
  };
  EXPECT_TRUE(first.ask(7, "save"));  // both by the same number
  ASSERT_TRUE(taken(1));
  EXPECT_TRUE(second.ask(7, "reset"));
  ASSERT_TRUE(taken(2));
  EXPECT_EQ(commands[0].kind, MapCommand::kSave);
  EXPECT_EQ(commands[1].kind, MapCommand::kReset);
  channels->answers.tryPush({commands[1].id, true, {"a new map"}});
  channels->answers.tryPush({commands[0].id, false, answerOf({answer::kDiskSilent})});
  channels->bus_wakeup.notify();
  const auto parts = first.next<problems_t>(channel::kAnswer);
  const auto of_second = second.next<ack_t>(channel::kAck), of_first = first.next<ack_t>(channel::kAck);
  ASSERT_TRUE(of_first && of_second && parts);
  ASSERT_EQ(parts->problems.size(), 1U);
  EXPECT_EQ(parts->problems[0].id, "disk_silent");
  EXPECT_EQ(parts->utime, of_first->utime);
  EXPECT_EQ(of_second->id, 7);
  EXPECT_TRUE(of_second->accepted);
  EXPECT_EQ(of_second->message, "a new map");
  EXPECT_EQ(of_first->id, 7);
  EXPECT_FALSE(of_first->accepted);
  EXPECT_EQ(of_first->message, "the disk does not answer; try again when it does");

  EXPECT_TRUE(first.ask(-8, "make_coffee"));
  const auto unknown = first.next<ack_t>(channel::kAck);
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->id, -8);
  EXPECT_FALSE(unknown->accepted);
  EXPECT_FALSE(second.next<ack_t>(channel::kAck, 0ms));

  HealthReport report{};
  report.health.summary = "well";
  channels->health.tryPush(report);
  channels->bus_wakeup.notify();
  EXPECT_TRUE(first.next<problems_t>(channel::kProblems)) << "what health tells in words comes first";
  EXPECT_TRUE(second.next<problems_t>(channel::kProblems));
  EXPECT_EQ(first.next<health_t>(channel::kHealth).value_or(health_t{}).summary, "well");
  EXPECT_EQ(second.next<health_t>(channel::kHealth).value_or(health_t{}).summary, "well");
  EXPECT_EQ(channels->bus_counters.socket_clients, 2U);
}

TEST_F(Bus, RefusesPosesThatCannotBeCountsThemAndReportsWhy) {
  config.runtime.socket = folder / "socket";
  BusThread bus(config, channels->bus(), clock);
  Asking person(config.runtime.socket);
  bus.worker().start();
  std::uint64_t refused = 0;
  const auto expectRefused = [&](const Pose2& pose, const char* words) {
    ASSERT_TRUE(person.ask(1, "set_pose", pose));
    const auto answer = person.next<ack_t>(channel::kAck);
    ASSERT_TRUE(answer);
    EXPECT_FALSE(answer->accepted) << pose.x << ' ' << pose.y << ' ' << pose.theta;
    EXPECT_THAT(answer->message, testing::AllOf(testing::StartsWith(words), testing::HasSubstr("stays as it was")));
    ++refused;
  };
  for (const double value : test::absurdNumbers(kPlausible.farthest)) {
    expectRefused({value, 0.0, 0.0}, "x ");
    expectRefused({0.0, value, 0.0}, "y ");
    expectRefused({0.0, 0.0, value}, "theta ");
  }
  EXPECT_GT(refused, 200U);
  for (const double value : {1e-310, 9999.0, -10e3}) {
    ASSERT_TRUE(person.ask(2, "set_pose", {value, value, 3.0}));
    const auto answer = person.next<ack_t>(channel::kAck);
    ASSERT_TRUE(answer && answer->accepted) << value;
  }
  EXPECT_EQ(channels->bus_counters.refused_commands, refused);
  std::vector<double> taken;
  channels->commands.set_poses.drain([&](const SetPose& given) { taken.push_back(given.T_map_base.x); });
  EXPECT_THAT(taken, testing::ElementsAre(1e-310, 9999.0, -10e3)) << "none of the others went on";
}

TEST_F(Bus, CountsWhatIsNoCommandOnTheSocket) {
  config.runtime.socket = folder / "socket";
  BusThread bus(config, channels->bus(), clock);
  bus.worker().start();
  LocalClient client;
  ASSERT_EQ(client.open(config.runtime.socket), 0);
  EXPECT_TRUE(client.send(channel::kCommand, std::vector<std::uint8_t>{1, 2, 3}));
  EXPECT_TRUE(client.send(std::string(70, 'x'), {}));  // names no channel
  EXPECT_TRUE(
      waitUntil([&] { return channels->bus_counters.bad_messages == 1 && channels->bus_counters.socket_bad == 1; }));
  EXPECT_FALSE(bus.socketProblem());
}

TEST_F(Bus, ReportsWhyItsSocketIsNotOpen) {
  config.runtime.socket = folder / "missing/socket";
  BusThread bus(config, channels->bus(), clock);
  bus.worker().start();
  EXPECT_TRUE(waitUntil([&] { return bus.socketProblem().is(problem::kSocketNoFolder); }));
  std::filesystem::create_directory(folder / "missing");
  EXPECT_TRUE(waitUntil([&] { return !bus.socketProblem(); }));
}

/// Programs that send SLAM_DRIVE, and what comes of it to the base.
class BusOfDrives : public Bus {
 protected:
  BusOfDrives() {
    config.output.record.clear();
    config.base_device.speed_commands = true;
  }
  void start() {
    bus_.emplace(config, channels->bus(), clock);
    bus_->worker().start();
  }
  static drive_t driveOf(double vx, Duration behind) {
    drive_t drive{};
    drive.utime = std::chrono::duration_cast<std::chrono::microseconds>(
                      std::chrono::system_clock::now().time_since_epoch() - behind)
                      .count();
    drive.vx = vx;
    return drive;
  }
  /// Publishes each 20 ms until the condition holds of the newest speed that reached the base.
  template <typename Send, typename Condition>
  [[nodiscard]] bool sendUntil(Send&& send, Condition&& condition, Duration limit = 5s) {
    for (const Timestamp end = monotonicNow() + limit; monotonicNow() < end;) {
      send();
      ::poll(nullptr, 0, 20);
      channels->commands.drives.drain([&](const DriveCommand& command) { newest_ = command; });
      if (condition()) return true;
    }
    return false;
  }
  bool connected() {
    return sendUntil([&] { a_.publish(channel::kDrive, &kStop); }, [&] { return newest_.has_value(); }, 3s);
  }

  const drive_t kStop = driveOf(0.0, 0s);
  lcm::LCM a_{config.lcm.url}, b_{config.lcm.url};  // two programs
  std::optional<BusThread> bus_;
  std::optional<DriveCommand> newest_;
};

TEST_F(BusOfDrives, HandOnWhenASpeedWasSentNotWhenItCame) {
  start();
  if (!connected()) GTEST_SKIP() << "this machine has no multicast";
  Timestamp sent{};
  ASSERT_TRUE(sendUntil(
      [&] {
        const drive_t drive = driveOf(0.25, 300ms);
        sent = monotonicNow() - 300ms;
        a_.publish(channel::kDrive, &drive);
      },
      [&] { return newest_->twist.vx == 0.25; }));
  EXPECT_LE(newest_->given, sent + 20ms) << "it has waited, and is to be driven for so much less";
  EXPECT_GE(newest_->given, sent - 1s);
}

TEST_F(BusOfDrives, AreNotDrivenWhenTheyAreOlderThanHalfASecond) {
  start();
  if (!connected()) GTEST_SKIP() << "this machine has no multicast";
  const auto send = [&](double vx, Duration behind) {
    const drive_t drive = driveOf(vx, behind);
    a_.publish(channel::kDrive, &drive);
  };
  ASSERT_TRUE(sendUntil([&] { send(0.25, 0s); }, [&] { return newest_->twist.vx == 0.25; }));
  EXPECT_FALSE(sendUntil([&] { send(0.5, 700ms); }, [&] { return newest_->twist.vx == 0.5; }, 500ms));
  EXPECT_GT(channels->bus_counters.refused[static_cast<std::size_t>(Refusal::kOld) - 1], 0U);
}

TEST_F(BusOfDrives, AreStoppedByAZeroWhateverItsStamp) {
  start();
  if (!connected()) GTEST_SKIP() << "this machine has no multicast";
  const auto drives = [&] { return newest_->twist.vx == 0.25; };
  const auto drive = [&] {
    const drive_t message = driveOf(0.25, 0s);
    a_.publish(channel::kDrive, &message);
  };
  for (const Duration behind : {Duration(30s), Duration(-1h)}) {
    ASSERT_TRUE(sendUntil(drive, drives));
    const drive_t stop = driveOf(0.0, behind);
    bool once = true;
    ASSERT_TRUE(sendUntil(
        [&] {
          drive();
          if (std::exchange(once, false)) b_.publish(channel::kDrive, &stop);
        },
        [&] { return !drives(); }));
    EXPECT_EQ(newest_->twist.vx, 0.0);
    EXPECT_LT(monotonicNow() - newest_->given, 1s) << "it is as new as it came";
    EXPECT_FALSE(sendUntil(drive, drives, 1s)) << "who drove goes on after a pause only";
    EXPECT_THAT(bus_->driveProblem().words(), testing::HasSubstr("SLAM_DRIVE comes from 2 programs ("));
    ::poll(nullptr, 0, 600);
  }
  drive_t timeless = driveOf(0.0, 0s);
  timeless.utime = 0;
  ASSERT_TRUE(sendUntil(drive, drives));
  EXPECT_TRUE(sendUntil([&] { b_.publish(channel::kDrive, &timeless); }, [&] { return !drives(); }));
}

TEST_F(BusOfDrives, AreThoseOfOneProgramByTheOrderThatIsConfigured) {
  for (const DriveOrder order : {DriveOrder::kFirst, DriveOrder::kLast}) {
    config.base_device.drive_order = order;
    start();
    if (!connected()) GTEST_SKIP() << "this machine has no multicast";
    const drive_t end = driveOf(0.0, 0s);
    ASSERT_TRUE(sendUntil([&] { a_.publish(channel::kDrive, &end); }, [&] { return newest_->twist.vx == 0.0; }));
    const auto send = [&](lcm::LCM& lcm, double vx) {
      const drive_t message = driveOf(vx, 0s);
      lcm.publish(channel::kDrive, &message);
    };
    ASSERT_TRUE(sendUntil([&] { send(a_, 0.25); }, [&] { return newest_->twist.vx == 0.25; }));
    const bool followed = sendUntil([&] { send(a_, 0.25), send(b_, 0.5); }, [&] { return newest_->twist.vx == 0.5; },
                                    order == DriveOrder::kFirst ? 1500ms : 5s);
    EXPECT_EQ(followed, order == DriveOrder::kLast);
    EXPECT_GT(channels->bus_counters.drives_not_followed, 0U);
    EXPECT_TRUE(sendUntil([&] { send(a_, 0.25), send(b_, 0.5); },
                          [&] { return bus_->driveProblem().is(problem::kDriveSenders); }));
    bus_.reset();
  }
}

TEST_F(Bus, TalksToTheGroupThatIsConfigured) {
  for (const char* url : {"udpm://239.255.76.67:7669?ttl=0", "udpm://239.255.76.70:7700?ttl=0"}) {
    config.lcm.url = url;
    const BusThread bus(config, channels->bus(), clock);
    EXPECT_EQ(bus.url().text, url);
    EXPECT_NE(std::string(url).find(bus.url().name()), std::string::npos) << bus.url().name();
  }
}

}  // namespace
}  // namespace slam::bus_thread_test
