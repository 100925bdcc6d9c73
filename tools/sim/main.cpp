// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <array>
#include <iostream>

#include "tools/common/output_file.hpp"
#include "tools/common/program.hpp"
#include "tools/sim/base/emulated_base.hpp"
#include "tools/sim/can/can_emulator.hpp"
#include "tools/sim/device_mode.hpp"
#include "tools/sim/imu/emulated_imu.hpp"
#include "tools/sim/lidar/packet_encoders.hpp"
#include "tools/sim/log_mode.hpp"

namespace {

void addDeviceOptions(CLI::App& app, CLI::Option* devices_option, slam::sim::SimOptions& options, std::string& can,
                      std::array<int, 2>& nodes) {
  app.add_option("--faults", options.faults,
                 "with --devices: a script of SECONDS DEVICE KIND [VALUE], e.g. 12.5 lidar unplug 1; while it plays,\n"
                 "lines of DEVICE KIND [VALUE] can be written to DIR/faults")
      ->needs(devices_option);
  app.add_option(
         "--lidar", options.lidar,
         "with --devices: the lidar to be played, as lidar.driver names it, or a model of RPLidar, Hokuyo or SICK")
      ->check(CLI::IsMember(slam::sim::lidarNames()))
      ->needs(devices_option)
      ->capture_default_str();
  app.add_option("--base", options.base, "with --devices: the base to be played at DIR/board, as base.driver names it")
      ->check(CLI::IsMember(slam::sim::baseNames()))
      ->needs(devices_option)
      ->capture_default_str();
  app.add_option("--imu", options.imu, "with --devices: the IMU to be played at DIR/imu, as imu.driver names it")
      ->check(CLI::IsMember(slam::sim::imuNames()))
      ->needs(devices_option)
      ->capture_default_str();
  app.add_flag("--obey", options.obey,
               "with --devices: the robot drives as its base is commanded, not along the scene's route; it stalls "
               "where something is in its way")
      ->needs(devices_option);
  app.add_option("--lidar-tcp", options.lidar_tcp,
                 "with --devices: play the lidar at tcp://127.0.0.1:PORT instead of DIR/lidar")
      ->check(slam::inRange(1, 65535))
      ->needs(devices_option);
  CLI::Option* can_option =
      app.add_option("--can", can, "with --devices: put wheels and IMU on this CAN interface too, e.g. vcan0")
          ->needs(devices_option);
  app.add_option("--can-nodes", nodes, "with --can: CANSimple nodes of the left and the right wheel, or the VESCs' ids")
      ->check(slam::inRange(0, 254))
      ->needs(can_option)
      ->capture_default_str();
  app.add_flag("--can-vesc", options.vesc, "with --can: two VESCs drive the wheels, not two ODrives")
      ->needs(can_option);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Simulated robot: a sensor log faster than real time, or its devices at byte level in real time",
               "slam-sim");
  slam::sim::SimOptions options;
  std::string log, devices, can;
  std::array<int, 2> nodes = slam::sim::CanEmulator::kNodes;
  const auto names = slam::sim::sceneNames();
  app.add_option("--scene", options.scene, "world and drive")->check(CLI::IsMember(names))->capture_default_str();
  app.add_option("--seed", options.seed, "of all that is left to chance")->capture_default_str();
  app.add_option("--speed", options.speed, "[m/s] instead of the scene's")->check(slam::inRange(0.05, 2.0));
  app.add_option("--seconds", options.seconds, "[s] of the drive at most")->check(slam::inRange(1.0, 1e6));
  std::vector<std::string> kinds;
  bool no_depth = false;
  CLI::Option* log_option = app.add_option("--log", log, "write an LCM event log");
  CLI::Option* devices_option =
      app.add_option("--devices", devices, "play DIR/lidar, DIR/board and DIR/depth in real time");
  app.add_flag("--no-depth", no_depth, "leave the depth camera out of the log: twice as fast")->needs(log_option);
  addDeviceOptions(app, devices_option, options, can, nodes);
  app.add_option("--with", kinds,
                 "with --log: a KIND=VALUE of situation; may be repeated. KIND and VALUE are of\n" +
                     slam::sim::situationKinds())
      ->needs(log_option);
  app.add_option("--truth", options.truth, "write true poses (TUM)");
  app.add_option("--waypoints", options.waypoints, "write true poses at the measured waypoints (TUM)");
  app.add_option("--truth-map", options.truth_map,
                 "write the true map from floor clearance to robot height, with this prefix");
  app.add_option("--truth-map-lidar", options.truth_map_lidar,
                 "write the true map at the lidar's height, with this prefix");
  return slam::runProgram(
      app, argc, argv, SLAMD_VERSION, "slam-sim --scene corridor-loop --seed 3 --log loop.lcm --truth loop.tum", [&] {
        if (log.empty() == devices.empty()) {
          std::cerr << "slam-sim: give either --log OUT.lcm or --devices DIR; see slam-sim --help\n";
          return static_cast<int>(slam::kBadUsage);
        }
        for (const std::string& kind : kinds) {
          try {
            slam::sim::addTo(options.situation, kind);
          } catch (const std::invalid_argument& error) {
            std::cerr << "slam-sim: --with: " << error.what() << '\n';
            return static_cast<int>(slam::kBadUsage);
          }
        }
        for (const auto& file : {std::filesystem::path(log), options.truth, options.waypoints})
          slam::prepareOutput(file);
        for (const auto& prefix : {options.truth_map, options.truth_map_lidar}) slam::prepareMapFiles(prefix);
        options.depth = !no_depth;
        log.empty() ? slam::sim::playDevices(options, devices, can, nodes) : slam::sim::writeLog(options, log);
        return static_cast<int>(slam::kDone);
      });
}
