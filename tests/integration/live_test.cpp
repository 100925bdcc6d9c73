// SPDX-License-Identifier: BSD-3-Clause
#include "integration/live.hpp"

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <random>
#include <slam/ack_t.hpp>
#include <slam/command_t.hpp>
#include <slam/depth_t.hpp>
#include <slam/health_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <sstream>
#include <sys/socket.h>
#include <utility>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "bus/packets.hpp"
#include "store/map_store.hpp"
#include "support/network.hpp"

namespace slam::live_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::Clock;
using test::kBin;
using test::kCamera;
using test::kConfig;
using test::kPatience;
using test::kSanitized;
using test::kUrl;
using test::Listener;
using test::Live;
using test::Process;

TEST_F(Live, PublishesEveryChannelAtItsRate) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("120");
  startDaemon({});
  const bool localised = listener.until(
      [&] {
        const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
        return pose && pose->state == 1 && listener.count(channel::kHealth) > 0;
      },
      30s);
  ASSERT_TRUE(localised) << daemonLog();

  Process logger({"lcm-logger", "-q", "-f", "--lcm-url=" + kUrl, folder_ / "recorded.lcm"}, folder_ / "logger.txt");
  listener.forget();

  // What comes in some seconds; a loaded machine takes longer. Rates are those of the stamps.
  std::map<std::string, int> enough = {{channel::kPose, 480}, {channel::kSlamPose, 480}, {channel::kOdometry, 480},
                                       {channel::kScan, 32},  {channel::kLaser, 32},     {channel::kWheels, 120},
                                       {channel::kImu, 200},  {channel::kHealth, 6},     {channel::kMapMeta, 1},
                                       {channel::kMapTile, 1}};
  if (kCamera) enough[channel::kDepth] = 120;
  EXPECT_TRUE(listener.until(
      [&] {
        return std::all_of(enough.begin(), enough.end(),
                           [&](const auto& wanted) { return listener.count(wanted.first) >= wanted.second; });
      },
      60s))
      << daemonLog();
  for (const auto& [name, count] : enough) EXPECT_GE(listener.count(name), count) << name;
  EXPECT_GT(listener.medianInterval(channel::kPose), 1.0 / 140.0);
  EXPECT_LT(listener.medianInterval(channel::kPose), kPatience / 60.0);
  EXPECT_NEAR(listener.medianInterval(channel::kScan), 1.0 / 5.5, 0.03);
  EXPECT_LT(listener.medianInterval(channel::kHealth), 1.2);  // and at once on news, such as a late thread
  EXPECT_NEAR(listener.count(channel::kLaser), listener.count(channel::kScan), 1);
  EXPECT_LT(listener.largest(), 65499U);

  const auto scan = listener.last<scan_t>(channel::kScan);
  ASSERT_TRUE(scan);
  EXPECT_GT(scan->nbeams, 500);  // express mode: 4000 samples a second, 5.5 turns
  EXPECT_NEAR(scan->time_offsets.back(), 1.0 / 5.5, 0.02);
  const auto now =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch());
  EXPECT_NEAR(static_cast<double>(scan->utime), static_cast<double>(now.count()), 2e6);

  const auto pose = listener.last<bot_core::pose_t>(channel::kPose);
  ASSERT_TRUE(pose);
  EXPECT_NEAR(std::hypot(pose->orientation[0], pose->orientation[3]), 1.0, 1e-9);
  const auto imu = listener.last<imu_t>(channel::kImu);
  ASSERT_TRUE(imu);
  EXPECT_NEAR(imu->accel[2], 9.8, 0.5);
  const auto depth = listener.last<depth_t>(channel::kDepth).value_or(depth_t{});
  if (kCamera) {
    EXPECT_EQ(depth.nbeams, 118);  // half a degree each
    EXPECT_GT(std::count_if(depth.kinds.begin(), depth.kinds.end(), [](auto kind) { return kind == 2; }), 10);
    EXPECT_LT(std::abs(static_cast<double>(depth.utime - now.count())), 2e6);
  }
  const auto tile = listener.last<map_tile_t>(channel::kMapTile);
  ASSERT_TRUE(tile);
  EXPECT_EQ(tile->ncells, tile->side * tile->side);
  const auto all_stream = [&] {
    const auto health = listener.last<health_t>(channel::kHealth);
    return health && std::all_of(health->devices.begin(), health->devices.end(), [](const device_health_t& device) {
             return device.state == 2 || (kSanitized && device.state == 3);
           });
  };
  EXPECT_TRUE(listener.until(all_stream, 10s)) << daemonLog();

  // What lcm-logger wrote, slam-replay reads.
  logger.signal(SIGTERM);
  logger.wait(5s);
  Process replay({kBin + "/slam-replay", "--config", kConfig, "--log", folder_ / "recorded.lcm", "--trajectory",
                  folder_ / "replayed.tum"},
                 folder_ / "replay.txt");
  EXPECT_EQ(replay.wait(20s), 0);
  EXPECT_GT(fs::file_size(folder_ / "replayed.tum"), 1000U);
}

TEST_F(Live, StopsOnSigtermWithTheMapSaved) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("60");
  startDaemon({});
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kMapTile) > 3; }, 15s)) << daemonLog();
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(2s), 0) << daemonLog();
  for (const char* ending : {".yaml", ".pgm", ".png"}) EXPECT_TRUE(fs::exists(folder_ / ("map" + std::string(ending))));
}

TEST_F(Live, ReportsInWordsWhatIsMissing) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startDaemon({});  // no simulator: neither lidar nor board
  const auto lidarReason = [&] {
    const auto health = listener.last<health_t>(channel::kHealth);
    return health && !health->devices.empty() ? health->devices[0].reason : std::string();
  };
  ASSERT_TRUE(listener.until([&] { return lidarReason().find("no such port") != std::string::npos; }, 10s))
      << daemonLog();
  EXPECT_EQ(listener.count(channel::kPose), 0);  // no pose is published as valid that is not

  startSimulator("60");  // plugged in while the daemon runs
  EXPECT_TRUE(listener.until([&] { return listener.count(channel::kPose) > 10; }, 15s)) << daemonLog();

  sim_.reset();  // both unplugged
  listener.forget();
  EXPECT_TRUE(listener.until([&] { return lidarReason().find("no such port") != std::string::npos; }, 10s))
      << daemonLog();
  EXPECT_GT(listener.count(channel::kSlamPose), 0);
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(2s), 0) << daemonLog();
}

TEST_F(Live, MapsByTheLidarWhereTheCamerasHeightIsNotKnown) {
  if (!kCamera) GTEST_SKIP() << "without the simulated OpenNI2 driver";
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("60");
  startDaemon({"depth.z=0.0"});
  const auto said = [&] {
    const auto health = listener.last<health_t>(channel::kHealth);
    return health &&
           health->summary.find("depth: images are not used; slamd draws what the lidar sees alone; fix: measure") !=
               std::string::npos;
  };
  EXPECT_TRUE(listener.until(said, kPatience * 10s)) << daemonLog();
  EXPECT_TRUE(listener.until([&] { return listener.count(channel::kMapTile) > 3; }, 15s)) << daemonLog();
  EXPECT_EQ(listener.last<pose_estimate_t>(channel::kSlamPose)->state, 1);
  EXPECT_EQ(listener.count(channel::kDepth), 0);
}

TEST_F(Live, TakesSensorsFromLcm) {
  Process sim({kBin + "/slam-sim", "--scene", "tile-rectangle", "--seconds", "6", "--log", folder_ / "sim.lcm"},
              folder_ / "sim.txt");
  ASSERT_EQ(sim.wait(20s), 0);
  Listener listener;
  ASSERT_TRUE(listener.good());
  startDaemon({"lidar.driver='lcm'", "base.driver='lcm'", "imu.driver='lcm'"});
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kHealth) > 0; }, 10s)) << daemonLog();

  // Hostile datagrams first: they are counted, and the good ones behind them are used.
  const std::vector<std::uint8_t> hostile(34, 0x7F);
  for (const char* name : {channel::kScan, channel::kWheels, channel::kImu}) {
    for (int i = 0; i < 20; ++i) listener.lcm().publish(name, hostile.data(), static_cast<unsigned>(hostile.size()));
  }
  // The log's own pace: its stamps moved to now.
  EventLogReader log(folder_ / "sim.lcm");
  const auto start = Clock::now();
  const auto epoch =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch());
  std::int64_t first = 0;
  for (LogEvent event; log.next(event);) {
    if (first == 0) first = event.utime;
    const auto due = start + std::chrono::microseconds(event.utime - first);
    while (Clock::now() < due) listener.listenOnce(1);
    const std::int64_t shift = epoch.count() - first;
    const auto send = [&](auto message) {
      message.utime += shift;
      listener.lcm().publish(event.channel, &message);
    };
    if (event.channel == channel::kScan) send(*decodeChecked<scan_t>(event.data));
    if (event.channel == channel::kWheels) send(*decodeChecked<wheels_t>(event.data));
    if (event.channel == channel::kImu) send(*decodeChecked<imu_t>(event.data));
  }
  const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->state, 1) << daemonLog();
  EXPECT_GT(pose->match_quality, 0.7);
  ASSERT_TRUE(listener.until(
      [&] {
        const auto health = listener.last<health_t>(channel::kHealth);
        if (!health) return false;
        for (const counter_t& counter : health->counters) {
          if (counter.name == "lcm.bad_messages" && counter.value >= 50) return true;
        }
        return false;
      },
      5s));
}

TEST_F(Live, ObeysCommandsOnlyWhereTheConfigurationAllows) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("60");
  command_t command{};
  command.id = 7;
  command.verb = "set_pose";
  command.pose[0] = 3.0;
  const auto ask = [&](std::chrono::milliseconds limit) {
    const std::int32_t first = command.id + 1;
    return listener.until(
        [&] {
          ++command.id;
          listener.lcm().publish(channel::kCommand, &command);
          const auto ack = listener.last<ack_t>(channel::kAck);
          return ack && ack->id >= first;
        },
        limit);
  };
  startDaemon({});
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kPose) > 0; }, 15s)) << daemonLog();
  EXPECT_FALSE(ask(1s));
  slamd_->signal(SIGTERM);
  ASSERT_EQ(slamd_->wait(2s), 0);

  startDaemon({"lcm.commands=true"});
  listener.forget();
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kPose) > 0; }, 15s)) << daemonLog();
  ASSERT_TRUE(ask(5s)) << daemonLog();
  EXPECT_TRUE(listener.last<ack_t>(channel::kAck)->accepted);
  EXPECT_TRUE(listener.until(
      [&] {
        const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
        return pose && std::abs(pose->x - 3.0) < 0.6;
      },
      5s));
  command.verb = "make_coffee";
  ASSERT_TRUE(ask(5s));
  EXPECT_FALSE(listener.last<ack_t>(channel::kAck)->accepted);
  EXPECT_THAT(listener.last<ack_t>(channel::kAck)->message, testing::HasSubstr("unknown verb"));
}

TEST_F(Live, OutlivesAnyDatagram) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startDaemon({"lcm.commands=true", "lidar.driver='lcm'", "base.driver='lcm'", "imu.driver='lcm'"});
  ASSERT_TRUE(listener.until([&] { return listener.count(channel::kHealth) > 0; }, 10s)) << daemonLog();

  const int sender = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_in group = parseUdpmUrl(kUrl).group;
  const auto send = [&](const std::vector<std::uint8_t>& datagram) {
    sendto(sender, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&group), sizeof group);
  };
  std::mt19937 random(1);
  for (const char* name : {channel::kCommand, channel::kScan, channel::kWheels, channel::kImu}) {
    send(test::deadlyFragment(name));
    for (std::uint32_t number : {0U, 1U, 255U, 256U, 65535U}) {  // a message of two parts, in every disorder
      for (std::uint32_t offset : {0U, 900U, 1000U, 0x7FFFFFFFU, 0xFFFFFF9CU, 0xFFFFFFF0U}) {
        for (std::uint32_t size : {0U, 1000U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
          send(test::fragmentOf({size, offset, number, 2}, name, 100));
        }
      }
    }
    for (int i = 0; i < 200; ++i) {  // the magic of either kind, and anything behind it
      std::vector<std::uint8_t> datagram(random() % 300);
      for (std::uint8_t& byte : datagram) byte = static_cast<std::uint8_t>(random());
      const std::string magic = i % 2 == 0 ? "LC02" : "LC03";
      std::copy_n(magic.begin(), std::min(magic.size(), datagram.size()), datagram.begin());
      send(datagram);
      send(test::packetOf(name, datagram));
    }
  }
  close(sender);

  command_t command{};
  command.verb = "make_coffee";
  const bool answered = listener.until(
      [&] {
        ++command.id;
        listener.lcm().publish(channel::kCommand, &command);
        return listener.count(channel::kAck) > 0;
      },
      5s);
  EXPECT_TRUE(answered) << daemonLog();
  const auto counted = [&] {
    const auto health = listener.last<health_t>(channel::kHealth);
    return std::any_of(health->counters.begin(), health->counters.end(), [](const counter_t& counter) {
      return counter.name == "lcm.fragments" && counter.value >= 100;
    });
  };
  EXPECT_TRUE(listener.until(counted, 5s)) << daemonLog();
  EXPECT_THAT(daemonLog(), testing::HasSubstr("is larger than a datagram and is not read"));
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
}

/// A slamd that keeps its maps, and slamctl beside it.
class LiveMaps : public Live {
 protected:
  void SetUp() override {
    Live::SetUp();
    fs::create_directories(maps());
  }
  fs::path maps() const { return folder_ / "maps"; }
  void startKeeper(std::vector<std::string> settings = {}) {
    settings.insert(settings.end(),
                    {"lcm.commands=true", "store.directory='" + maps().string() + "'", "store.journal_period=0.2"});
    startDaemon(std::move(settings));
  }
  /// After its predecessor's end. @return whether it is heard
  bool restartKeeper(Listener& listener, std::vector<std::string> settings = {}) {
    listener.listenFor(200ms);  // what the one before has sent
    listener.forget();
    startKeeper(std::move(settings));
    return listener.until([&] { return listener.count(channel::kHealth) > 0; }, 10s);
  }
  int slamctl(const std::vector<std::string>& words) {
    std::vector<std::string> command = {kBin + "/slamctl", "--config", kConfig, "--maps", maps()};
    command.insert(command.end(), words.begin(), words.end());
    Process process(command, folder_ / "slamctl.txt");
    return process.wait(25s).value_or(-1);
  }
  std::string said() const {
    std::ifstream in(folder_ / "slamctl.txt");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static bool isLocalised(Listener& listener) {
    const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
    return pose && pose->state == 1;
  }
};

TEST_F(LiveMaps, ObeySlamctl) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("60");
  startKeeper();
  ASSERT_TRUE(listener.until([&] { return isLocalised(listener) && counterOf(listener, "keyframes") > 1; }, 20s))
      << daemonLog();
  EXPECT_EQ(slamctl({"status"}), 0) << said();
  EXPECT_THAT(said(), testing::AllOf(testing::HasSubstr("STREAMING"), testing::HasSubstr("keyframes")));
  EXPECT_EQ(slamctl({"save"}), 0) << said();
  EXPECT_EQ(slamctl({"save", "kitchen"}), 0) << said();
  EXPECT_THAT(said(), testing::HasSubstr("saved as kitchen"));
  EXPECT_EQ(slamctl({"save", "../kitchen"}), 1);
  EXPECT_EQ(slamctl({"list"}), 0);
  EXPECT_THAT(said(), testing::AllOf(testing::HasSubstr("kitchen "), testing::HasSubstr("2 maps in")));
  EXPECT_EQ(slamctl({"export", "kitchen", folder_ / "picture"}), 0) << said();
  EXPECT_EQ(slamctl({"load", "nowhere"}), 1);
  EXPECT_THAT(said(), testing::HasSubstr("nowhere"));
  EXPECT_TRUE(isLocalised(listener));

  EXPECT_EQ(slamctl({"load", "kitchen"}), 0) << said();
  listener.forget();
  EXPECT_TRUE(listener.until([&] { return isLocalised(listener) && counterOf(listener, "relocalised") > 0; }, 30s))
      << daemonLog();
  const auto pose = listener.last<pose_estimate_t>(channel::kSlamPose);
  EXPECT_EQ(slamctl({"set-pose", std::to_string(pose->x), std::to_string(pose->y), "0"}), 0) << said();
  EXPECT_EQ(slamctl({"mode", "drive"}), 2) << said();
  EXPECT_EQ(slamctl({"mode", "localise"}), 0) << said();
  EXPECT_EQ(slamctl({"mode", "slam"}), 0) << said();
  EXPECT_EQ(slamctl({"reset"}), 0) << said();
  EXPECT_EQ(slamctl({"list"}), 0);
  EXPECT_THAT(said(), testing::HasSubstr("kitchen "));
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  EXPECT_EQ(slamctl({"status"}), 1) << "nobody is there";
}

TEST_F(LiveMaps, ObeyOverTheSocketWithoutARoute) {
  ASSERT_TRUE(test::shell("ip route del 224.0.0.0/4"));
  const std::string socket = folder_ / "socket", setting = "runtime.socket='" + socket + "'";
  const auto answers = [&](std::vector<std::string> words, std::chrono::milliseconds limit = 0s) {
    words.insert(words.end(), {"--set", setting});
    const auto end = Clock::now() + limit;
    while (true) {
      if (slamctl(words) == 0) return true;
      if (Clock::now() > end) return false;
    }
  };
  EXPECT_FALSE(answers({"status"}));
  EXPECT_THAT(said(), testing::AllOf(testing::HasSubstr("there is no " + socket + ": slamd does not run"),
                                     testing::HasSubstr("no multicast route")));
  startSimulator("60");
  startKeeper({setting, "lcm.commands=false"});
  ASSERT_TRUE(answers({"status"}, 10s)) << said() << daemonLog();
  EXPECT_THAT(said(), testing::AllOf(testing::HasSubstr("lidar"), testing::HasSubstr("LCM: no multicast route")));
  ASSERT_TRUE(answers({"save", "kitchen"}, 20s)) << said() << daemonLog();  // it waits for a first keyframe
  EXPECT_THAT(said(), testing::HasSubstr("saved as kitchen"));
  EXPECT_TRUE(answers({"set-pose", "1", "2", "0"})) << said();
  EXPECT_EQ(slamctl({"save"}), 1) << "not over LCM";

  Process second({kBin + "/slamd", "--config", kConfig, "--set", setting, "--set", "depth.driver='none'"},
                 folder_ / "second.txt");
  const auto end = Clock::now() + kPatience * 10s;
  while (textOf(folder_ / "second.txt").find("another program listens there") == std::string::npos &&
         Clock::now() < end)
    usleep(20000);
  EXPECT_THAT(textOf(folder_ / "second.txt"), testing::HasSubstr(socket + ": another program listens there"));
  second.signal(SIGTERM);
  second.wait(10s);
  EXPECT_TRUE(answers({"status"})) << "the first one's socket is still there: " << said();

  slamd_->signal(SIGKILL);
  ASSERT_EQ(slamd_->wait(5s), 128 + SIGKILL);
  EXPECT_FALSE(answers({"status"}));
  EXPECT_THAT(said(), testing::HasSubstr("nobody listens on " + socket + ": slamd has ended"));
  startKeeper({setting});
  EXPECT_TRUE(answers({"status"}, 10s)) << said() << daemonLog();
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  EXPECT_FALSE(fs::exists(socket));
  EXPECT_TRUE(test::shell("ip route add 224.0.0.0/4 dev lo"));
}

TEST_F(LiveMaps, OutliveAKill) {
  Listener listener;
  ASSERT_TRUE(listener.good());
  startSimulator("100", "meeting-room");  // where a robot soon sees new things
  startKeeper();
  ASSERT_TRUE(listener.until([&] { return isLocalised(listener) && counterOf(listener, "keyframes") > 4; }, 40s))
      << daemonLog();
  const std::int64_t keyframes = counterOf(listener, "keyframes");
  const auto map_id = [&] { return listener.last<pose_estimate_t>(channel::kSlamPose)->map_id; };
  const std::int32_t first_map_id = map_id();
  slamd_->signal(SIGKILL);
  ASSERT_EQ(slamd_->wait(5s), 128 + SIGKILL);
  EXPECT_EQ(slamctl({"list"}), 0);
  EXPECT_THAT(said(), testing::AllOf(testing::HasSubstr("good"), testing::HasSubstr("1 map in")));
  if (kCamera) {  // the only checkpoint is of the drive's first moment
    EXPECT_GT(MapStore::load(maps(), *MapStore::newest(maps()), {}).state.views.size(), 5U);
  }

  ASSERT_TRUE(restartKeeper(listener)) << daemonLog();
  const std::string log = daemonLog();
  const auto of = log.find(" of ", log.find("map /"));
  ASSERT_NE(of, std::string::npos) << log;
  EXPECT_GE(std::stoll(log.substr(of + 4)), keyframes - 1) << "all but what the journal did not hold yet";
  EXPECT_TRUE(listener.until([&] { return isLocalised(listener) && counterOf(listener, "relocalised") == 1; }, 30s))
      << daemonLog();
  EXPECT_NE(map_id(), first_map_id) << "a viewer would show the old run's tiles";
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();

  ASSERT_TRUE(restartKeeper(listener, {"mode='localise'"})) << daemonLog();
  EXPECT_EQ(slamctl({"save"}), 1);
  EXPECT_THAT(said(), testing::HasSubstr("mode is \"localise\""));
  EXPECT_EQ(slamctl({"reset"}), 1);
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
}

TEST_F(Live, GoesOnWithoutMulticastRoute) {
  Process away({"ip", "route", "del", "224.0.0.0/4"}, folder_ / "ip.txt");
  ASSERT_EQ(away.wait(5s), 0);
  startSimulator("60");
  startDaemon({"output.record='" + (folder_ / "record.lcm").string() + "'"});
  const auto end = Clock::now() + 15s;
  while (daemonLog().find("no multicast route") == std::string::npos && Clock::now() < end) usleep(50000);
  EXPECT_THAT(daemonLog(), testing::HasSubstr("ip route add 224.0.0.0/4 dev lo"));

  Process back({"ip", "route", "add", "224.0.0.0/4", "dev", "lo"}, folder_ / "ip.txt");  // and it heals
  ASSERT_EQ(back.wait(5s), 0);
  Listener listener;
  ASSERT_TRUE(listener.good());
  const auto drives = [&] { return listener.count(channel::kPose) > 100 && listener.count(channel::kScan) > 3; };
  EXPECT_TRUE(listener.until(drives, 15s)) << daemonLog();
  Process gone({"ip", "route", "del", "224.0.0.0/4"}, folder_ / "ip.txt");  // while it runs
  ASSERT_EQ(gone.wait(5s), 0);
  const auto falls_silent = [&] {
    const auto before = listener.count(channel::kPose);
    listener.until([] { return false; }, 500ms);
    return listener.count(channel::kPose) == before;
  };
  const auto later = Clock::now() + 10s;
  while (!falls_silent() && Clock::now() < later) {
  }
  EXPECT_LT(Clock::now(), later) << "it sends without a route";
  listener.until([] { return false; }, 2s);  // until health has told of it
  Process again({"ip", "route", "add", "224.0.0.0/4", "dev", "lo"}, folder_ / "ip.txt");
  ASSERT_EQ(again.wait(5s), 0);
  const auto heard = listener.count(channel::kPose);
  EXPECT_TRUE(listener.until([&] { return listener.count(channel::kPose) > heard + 100; }, 15s)) << daemonLog();
  slamd_->signal(SIGINT);
  EXPECT_EQ(slamd_->wait(2s), 0) << daemonLog();
  EXPECT_LT(daemonLog().size(), 5000U) << "liblcm must not fill the log";
  EventLogReader record(folder_ / "record.lcm");  // which needed no network
  std::map<std::string, int> counts;
  int losses = 0;
  bool lost = false;
  for (LogEvent event; record.next(event);) {
    ++counts[event.channel];
    health_t health{};
    const int size = static_cast<int>(event.data.size());
    if (event.channel != channel::kHealth || health.decode(event.data.data(), 0, size) != size) continue;
    const bool told = health.summary.find("no multicast route") != std::string::npos;
    losses += told && !std::exchange(lost, told) ? 1 : 0;
    lost = told;
  }
  EXPECT_GT(counts[channel::kSlamPose], 100);
  EXPECT_GT(counts[channel::kScan], 3);
  EXPECT_EQ(losses, 2) << "health tells of each, the log of a repetition a minute later";
}

/// What the network does to a slamd that drives.
class LiveNetwork : public Live {
 protected:
  /// Waits for words in the log. @param times how often they have to be there
  bool logs(const std::string& words, std::chrono::milliseconds limit, int times = 1) const {
    const auto end = Clock::now() + limit;
    while (Clock::now() < end) {
      const std::string log = daemonLog();
      int found = 0;
      for (auto at = log.find(words); at != std::string::npos; at = log.find(words, at + 1)) ++found;
      if (found >= times) return true;
      usleep(50000);
    }
    return false;
  }
  /// Asks slamd by slamctl until it answers. @param machine other than this one, if any
  bool answers(const std::string& url, const std::string& words, std::chrono::milliseconds limit,
               const test::OtherMachine* machine = nullptr) const {
    const std::string command = kBin + "/slamctl --config " + kConfig + " --url '" + url + "' " + words;
    const auto end = Clock::now() + limit;
    do {
      if (test::shell("timeout 2 " + (machine != nullptr ? machine->inside(command) : command))) return true;
    } while (Clock::now() < end);
    return false;
  }
};

TEST_F(LiveNetwork, GoesOnBehindAFirewall) {
  if (!test::Firewall::isThere()) GTEST_SKIP() << "without nftables";
  const std::string record = folder_ / "record.lcm";
  startSimulator("90");
  {
    const test::Firewall firewall("input");
    startDaemon({"lcm.commands=true", "output.record='" + record + "'"});
    EXPECT_TRUE(logs("LCM: sent packets do not come back; is udp 7667 blocked?", kPatience * 10s)) << daemonLog();
  }
  EXPECT_TRUE(logs("LCM messages are sent again", kPatience * 12s)) << daemonLog();
  EXPECT_TRUE(answers(kUrl, "set-pose 1 2 0", 10s)) << daemonLog();
  {
    const test::Firewall firewall("output");
    EXPECT_TRUE(logs("LCM: not permitted to send; does a firewall or the unit block udp 7667?", kPatience * 10s))
        << daemonLog();
  }
  EXPECT_TRUE(logs("LCM messages are sent again", kPatience * 12s, 2)) << daemonLog();
  EXPECT_TRUE(answers(kUrl, "set-pose 1 2 0", 10s)) << daemonLog();
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  EXPECT_TRUE(fs::exists(folder_ / "map.yaml"));

  EventLogReader log(record);
  std::int64_t last = 0, gap = 0;
  std::string said;
  for (LogEvent event; log.next(event);) {
    if (event.channel == channel::kHealth) said += decodeChecked<health_t>(event.data)->summary + "\n";
    if (event.channel != channel::kSlamPose) continue;
    if (last != 0) gap = std::max(gap, event.utime - last);
    last = event.utime;
  }
  EXPECT_LT(gap, 3'000'000) << "[us] without a pose: the watchdog of the unit would have ended it soon";
  EXPECT_THAT(said, testing::HasSubstr("; LCM: sent packets do not come back; is udp 7667 blocked?"));
  EXPECT_THAT(said, testing::HasSubstr("; LCM: not permitted to send"));
}

TEST_F(LiveNetwork, FollowsFromCableToWlan) {
  const std::string url = "udpm://239.255.76.67:7667?ttl=1";
  const test::OtherMachine other;
  other.plug("cable", 1);
  other.plug("wlan", 2);
  ASSERT_TRUE(test::shell("ip route del 224.0.0.0/4"));
  startDaemon({"lcm.commands=true", "lcm.url='" + url + "'"});
  EXPECT_TRUE(logs("no multicast route", 10s)) << daemonLog();
  EXPECT_THAT(daemonLog(), testing::Not(testing::HasSubstr("dev lo"))) << "nobody else would hear it there";

  other.route("cable");
  EXPECT_TRUE(answers(url, "set-pose 1 2 0", 12s, &other)) << daemonLog();
  for (int change = 0; change < 2; ++change) {
    ASSERT_TRUE(test::shell("ip link set cable down"));
    other.route("wlan");
    EXPECT_TRUE(answers(url, "set-pose 1 2 0", 8s, &other)) << "WLAN " << change << "\n" << daemonLog();
    ASSERT_TRUE(test::shell("ip link set cable up"));
    other.route("cable");
    EXPECT_TRUE(answers(url, "set-pose 1 2 0", 8s, &other)) << "cable " << change << "\n" << daemonLog();
  }
  ASSERT_TRUE(test::shell("ip link del cable"));  // an adapter that is pulled, and comes back by its name
  other.plug("cable", 1);
  other.route("cable");
  EXPECT_TRUE(answers(url, "set-pose 1 2 0", 8s, &other)) << daemonLog();
  slamd_->signal(SIGTERM);
  EXPECT_EQ(slamd_->wait(5s), 0) << daemonLog();
  EXPECT_TRUE(test::shell("ip route replace 224.0.0.0/4 dev lo"));
}

TEST_F(LiveNetwork, KeepsItsMessagesOnThisMachine) {
  const test::OtherMachine other;
  other.plug("cable", 1);
  other.plug("wlan", 2);
  other.route("cable");
  startDaemon({});
  for (const char* name : {"cable", "wlan"}) {  // whatever the route goes over
    other.route(name);
    EXPECT_TRUE(answers(kUrl, "status", 8s)) << daemonLog();
    EXPECT_FALSE(answers(kUrl, "status", 0s, &other)) << name;
  }
  EXPECT_TRUE(test::shell("ip route replace 224.0.0.0/4 dev lo"));
}

}  // namespace
}  // namespace slam::live_test
