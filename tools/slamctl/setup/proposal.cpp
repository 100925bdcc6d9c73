// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/proposal.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <ostream>
#include <stdexcept>

#include "drivers/base/base_facts.hpp"
#include "drivers/lidar/lidar_facts.hpp"

namespace slam {
namespace {

/// A kind of device, with the section of the configuration that it belongs to.
struct Role {
  const char* section;
  const char* name;
  PortFinding::Kind kind;
};
constexpr Role kLidar{"lidar", "lidar", PortFinding::kLidar}, kBase{"base", "base", PortFinding::kBase},
    kImu{"imu", "IMU", PortFinding::kImu};

constexpr const char* kAxes =
    "\n"
    "           x, forward            Place of the lidar, from the point about which the base\n"
    "             ^                   turns: the middle between the driven wheels.\n"
    "             |   .-.             x [m] ahead of it, y [m] to its left.\n"
    "             |  ( L )            yaw [rad] from forward to the lidar's own zero direction,\n"
    "   y         |   '-'             counter-clockwise: 1.5708 looks to the left, 3.14159 back.\n"
    "   <---[=]---+---[=]             Calibration makes them exact to a few mm afterwards.\n"
    "  left     turning centre\n\n";

std::vector<FoundPort> portsWith(const Machine& machine, const Role& role) {
  std::vector<FoundPort> ports;
  std::copy_if(machine.ports.begin(), machine.ports.end(), std::back_inserter(ports),
               [&](const FoundPort& port) { return port.finding.kind == role.kind; });
  return ports;
}

std::string unquoted(const std::string& value) {
  return value.size() >= 2 && value.front() == '"' ? value.substr(1, value.size() - 2) : value;
}

/// Of two models that send alike at one rate nobody can tell which it is: the configured one stays. So does a search.
bool isSameLidar(const std::string& configured, const std::string& found) {
  const LidarFacts *one = findLidar(configured), *other = findLidar(found);
  const bool alike = one != nullptr && other != nullptr && one->packets == other->packets && one->baud == other->baud &&
                     one->sample_rate == other->sample_rate;
  const bool family = (configured == "ydlidar" && found.starts_with("ydlidar")) ||
                      (configured == "lds" && (found == "lds02" || found == "xv11"));
  return alike || family || configured == found || configured == "auto";
}

class Proposal {
 public:
  Proposal(Interview& interview, Machine machine, const std::function<Machine()>& again)
      : interview_(interview), machine_(std::move(machine)), again_(again) {}

  void proposeLidar() {
    const auto port = choose(kLidar);
    if (!port)
      return askForDriver(kLidar, "No lidar was found. What sends the scans? A word of man slamd.toml, or none");
    const std::string driver = driverOf(kLidar), model = unquoted(interview_.valueOf("lidar.model"));
    const bool is_model = driver == "lds" && model != "auto";
    if (!isSameLidar(is_model ? model : driver, port->finding.driver)) {
      interview_.take("lidar.driver", port->finding.driver);
      if (is_model) interview_.take("lidar.model", "auto");
    }
    takePort(kLidar, *port);
  }

  void proposeBase() {
    const auto port = choose(kBase);
    const auto bus = std::find_if(machine_.buses.begin(), machine_.buses.end(), [](const FoundBus& found) {
      return found.nodes.size() >= 2 || found.vescs.size() >= 2;
    });
    if (port) {
      interview_.take("base.driver", port->finding.driver);
      takePort(kBase, *port);
    } else if (bus != machine_.buses.end()) {
      proposeCan(*bus);
    } else {
      if (!interview_.isSet("base.driver")) interview_.takeDefault("base.driver", "none");
      askForDriver(kBase, "No base was found. What reads the wheels? A word of man slamd.toml, or none");
    }
    askForWheels();
  }

  void proposeImu() {
    const std::string base = driverOf(kBase);
    const auto port = choose(kImu);
    if (port) {
      interview_.take("imu.driver", port->finding.driver);
      takePort(kImu, *port);
      interview_.ask("imu.roll", "Rotation of the IMU about the forward axis [rad], 0: level, 3.14159: upside down");
    } else if (!machine_.chips.empty()) {
      interview_.take("imu.driver", "iio");
      if (!interview_.isSet("imu.port")) interview_.take("imu.port", machine_.chips.front());
    } else {
      const bool own = base == "handsfree" || base == "kobuki";
      const std::string now = driverOf(kImu);
      const bool of_a_base = now == "handsfree" || now == "base";
      if (own && (of_a_base || !interview_.isSet("imu.driver")))
        interview_.take("imu.driver", base == "kobuki" ? "base" : base);
      if (!own && of_a_base) interview_.take("imu.driver", "none");
    }
  }

  void askForMount() {
    if (interview_.config().lidar_device.driver == LidarDriver::kNone) return;
    const auto unset = [this](const char* key) { return !interview_.isSet(key); };
    const auto keys = {"lidar.x", "lidar.y", "lidar.yaw"};
    if (interview_.hasPerson() && std::any_of(keys.begin(), keys.end(), unset)) interview_.out() << kAxes;
    interview_.ask("lidar.x", "Lidar ahead of the turning centre [m]");
    interview_.ask("lidar.y", "Lidar left of the turning centre [m]");
    interview_.ask("lidar.yaw", "Lidar's zero direction, counter-clockwise from forward [rad]");
    interview_.ask("lidar.upside_down", "Does the lidar hang top down? true or false");
  }

  void proposeCamera() {
    if (!machine_.camera) {
      // One that the file asks for is unplugged perhaps: doctor names it.
      if (!interview_.isSet("depth.driver")) interview_.take("depth.driver", "none");
      return;
    }
    interview_.take("depth.driver", "openni2");
    interview_.ask("depth.x", "Camera ahead of the turning centre [m]");
    interview_.ask("depth.z", "Camera above the floor [m]; 0: its images are not used");
    interview_.ask("depth.pitch", "Angle by which the camera looks down [rad]");
  }

 private:
  std::string driverOf(const Role& role) const {
    return unquoted(interview_.valueOf(std::string(role.section) + ".driver"));
  }

  /// The device of that kind that the configuration has, or the only one, or the one that a person chooses.
  std::optional<FoundPort> choose(const Role& role) {
    const std::string key = std::string(role.section) + ".port", wanted = unquoted(interview_.valueOf(key));
    for (;;) {
      const std::vector<FoundPort> ports = portsWith(machine_, role);
      for (const FoundPort& port : ports) {
        if (interview_.isSet(key) && isSamePort(port.path, wanted)) return port;
      }
      if (ports.empty() || interview_.isAnswered(key)) return std::nullopt;
      if (ports.size() == 1) return ports.front();
      if (const auto chosen = chooseOf(ports, role, key)) return chosen;
      machine_ = again_();
    }
  }

  /// @return std::nullopt: one was unplugged, or the answer was none
  std::optional<FoundPort> chooseOf(const std::vector<FoundPort>& ports, const Role& role, const std::string& key) {
    std::vector<std::string> list;
    std::string names;
    for (const FoundPort& port : ports) {
      names += (names.empty() ? "" : ", ") + port.path + " (" + port.finding.name + ")";
      list.push_back(port.path + ", " + port.finding.name);
    }
    const std::string question = std::to_string(ports.size()) + " devices could be the " + role.name;
    if (!interview_.hasPerson())
      throw std::runtime_error(question + "; set " + key + " in the answers to one of: " + names);
    const std::size_t at = interview_.choose(key, question, list);
    if (!interview_.hasPerson()) return chooseOf(ports, role, key);
    return at < ports.size() ? std::optional(ports[at]) : std::nullopt;
  }

  void takePort(const Role& role, const FoundPort& port) {
    const std::string section = role.section, key = section + ".port";
    if (!isSamePort(unquoted(interview_.valueOf(key)), port.path)) interview_.take(key, port.path);
    const bool has_rate = port.finding.baud > 0;
    const int baud = !has_rate || port.finding.is_usual_baud ? 0 : port.finding.baud;
    const std::string now = interview_.valueOf(section + ".baud");
    // A rate that was set, and is the right one, stays.
    if (now != std::to_string(baud) && now != std::to_string(port.finding.baud))
      interview_.take(section + ".baud", std::to_string(baud));
  }

  void askForDriver(const Role& role, const char* question) {
    const std::string section = role.section, driver = section + ".driver";
    interview_.ask(driver, question);
    const std::string word = driverOf(role);
    const bool has_port = word != "none" && word != "lcm" && word != "can";
    if (has_port) interview_.ask(section + ".port", std::string("Port of the ") + role.name);
  }

  void proposeCan(const FoundBus& bus) {
    interview_.take("base.driver", "can");
    interview_.take("can.interface", bus.interface);
    const bool vesc = bus.nodes.size() < 2;
    const std::vector<int>& nodes = vesc ? bus.vescs : bus.nodes;
    const std::string protocol = vesc ? "vesc" : "odrive";
    if (unquoted(interview_.valueOf("can.protocol")) != protocol) interview_.take("can.protocol", protocol);
    if (vesc) interview_.ask("can.pole_pairs", "Pairs of poles of a motor: half the magnets of its rotor");
    const auto isOnBus = [&](int node) { return std::binary_search(nodes.begin(), nodes.end(), node); };
    const CanConfig& can = interview_.config().can;
    if (isOnBus(can.left_node) && isOnBus(can.right_node)) return;
    interview_.takeDefault("can.left_node", std::to_string(nodes[0]));
    interview_.takeDefault("can.right_node", std::to_string(nodes[1]));
    interview_.ask("can.left_node", vesc ? "Id of the left wheel's VESC" : "Node of the left wheel's ODrive");
    interview_.ask("can.right_node", vesc ? "Id of the right wheel's VESC" : "Node of the right wheel's ODrive");
  }

  void askForWheels() {
    const std::string driver = driverOf(kBase);
    if (driver == "none") return;
    const BaseFacts* facts = findBase(driver);
    if (facts != nullptr && facts->wheel_radius > 0.0) {
      if (!interview_.isSet("base.wheel_radius"))
        interview_.take("base.wheel_radius", std::to_string(facts->wheel_radius));
      if (!interview_.isSet("base.half_track")) interview_.take("base.half_track", std::to_string(facts->half_track));
    }
    if (interview_.config().base_device.needsCounts())
      interview_.ask("base.counts_per_turn",
                     driver == "vesc" ? "Counts of a tachometer in one turn of a wheel: 6 x pole pairs x gear"
                                      : "Counts of the encoder in one turn of a wheel");
    if (driver == "vesc") {
      interview_.ask("can.left_node", "Id of the left wheel's VESC on CAN");
      interview_.ask("can.right_node", "Id of the right wheel's VESC on CAN");
    }
    if (driver == "handsfree")
      interview_.ask("base.type", "Wheels: differential, omni3 (three omni wheels) or mecanum4");
    interview_.ask("base.wheel_radius", "Radius of a driven wheel [m]");
    interview_.ask("base.half_track", "Half the distance between the driven wheels [m]");
  }

  Interview& interview_;
  Machine machine_;
  const std::function<Machine()>& again_;
};

}  // namespace

void proposeDevices(Interview& interview, Machine machine, const std::function<Machine()>& again) {
  Proposal proposal(interview, std::move(machine), again);
  proposal.proposeLidar();
  proposal.proposeBase();
  proposal.proposeImu();
  proposal.askForMount();
  proposal.proposeCamera();
}

}  // namespace slam
