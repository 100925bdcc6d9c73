// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/situation.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/scan.hpp"

namespace slam::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

using Numbers = std::vector<double>;

std::vector<std::string_view> parts(std::string_view value) {
  std::vector<std::string_view> found;
  for (std::size_t begin = 0; begin <= value.size();) {
    const std::size_t end = std::min(value.find(',', begin), value.size());
    found.push_back(value.substr(begin, end - begin));
    begin = end + 1;
  }
  return found;
}

/// Finite ones, separated by commas; empty where the value is anything else.
Numbers numbers(std::string_view value) {
  Numbers found;
  for (const std::string_view part : parts(value)) {
    double number = 0.0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error != std::errc() || end != part.data() + part.size() || !std::isfinite(number)) return {};
    found.push_back(number);
  }
  return found;
}

bool within(double value, double least, double most) { return value >= least && value <= most; }

bool setNumber(double& target, std::string_view value, double least, double most, double unit = 1.0) {
  const Numbers n = numbers(value);
  if (n.size() != 1 || !within(n[0], least, most)) return false;
  target = unit * n[0];
  return true;
}

bool setNumber(std::optional<double>& target, std::string_view value, double least, double most, double unit = 1.0) {
  double number = 0.0;
  if (!setNumber(number, value, least, most, unit)) return false;
  target = number;
  return true;
}

bool setCount(int& target, std::string_view value, int least, int most) {
  const Numbers n = numbers(value);
  if (n.size() != 1 || !within(n[0], least, most) || n[0] != std::floor(n[0])) return false;
  target = static_cast<int>(n[0]);
  return true;
}

/// @param word the only value
bool setFlag(bool& target, std::string_view value, std::string_view word, bool to = true) {
  if (value != word) return false;
  target = to;
  return true;
}

bool addCasing(Situation& s, std::string_view value) {
  const Numbers n = numbers(value);
  if (n.size() != 3 || !within(n[0], -360.0, 360.0) || !within(n[1] - n[0], 0.1, 360.0) || !within(n[2], 0.01, 10.0))
    return false;
  s.bodies.push_back({wrapAngle((n[0] + n[1]) / 2 * kDegree), (n[1] - n[0]) / 2 * kDegree, n[2]});
  return true;
}

bool addPosts(Situation& s, std::string_view value) {
  const Numbers n = numbers(value);
  if (n.size() != 3 || !within(n[0], 1.0, 36.0) || n[0] != std::floor(n[0]) || !within(n[1], 0.1, 360.0 / n[0]) ||
      !within(n[2], 0.01, 10.0))
    return false;
  for (int i = 0; i < static_cast<int>(n[0]); ++i) {
    s.bodies.push_back({wrapAngle((i + 0.5) * 2.0 * std::numbers::pi / n[0]), n[1] / 2 * kDegree, n[2]});
  }
  return true;
}

bool setFollower(Situation& s, std::string_view value) {
  if (value != "rigid" && value != "swaying") return false;
  s.follower = value == "rigid" ? Situation::Follower::kRigid : Situation::Follower::kSwaying;
  return true;
}

bool setNoReturn(Situation& s, std::string_view value) {
  if (value == "inf") {
    s.no_return = {{std::numeric_limits<float>::infinity()}};
  } else if (value == "nan") {
    s.no_return = {{std::numeric_limits<float>::quiet_NaN()}};
  } else if (value == "max") {
    s.no_return = {{0.0F}, true};
  } else if (value == "over") {
    s.no_return = {{1.0F}, true};
  } else {
    const Numbers n = numbers(value);
    if (n.empty()) return false;
    s.no_return = {std::vector<float>(n.begin(), n.end())};
  }
  return true;
}

bool setSpan(std::optional<TimeSpan>& span, std::string_view value) {
  const Numbers n = numbers(value);
  if (n.size() != 2 || !(n[0] >= 0.0) || !(n[1] > n[0])) return false;
  span = {n[0], n[1]};
  return true;
}

bool setKidnapping(Situation& s, std::string_view value) {
  const std::size_t comma = value.find(',');
  double time = 0.0;
  if (!setNumber(time, value.substr(0, comma), 1.0, 1e6)) return false;
  const bool covered = comma != std::string_view::npos;
  if (covered && value.substr(comma) != ",covered") return false;
  s.kidnapping = {time, covered};
  return true;
}

struct Kind {
  std::string_view name, form, meaning;
  bool (*set)(Situation&, std::string_view);
};

using S = Situation;
using V = std::string_view;
constexpr Kind kKinds[] = {
    {"casing", "FROM,TO,RANGE [deg, deg, m]", "the lidar sees the robot's casing there, counter-clockwise; repeatable",
     addCasing},
    {"posts", "N,WIDTH,RANGE [1, deg, m]", "the lidar sees N posts, evenly around, each WIDTH wide", addPosts},
    {"floor-line", "AHEAD [m]", "a lidar tilted down sees the floor on a line across, AHEAD of it",
     [](S& s, V v) { return setNumber(s.floor_line, v, 0.2, 50.0); }},
    {"cart", "towed", "a cart behind the robot", [](S& s, V v) { return setFlag(s.cart, v, "towed"); }},
    {"follower", "rigid | swaying", "legs of one who pushes the robot, 0.55 m behind it", setFollower},
    {"walkers", "N", "people who walk around the robot", [](S& s, V v) { return setCount(s.walkers, v, 0, 100); }},
    {"glass", "N", "pieces of wall of 1 to 2 m are windows", [](S& s, V v) { return setCount(s.glass, v, 0, 1000); }},
    {"mirrors", "N", "pieces of wall of 1 to 2 m are mirrors",
     [](S& s, V v) { return setCount(s.mirrors, v, 0, 1000); }},
    {"range-noise", "SIGMA [m]", "of a range near by",
     [](S& s, V v) { return setNumber(s.lidar.range_noise, v, 0, 10); }},
    {"range-noise-per-metre", "SIGMA [m/m]", "that a range's noise grows by",
     [](S& s, V v) { return setNumber(s.lidar.range_noise_per_metre, v, 0.0, 1.0); }},
    {"beams", "N", "of a scan", [](S& s, V v) { return setCount(s.beams, v, 2, LaserScan::kCapacity); }},
    {"field-of-view", "ANGLE [deg]", "of the lidar, about straight ahead",
     [](S& s, V v) { return setNumber(s.field_of_view, v, 1.0, 360.0, kDegree); }},
    {"range-max", "RANGE [m]", "reach of the lidar",
     [](S& s, V v) { return setNumber(s.lidar.range_max, v, 0.5, 200.0); }},
    {"claimed-range-max", "RANGE [m]", "in the scans, instead of the lidar's reach",
     [](S& s, V v) { return setNumber(s.claimed_range_max, v, 0.5, 200.0); }},
    {"turn-rate", "RATE [1/s]", "of the lidar", [](S& s, V v) { return setNumber(s.turn_rate, v, 0.5, 100.0); }},
    {"beam-times", "none", "all time offsets are 0", [](S& s, V v) { return setFlag(s.beam_times, v, "none", false); }},
    {"no-return", "inf | nan | max | over | RANGE,... [m]",
     "written where nothing comes back: the lidar's reach, 1 m over it, or one of the ranges, drawn", setNoReturn},
    {"range-bias", "BIAS [m]", "that each range is too long",
     [](S& s, V v) { return setNumber(s.range_bias, v, -1.0, 1.0); }},
    {"range-scale", "SHARE [1]", "by which each range is too long",
     [](S& s, V v) { return setNumber(s.range_scale, v, -0.5, 0.5); }},
    {"bearing-scale", "SHARE [1]", "by which beams lie further apart than their bearings",
     [](S& s, V v) { return setNumber(s.bearing_scale, v, -0.5, 0.5); }},
    {"lidar-turned", "ANGLE [deg]", "by which the mount is turned to the left, unknown",
     [](S& s, V v) { return setNumber(s.mount_error.theta, v, -180.0, 180.0, kDegree); }},
    {"lidar-ahead", "DISTANCE [m]", "by which the mount is further ahead, unknown",
     [](S& s, V v) { return setNumber(s.mount_error.x, v, -2.0, 2.0); }},
    {"second-lidar", "ANGLE [deg]", "scans are merged of two lidars, of which the rear one is turned by ANGLE unknown",
     [](S& s, V v) { return setNumber(s.second_lidar, v, -180.0, 180.0, kDegree); }},
    {"gyro-unit", "deg", "deg/s where rad/s is due", [](S& s, V v) { return setFlag(s.imu.degrees, v, "deg"); }},
    {"gyro-axis", "down", "the IMU hangs upside down", [](S& s, V v) { return setFlag(s.imu.down, v, "down"); }},
    {"gyro-clip", "RATE [rad/s]", "largest that is reported",
     [](S& s, V v) { return setNumber(s.imu.clip, v, 0.01, 100.0); }},
    {"gyro-offset", "RATE [rad/s]", "beyond the ordinary bias",
     [](S& s, V v) { return setNumber(s.imu.offset, v, -100.0, 100.0); }},
    {"gyro-step", "RATE [deg/s]", "of its values", [](S& s, V v) { return setNumber(s.imu.step, v, 0, 100, kDegree); }},
    {"wheels-away", "FROM,TO [s]", "the wheels report nothing then",
     [](S& s, V v) { return setSpan(s.wheels_away, v); }},
    {"wheels-dead", "FROM,TO [s]", "the wheels' counters stand then while the robot drives on",
     [](S& s, V v) { return setSpan(s.wheels_dead, v); }},
    {"start", "moving", "the log begins while the robot drives, and it never pauses",
     [](S& s, V v) { return setFlag(s.starts_moving, v, "moving"); }},
    {"kidnapped", "TIME [s] | TIME,covered",
     "the robot is carried to another place of its route, within 3 s, with its lidar open or covered", setKidnapping},
    {"furniture-moved", "N", "furniture of a home stands 0.5 to 1 m from where it stood; another N, elsewhere",
     [](S& s, V v) { return setCount(s.scene.furniture_moved, v, 0, 1000000); }},
    {"floor", "N", "of a home: the same walls, other furniture",
     [](S& s, V v) { return setCount(s.scene.floor, v, 0, 1000); }},
    {"lift", "N", "of a home: a lift takes the robot to floor N; 0: the robot looks into it, and it stays open",
     [](S& s, V v) { return setCount(s.scene.lift.emplace(), v, 0, 1000); }},
    {"blocks", "N", "of the scene streets, along each of its sides",
     [](S& s, V v) { return setCount(s.scene.blocks, v, 1, 40); }},
    {"laps", "N", "of the route, where it ends at its start",
     [](S& s, V v) { return setCount(s.scene.laps, v, 1, 10000); }},
};

}  // namespace

std::string situationKinds() {
  std::string lines;
  for (const Kind& kind : kKinds) {
    lines += std::string(kind.name) + "=" + std::string(kind.form) + ": " + std::string(kind.meaning) + "\n";
  }
  lines.pop_back();
  return lines;
}

void addTo(Situation& situation, std::string_view kind_and_value) {
  const std::size_t equals = std::min(kind_and_value.find('='), kind_and_value.size());
  const std::string_view name = kind_and_value.substr(0, equals);
  for (const Kind& kind : kKinds) {
    if (kind.name != name) continue;
    if (equals < kind_and_value.size() && kind.set(situation, kind_and_value.substr(equals + 1))) return;
    throw std::invalid_argument(std::string(kind_and_value) + " is not " + std::string(name) + "=" +
                                std::string(kind.form) + ": " + std::string(kind.meaning));
  }
  throw std::invalid_argument("'" + std::string(name) + "' is not known; see slam-sim --help");
}

}  // namespace slam::sim
