// SPDX-License-Identifier: BSD-3-Clause
// make_corpus DIR: writes what devices, sensors and slamd itself would write, for mutations to begin with, into
// DIR/<target>. The emulators and encoders of the repository speak; nothing is recorded.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "bus/packets.hpp"
#include "config/printer.hpp"
#include "drivers/base/base_facts.hpp"
#include "drivers/lidar/codec/cola_codec.hpp"
#include "drivers/lidar/codec/rplidar_capsules.hpp"
#include "mapping/map_files.hpp"
#include "store/durable_file.hpp"
#include "store/edit_codec.hpp"
#include "store/map_codec.hpp"
#include "store/map_journal.hpp"
#include "store/map_manifest.hpp"
#include "support/stored_map.hpp"
#include "tools/bag_bytes.hpp"
#include "tools/sim/base/emulated_base.hpp"
#include "tools/sim/board/board_emulator.hpp"
#include "tools/sim/board/imu_emulator.hpp"
#include "tools/sim/can/can_emulator.hpp"
#include "tools/sim/imu/emulated_imu.hpp"
#include "tools/sim/lidar/cola_emulator.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"
#include "tools/web/foxglove/client_frames.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using namespace std::string_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr Timestamp kStart{1000s};
constexpr std::int64_t kUtime = 1'700'000'000'000'000;  // [us]

class Corpus {
 public:
  explicit Corpus(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void add(const std::string& target, const std::string& seed, const std::string& content) const {
    std::filesystem::create_directories(folder_ / target);
    std::ofstream file(folder_ / target / seed, std::ios::binary);
    file << content;
    if (!file.flush()) throw std::runtime_error((folder_ / target / seed).string() + ": cannot write");
  }
  /// @param choice first byte, by which targets choose what the rest is
  void add(const std::string& target, const std::string& seed, int choice, const std::string& content) const {
    add(target, seed, static_cast<char>(choice) + content);
  }
  std::filesystem::path scratch(const std::string& name) const {
    std::filesystem::create_directories(folder_);
    return folder_ / name;
  }

 private:
  std::filesystem::path folder_;
};

std::string contentOf(const std::filesystem::path& file) { return readFile(file, std::filesystem::file_size(file)); }

std::string textOf(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

/// A room 3 m by 4 m, around its middle.
double room(Timestamp, double bearing) {
  return std::min(1.5 / std::max(1e-3, std::abs(std::cos(bearing))), 2.0 / std::max(1e-3, std::abs(std::sin(bearing))));
}

Bytes lidarBytes(sim::LidarEmulator& lidar, const Bytes& request, Duration duration) {
  Bytes out;
  lidar.receive(request, kStart, out);
  if (duration > 0ns) out.clear();  // the descriptor is read before the stream
  for (Duration t{0}; t <= duration; t += 2ms) lidar.stream(kStart + t, out);
  return out;
}

void lidarSeeds(const Corpus& corpus) {
  using rplidar::Request;
  constexpr int kKinds = 5, kAnswers = 2 * kKinds;
  struct Mode {
    const char* name;
    Bytes request;
    int choice;
  };
  const Mode modes[] = {{"standard", rplidar::encodeRequest(Request::kScan), 0},
                        {"express", rplidar::encodeExpressScan(0), 1},
                        {"ultra", rplidar::encodeExpressScan(2), 2}};
  for (const Mode& mode : modes) {
    sim::LidarEmulator lidar(room, 5.5, sim::a1Firmware124());
    const std::string stream = textOf(lidarBytes(lidar, mode.request, 100ms));
    corpus.add("rplidar", mode.name, mode.choice, stream);
    std::string chunks;
    for (std::size_t at = 0; at < stream.size(); at += 64) {
      const std::string chunk = stream.substr(at, 64);
      chunks += static_cast<char>(chunk.size()) + chunk;
    }
    corpus.add("rplidar", std::string(mode.name) + "-chunks", mode.choice + kKinds, chunks);
  }
  Bytes dense;
  for (std::uint16_t i = 0; i < 8; ++i) {
    rplidar::DenseCapsule capsule{.start_angle_q6 = static_cast<std::uint16_t>(700 * i)};
    for (std::size_t k = 0; k < capsule.distances_mm.size(); ++k)
      capsule.distances_mm[k] = static_cast<std::uint16_t>(900 + k);
    const auto bytes = rplidar::encodeDenseCapsule(capsule);
    dense.insert(dense.end(), bytes.begin(), bytes.end());
  }
  corpus.add("rplidar", "dense", 3, textOf(dense));
  sim::LidarEmulator s3(room, 10.0, sim::s3WithUltraDense());
  Bytes motor_answer;
  s3.receive(rplidar::encodeMotorSpeed(600), kStart, motor_answer);
  corpus.add("rplidar", "ultra-dense", 4, textOf(lidarBytes(s3, rplidar::encodeExpressScan(1), 520ms)));
  for (const Request request : {Request::kGetInfo, Request::kGetHealth, Request::kGetSampleRate}) {
    sim::LidarEmulator lidar(room, 5.5);
    const std::string answer = textOf(lidarBytes(lidar, rplidar::encodeRequest(request), 0ms));
    const std::string name = "answer-" + std::to_string(static_cast<int>(request));
    corpus.add("rplidar", name + "-descriptor", kAnswers, answer.substr(0, rplidar::kDescriptorSize));
    corpus.add("rplidar", name, kAnswers, answer.substr(std::min(answer.size(), rplidar::kDescriptorSize)));
  }
}

void packetLidarSeeds(const Corpus& corpus) {
  int choice = 0;
  for (const LidarFacts& facts : lidarTable()) {
    sim::PacketEmulator lidar(room, facts.driver);
    Bytes bytes, answers;
    lidar.receive(Bytes{0xA5, 0x60, 0xF0, 0x0F, 'b'}, Timestamp{1s}, answers);  // the commands that begin a scan
    for (Timestamp now{1s}; now < Timestamp{1100ms}; now += 1ms) lidar.stream(now, bytes);
    corpus.add("lidar", facts.driver, choice++, textOf(bytes));
  }
}

/// Half a second of what each base sends while it is asked.
void baseSeeds(const Corpus& corpus) {
  int choice = 0;
  for (const BaseFacts& facts : baseTable()) {
    const auto base = sim::makeBase(facts.driver);
    const auto protocol = facts.make(
        {.wheel_radius = 0.03, .half_track = 0.1, .counts_per_turn = 1000.0, .loop_rate = 30.0, .may_drive = true});
    sim::RobotModel robot({}, 1);
    Bytes bytes;
    Timestamp now{1s};
    protocol->begin(now);
    for (; now < Timestamp{1500ms}; now += 5ms) {
      robot.step({.vx = 0.3, .omega = 0.5}, 5e-3);
      base->renew(robot, now);
      const std::size_t before = bytes.size();
      base->exchange(protocol->question(now).bytes(), now, bytes);
      for (std::size_t i = before; i < bytes.size(); ++i) protocol->push(bytes[i], now, [](const BaseReading&) {});
    }
    corpus.add("base", facts.driver, choice++, textOf(bytes));
  }
}

/// What a lidar with a protocol of text sends for its commands, then scans.
void textLidarSeeds(const Corpus& corpus, const char* name, int choice, sim::EmulatedLidar& lidar,
                    const std::string& commands, Duration time) {
  Bytes bytes;
  lidar.receive(Bytes(commands.begin(), commands.end()), kStart, bytes);
  for (Timestamp now = kStart; now < kStart + time; now += 1ms) lidar.stream(now, bytes);
  corpus.add("lidar_text", name, choice, textOf(bytes));
}

void textLidarsSeeds(const Corpus& corpus) {
  const sim::ScipModel& model = sim::scipModels()[0];
  sim::ScipEmulator scans(room, model), answers(room, model);
  textLidarSeeds(corpus, "scip-scans", 0, scans, "MD0044072501000\n", 250ms);
  textLidarSeeds(corpus, "scip-answers", 1, answers, "VV\nPP\nII\nBM\n", 0ms);
  sim::ColaEmulator cola_scans(room, sim::colaModels()[1]), cola_answers(room, sim::colaModels()[1]);
  textLidarSeeds(corpus, "cola-scans", 2, cola_scans, cola::telegram("sEN LMDscandata 1"), 50ms);
  textLidarSeeds(corpus, "cola-answers", 3, cola_answers, cola::telegram("sRN DeviceIdent"), 0ms);
  corpus.add("lidar_text", "cola-scan", 3,
             "sRA LMDscandata 1 1 89A27F 0 0 343 347 27477BA9 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 3F800000 00000000 "
             "186A0 1388 3 8A1 8A5 8AB 0 0 0 0 0 0");
}

void boardSeeds(const Corpus& corpus) {
  sim::BoardEmulator board;
  Bytes bytes;
  const auto ask = [&](robolink::Command command, std::span<const std::uint8_t> payload = {}) {
    std::array<std::uint8_t, robolink::kMaxFrame> frame;
    const std::size_t size = robolink::encodeFrame(robolink::kMaster, robolink::kSlave, command, payload, frame);
    board.receive({frame.data(), size}, bytes);
    corpus.add("handsfree", "answer-" + std::to_string(static_cast<int>(command)), textOf(bytes));
  };
  board.renew(1.5, 2.5, {.online = 1, .gyro = {0.1F, 0.2F, 0.3F}, .accel = {0.0F, 0.0F, 9.8F}}, 3.0);
  board.receive({}, bytes);
  ask(robolink::Command::kShakingHands, robolink::encodeCoordinate({}));
  for (const auto command : {robolink::Command::kGetMotorMileage, robolink::Command::kGetImu,
                             robolink::Command::kGetSystemInfo, robolink::Command::kReadChassisParameters}) {
    bytes.clear();
    ask(command);
  }
  corpus.add("handsfree", "system-info", textOf([] {
               const auto payload = robolink::encodeSystemInfo({.battery = 12.5F});
               return Bytes(payload.begin(), payload.end());
             }()));
}

void imuSeeds(const Corpus& corpus) {
  for (const auto framing : {sim::ImuEmulator::Framing::kA9, sim::ImuEmulator::Framing::kB6}) {
    sim::ImuEmulator imu(framing);
    Bytes bytes;
    for (int i = 0; i < 3; ++i) imu.sample({0.01 * i, 0.02, 0.5}, {0.1, 0.0, 9.81}, bytes);
    corpus.add("imu", framing == sim::ImuEmulator::Framing::kA9 ? "a9" : "b6", textOf(bytes));
  }
  for (const std::string& name : sim::imuNames()) {
    const auto imu = sim::makeImu(name);
    Bytes bytes;
    for (int i = 0; i < 80; ++i) imu->sample({0.01 * i, 0.02, 0.5}, {0.1, 0.0, 9.81}, bytes);
    corpus.add("imu", name, textOf(bytes));
  }
}

void canSeeds(const Corpus& corpus) {
  sim::CanEmulator emulator;
  std::vector<can::Frame> frames;
  Bytes bytes;
  for (int ms = 0; ms < 200; ms += 5) {
    frames.clear();
    emulator.step(kStart + std::chrono::milliseconds(ms), {.angles = {0.01 * ms, 0.02 * ms}, .accel = {0, 0, 9.8F}},
                  frames);
    for (const can::Frame& frame : frames) {
      const std::uint32_t id = frame.id | 0x80000000U;  // as it is
      const std::array<std::uint8_t, 7> head = {static_cast<std::uint8_t>(5),
                                                static_cast<std::uint8_t>(0x80),  // 5 ms after the one before
                                                static_cast<std::uint8_t>(id),
                                                static_cast<std::uint8_t>(id >> 8),
                                                static_cast<std::uint8_t>(id >> 16),
                                                static_cast<std::uint8_t>(id >> 24),
                                                frame.size};
      bytes.insert(bytes.end(), head.begin(), head.end());
      bytes.insert(bytes.end(), frame.data.begin(), frame.data.end());
    }
  }
  corpus.add("can", "drive", textOf(bytes));
  for (std::size_t at = 0; at < 12; ++at)
    corpus.add("can", "frame-" + std::to_string(at), textOf(bytes).substr(15 * at, 15));
}

LaserScan someScan() {
  LaserScan scan;
  for (int i = 0; i < 5; ++i) scan.push({1.0F + static_cast<float>(i), 0.1F * static_cast<float>(i), 0.0F, 10.0F});
  return scan;
}

PseudoLaser somePseudoLaser() {
  PseudoLaser laser;
  laser.bearing_min = -0.5F;
  laser.bearing_step = 0.01F;
  laser.size = 3;
  laser.storage[0] = {PseudoBeam::Kind::kHit, 2.0F, 0.5F};
  laser.storage[1] = {PseudoBeam::Kind::kFree, 3.0F, 0.5F};
  laser.push({1, 1.5F, 2.5F});
  return laser;
}

/// Messages of the page, in the order of their numbers in fuzz_web_state.
const std::array<std::string, 6> kShown = {"pose", "health", "scan", "depth", "map_meta", "map_tile"};

void messageSeeds(const Corpus& corpus) {
  const std::array<double, 2> angles = {1.0, 2.0};
  drive_t drive{};
  drive.utime = kUtime;
  drive.vx = 0.3;
  command_t command{};
  command.utime = kUtime;
  command.verb = "set_pose";
  ack_t ack{};
  ack.message = "saved";
  health_t health{};
  health.summary = "pose localised";
  health.ndevices = health.nstages = health.ncounters = 1;
  health.devices.resize(1);
  health.stages.resize(1);
  health.counters.resize(1);
  problems_t problems{};
  problems.nproblems = 1;
  problems.problems.resize(1);
  problems.problems[0].device = "lidar";
  problems.problems[0].id = "port_gone";
  problems.problems[0].nnumbers = 4;
  problems.problems[0].numbers.resize(4);
  problems.problems[0].ntexts = 1;
  problems.problems[0].texts = {"minicom"};
  config_t config{};
  config.host = "robot";
  config.configuration = "[log]\n";
  const std::vector<std::pair<const char*, Bytes>> messages = {
      {"scan", test::encoded(toMessage(someScan(), kUtime))},
      {"wheels", test::encoded(toMessage(WheelSample{.T_wheels_base = {1.0, 2.0, 0.5}}, kUtime, angles))},
      {"imu", test::encoded(toMessage(ImuSample{}, kUtime))},
      {"depth", test::encoded(toMessage(somePseudoLaser(), kUtime))},
      {"drive", test::encoded(drive)},
      {"command", test::encoded(command)},
      {"ack", test::encoded(ack)},
      {"health", test::encoded(health)},
      {"pose", test::encoded(toMessage(PoseEstimate{}, kUtime, 1))},
      {"map_meta", test::encoded(toMetaMessage(OccupancyGrid{}, kUtime, 1, 0))},
      {"map_tile", test::encoded(toTileMessage(OccupancyGrid{}, {1, -2}, kUtime, 1))},
      {"config", test::encoded(config)},
      {"problems", test::encoded(problems)}};
  const char* const channels[] = {channel::kScan,     channel::kWheels,  channel::kImu,     channel::kDepth,
                                  channel::kDrive,    channel::kCommand, channel::kAck,     channel::kHealth,
                                  channel::kSlamPose, channel::kMapMeta, channel::kMapTile, channel::kConfig,
                                  channel::kProblems};
  EventLogWriter log(corpus.scratch("log"));
  std::string shown;  // a page's first half second
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const auto& [name, bytes] = messages[i];
    corpus.add("lcm_decode", name, static_cast<int>(i), textOf(bytes).substr(8));  // without fingerprint
    corpus.add("lcm_packet", name, textOf(test::packetOf(channels[i], bytes)));
    corpus.add("lcm_packet", std::string(name) + "-fragment", textOf(test::deadlyFragment(channels[i])));
    log.write(kUtime + static_cast<std::int64_t>(i), name, bytes);
    const auto place = std::find(kShown.begin(), kShown.end(), std::string(name));
    if (place == kShown.end()) continue;
    const std::string body = textOf(bytes).substr(8);
    shown += {static_cast<char>(place - kShown.begin()), static_cast<char>(body.size() & 0xFF),
              static_cast<char>(body.size() >> 8)};
    shown += body;
  }
  corpus.add("web_state", "page", shown);
  log.flush();
  corpus.add("event_log", "log", contentOf(corpus.scratch("log")));
  std::filesystem::remove(corpus.scratch("log"));
}

void webSeeds(const Corpus& corpus) {
  const std::string host = " HTTP/1.1\r\nHost: localhost\r\n";
  for (const auto& [name, target] : {std::pair("page", "/"),
                                     {"map", "/api/map?since=12"},
                                     {"events", "/api/events"},
                                     {"status", "/api/status"},
                                     {"maps", "/api/v1/maps"},
                                     {"pgm", "/map.pgm"},
                                     {"log", "/logs/run/0001.lcm.gz"},
                                     {"encoded", "/%2e%2e/a+b?x=%00&since=1"}}) {
    corpus.add("web_request", name, std::string("GET ") + target + host + "\r\n");
  }
  const std::string command =
      "POST /api/command" + host + "Content-Type: application/json\r\nAuthorization: Bearer x\r\n";
  corpus.add("web_request", "command", command + "Content-Length: 15\r\n\r\n{\"verb\":\"save\"}");
  const std::string speed = R"({"vx":0.3,"omega":-0.1,"hold":7})";
  corpus.add("web_request", "drive",
             "POST /api/v1/drive" + host +
                 "Content-Type: application/json\r\nAuthorization: Bearer secret-of-the-robot\r\nContent-Length: " +
                 std::to_string(speed.size()) + "\r\n\r\n" + speed);
  corpus.add("web_request", "chunked", command + "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n");
  corpus.add("web_request", "range", "HEAD /page.js" + host + "Range: bytes=0-10,-5\r\nExpect: 100-continue\r\n\r\n");
}

void foxgloveSeeds(const Corpus& corpus) {
  const std::string subscribe = R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":0},{"id":2,"channelId":6}]})";
  const std::string unsubscribe = R"({"op":"unsubscribe","subscriptionIds":[1,2]})";
  corpus.add("foxglove", "text", "T" + subscribe);
  corpus.add("foxglove", "frames",
             test::clientFrame(test::kText, subscribe) + test::clientFrame(test::kPing, "p") +
                 test::clientFrame(test::kText, unsubscribe.substr(0, 20), false) +
                 test::clientFrame(test::kContinuation, unsubscribe.substr(20)) +
                 test::clientFrame(test::kClose, "\x03\xE8"));
  std::string wrong;
  for (int i = 0; i < 20; ++i) wrong += test::clientFrame(test::kText, "?");
  corpus.add("foxglove", "wrong", wrong);
}

void textSeeds(const Corpus& corpus, const std::filesystem::path& source) {
  corpus.add("config", "defaults", printConfig(Config{}));
  for (const auto& entry : std::filesystem::directory_iterator(source / "config")) {
    if (entry.path().extension() == ".toml" && entry.file_size() < 4096) {
      corpus.add("config", entry.path().filename().string(), contentOf(entry.path()));
    }
  }
  corpus.add("config", "texts", "[lidar]\nport = '/dev/a\\b\"c'\n[output]\nmap = \"\\u0001\\\\x\\u00e9\"\n");
  corpus.add("config", "settings", "[lidar]\nrange_max = 8.0\n\0lidar.x=0.1\0imu.driver='lcm'"s);
  corpus.add("carmen", "intel",
             "PARAM robot_front_laser_max 81.9\n# a comment\nODOM 1.5 -2 0.5 0.1 0 0 976052857.1 h 0.2\n"
             "FLASER 4 1.2 0.5 81.83 3 1 2 0.1 1.1 2.1 0.2 976052857.3 h 0.4\n");
  corpus.add("carmen", "damaged", "FLASER 2 nan 1 0 0 0 0 0 0 1 h 1\r\nFLASER 1 1\nFLASER x\nODOM a\n");
}

/// A second of a drive in each kind of bag.
void bagSeeds(const Corpus& corpus) {
  for (const bool cdr : {false, true}) {
    const std::string msg = cdr ? "/msg/" : "/";
    const std::vector<test::BagTopic> topics = {{"/scan", "sensor_msgs" + msg + "LaserScan", test::kScanDefinition},
                                                {"/odom", "nav_msgs" + msg + "Odometry"},
                                                {"/imu", "sensor_msgs" + msg + "Imu"},
                                                {"/tf", "tf2_msgs" + msg + "TFMessage"},
                                                {"/joints", "sensor_msgs" + msg + "JointState"}};
    std::vector<test::BagMessage> messages = {{3, kUtime, test::tfBytes(cdr, kUtime, "base_link", "laser", 0.1, 0, 1)}};
    for (int i = 0; i < 4; ++i) {
      const std::int64_t us = kUtime + 100'000 * i;
      messages.push_back({0, us, test::scanBytes(cdr, us, {1.0F, 2.0F, 3.0F})});
      messages.push_back({1, us, test::odometryBytes(cdr, us, 0.1 * i, 0.0)});
      messages.push_back({2, us, test::imuBytes(cdr, us, 0.1)});
      messages.push_back({4, us, test::jointBytes(cdr, us, 0.1 * i, 0.2 * i)});
    }
    if (!cdr) {
      corpus.add("ros", "bag", test::rosBag(topics, messages));
      for (const char* packing : {"none", "bz2", "lz4"}) {
        corpus.add("ros", std::string("bag-") + packing, test::rosBag(topics, messages, 5, packing));
      }
      continue;
    }
    corpus.add("ros", "mcap", test::mcapFile(topics, messages));
    for (const char* packing : {"", "lz4", "zstd"}) {
      corpus.add("ros", std::string("mcap-chunks-") + packing, test::mcapFile(topics, messages, 5, packing));
    }
    const auto file = corpus.scratch("db3");
    test::writeDb3(file, topics, messages, true);
    corpus.add("ros", "db3", contentOf(file));
    std::filesystem::remove(file);
  }
  std::string log;
  const std::string lidar("\x89\xdc\x5b\x87\x9a\x50\x56\xcf\0\0\0\0\0\x4c\x4b\x40\0\0\0\1\x40\0\0\0\0\0\0\0"s +
                          "\0\0\0\0\0\x4c\x4b\x40\0\0\0\0"s);
  appendRecord(log, 0, kUtime, "LIDAR", {reinterpret_cast<const std::uint8_t*>(lidar.data()), lidar.size()});
  corpus.add("mbot", "log", log);
  corpus.add("mbot", "payloads", "\0\x20"s + lidar.substr(8) + "\0\0\0\0\0\0\x06\0"s);
  corpus.add("courses", "mines",
             "\0"
             "1000000 1 10 20 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1500*\n"
             "9e18 1 1e308 1e308 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1e308*\n"
             "1100000 1 15 25 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1490*\n"s);
  corpus.add("courses", "wean", "\1O 1 2 0.5 10.5\nL 1 2 0.5 1 2 0.5 150* 10.6\nL 1.5 2 0.5 1 2 0.5 140* 10.8\n");
  corpus.add("courses", "map", "\2robot_specifications->resolution 10\nglobal_map[0]: 2 2\n0.1 0.9\n-1 0.5\n");
  corpus.add("csv", "header", "t,x,y,theta,r0,r1,r2\n1,0,0,0,1.5,inf,2.5\n1.1,0.1,0,0,1.5,nan,2.5\n");
  corpus.add("csv", "bearings", "time_ms;-90;0;90\n100;1;2;3.5\n200;1;2;3.5\n");
  corpus.add("csv", "words", "1.0,100,8191,25026,300\n1.1,100,200,25026,300\n");
  corpus.add("csv", "angles", "angle_min,angle_max,r0,r1\n-1,1,2,2.5\n-1,1,,2.25\n");
}

/// The numbers that map_store_fuzz makes tiles of.
std::string someTiles() {
  BinaryWriter tiles;
  for (int i = -1; i < 2; ++i) {
    tiles.put(static_cast<std::int32_t>(i));
    tiles.put(static_cast<std::int32_t>(2 * i));
    tiles.put(static_cast<LogOdds>(100 * i));
  }
  return tiles.take();
}

void mapSeeds(const Corpus& corpus) {
  test::ChangingMap changing(5);
  const MapState& map = changing.map;
  const std::string keyframes = encodeKeyframes(map), edges = encodeEdges(map), grid = encodeGrid(map.grid);
  corpus.add("map_store", "keyframes", 0, keyframes);
  corpus.add("map_store", "edges", 1, edges);
  BinaryWriter poses, resolution;
  encodePoses(poses, map.keyframes.graph().poses());
  corpus.add("map_store", "poses", 2, poses.take());
  resolution.put(0.1);
  corpus.add("map_store", "grid", 3, resolution.take() + someTiles());
  corpus.add("map_store", "grid-raw", 4, grid);
  MapState seen = changing.copy();
  seen.views = {test::viewFrom(1, {})};
  const std::string depth = encodeDepth(seen);
  BinaryWriter no_views;
  no_views.put(std::uint16_t{8});
  no_views.put(std::uint64_t{0});
  corpus.add("map_store", "depth", 5, no_views.take() + someTiles());
  corpus.add("map_store", "depth-raw", 6, depth);
  corpus.add("map_store", "state", 7, encodeState(map));

  const std::filesystem::path file = corpus.scratch("journal");
  {
    MapJournal journal(file, map);
    changing.addKeyframe(true);
    journal.append(map, seen.views);
    changing.closeLoop(0, 4);
    changing.move();
    changing.touch();
    journal.append(map);
  }
  const std::string content = contentOf(file);
  std::filesystem::remove(file);
  corpus.add("map_store", "journal-raw", 9, content);
  constexpr std::size_t kRecordHead = 12;  // magic, size, CRC: map_store_fuzz writes them itself
  for (std::size_t at = 0, i = 0; at + kRecordHead <= content.size(); ++i) {
    std::uint32_t size = 0;
    std::memcpy(&size, content.data() + at + 4, 4);
    corpus.add("map_store", "journal-" + std::to_string(i), 8,
               std::string(1, '\0') + content.substr(at + kRecordHead, size));
    at += kRecordHead + size;
  }
  const std::string manifest = encodeManifest({.utime = 1, .keyframes = 5, .files = {{"graph.bin", {82, 7}}}});
  corpus.add("map_store", "manifest", 10, manifest.substr(0, manifest.rfind("crc32 ")));
  corpus.add("map_store", "manifest-raw", 11, manifest);
  for (const EditKind kind : {EditKind::kErase, EditKind::kFree, EditKind::kRoom})
    test::edit(seen, test::squareEdit(kind, 1.0, 0.5));
  corpus.add("map_store", "edits", 12, encodeEdits(seen));
}

void floorPlanSeeds(const Corpus& corpus) {
  const test::ChangingMap changing(5);
  const MapImage image = renderMap(changing.map.grid);
  const auto add = [&](const char* seed, const std::string& yaml, const std::string& pgm) {
    BinaryWriter out;
    out.put(static_cast<std::uint16_t>(yaml.size()));
    out.putBytes(yaml);
    out.putBytes(pgm);
    corpus.add("map_files", seed, out.take());
  };
  add("ours", encodeYaml("map.pgm", image), encodePgm(image));
  add("map_saver",
      "resolution: 0.05 # [m]\norigin: [-1, \"-2\", 0.0]\nnegate: false\noccupied_thresh: 0.65\nfree_thresh: 0.25\n",
      "P5\n# CREATOR: map_saver\n3 2\n255\n\x01\xFE\xCD\xCD\xFE\x01"s);
  add("nav2", "mode: scale\nresolution: 0.05\norigin:\n- -1.5\n- 2\n- 0.3\nnegate: 1\nby: &a [{b: *a}, ? c]\n",
      encodePng(colourMap(image)));
  add("text", "mode: raw\nresolution: 1e-1\norigin: [0, 0, 1.57]\n",
      "P2 # of a person\n3 2\n100\n0 100 50\n#\n1 0 99\n");
}

void evalSeeds(const Corpus& corpus) {
  const std::string trajectory = "# t x y z\n1.0 0 0 0 0 0 0 1\n2.5 1 0.5 0 0 0 0.1 0.99\n-9.1e9 2 1 0 0 0 0.5 0.5\n";
  const std::string estimates =
      "t,state,x,y,theta,sxx,sxy,syy,sxt,syt,stt\n1.0,localised,0,0,0,1e-4,0,1e-4,0,0,1e-5\n"
      "1e300,lost,1,0,nan,1e-4,0,1e-4,0,0,1e-5\n";
  const auto add = [&](const char* seed, int comparison, const std::string& first, const std::string& second) {
    BinaryWriter out;
    out.put(static_cast<std::uint16_t>(first.size()));
    out.putBytes(first);
    out.putBytes(second);
    corpus.add("eval", seed, comparison, out.take());
  };
  add("trajectories", 0, trajectory, trajectory);
  add("relations", 1, trajectory, "1.0 2.5 1 0.5 0 0 0 0.2\n1e300 2.5 1 0 0 0 0 0.1\n");
  add("estimates", 2, estimates, trajectory);
}

void simulationSeeds(const Corpus& corpus) {
  corpus.add("sim", "script", 0,
             "# a drive\n0.1 lidar lose 3\n0.2 lidar turn 100\n2 can slow 3 # later\n1 imu wrong 2\n");
  BinaryWriter faults;
  for (std::uint8_t i = 0; i < 12; ++i) {
    faults.put(std::uint16_t{i});
    faults.put(static_cast<std::uint8_t>(i % 5));  // the device
    faults.put(static_cast<std::uint8_t>(3 * i));  // the kind
    faults.put(0.5 * i);
  }
  corpus.add("sim", "faults", 1, faults.take());
  corpus.add(
      "sim", "situation", 2,
      "casing=150,210,0.2\nposts=4,3,0.3\nfloor-line=2\nfollower=swaying\nwalkers=3\nrange-noise=0.02\nbeams=720\n"
      "field-of-view=270\nno-return=0.05,12\nsecond-lidar=5\nwheels-away=10,20\nkidnapped=30,covered\nlaps=2\n");
}

/// Drives, in the numbers of commands_fuzz.
void commandSeeds(const Corpus& corpus) {
  const std::string scan = "\0\4\5"s, save = "\6\0"s, load = "\7\0"s, reset = "\10\0"s, mode = "\11\0"s;
  const auto numbers = [](int command, const std::string& head, double a, double b, double c) {
    BinaryWriter out;
    out.put(static_cast<std::uint8_t>(command));
    out.putBytes(head);
    for (const double number : {a, b, c}) out.put(number);
    return out.take();
  };
  const std::string now(5, '\0'), sender_now(6, '\0');  // [s or ms] of the stamp, behind the sender
  const auto pose = [&](double x, double y) { return scan + numbers(1, "", x, y, 1.0); };
  corpus.add("commands", "drive",
             scan + numbers(2, now, 0, 0, 0) + numbers(4, sender_now, 0.3, 0, 0.1) + numbers(2, now, 0.02, 0, 0) +
                 numbers(3, now, 0, 0, 0.1) + scan + save + "\5" + scan);
  corpus.add("commands", "poses", pose(3, -2) + pose(9000, -9000) + pose(1e6, 0) + scan + "\5");
  corpus.add("commands", "maps",
             scan + scan + save + reset + scan + load + scan + mode + scan + mode + "\12\1\0"s + scan);
  corpus.add("commands", "absurd",
             scan + numbers(2, now, 1e300, 0, 0) + numbers(3, now, 0, 0, 1e9) +
                 numbers(4, sender_now, 1e300, 0, -1e300) + pose(1e155, 0) + pose(1e16, -1e308));
}

}  // namespace
}  // namespace slam

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_corpus DIR\n", stderr);
    return 2;
  }
  try {
    const slam::Corpus corpus(argv[1]);
    slam::baseSeeds(corpus);
    slam::lidarSeeds(corpus);
    slam::packetLidarSeeds(corpus);
    slam::textLidarsSeeds(corpus);
    slam::boardSeeds(corpus);
    slam::imuSeeds(corpus);
    slam::canSeeds(corpus);
    slam::messageSeeds(corpus);
    slam::webSeeds(corpus);
    slam::foxgloveSeeds(corpus);
    slam::textSeeds(corpus, SLAMD_SOURCE_DIR);
    slam::mapSeeds(corpus);
    slam::floorPlanSeeds(corpus);
    slam::bagSeeds(corpus);
    slam::evalSeeds(corpus);
    slam::simulationSeeds(corpus);
    slam::commandSeeds(corpus);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_corpus: %s\n", error.what());
    return 1;
  }
}
