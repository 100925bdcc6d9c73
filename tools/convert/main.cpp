// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <functional>
#include <iostream>
#include <map>
#include <numbers>
#include <stdexcept>

#include "mapping/map_files.hpp"
#include "tools/common/output_file.hpp"
#include "tools/common/program.hpp"
#include "tools/convert/formats.hpp"

namespace {

namespace fs = std::filesystem;

/// What a conversion reads and writes.
struct Files {
  std::string in, out, config;
};

/// The output, and the configuration that goes with it.
void addOutput(CLI::App* command, Files& files) {
  command->add_option("OUT", files.out, "LCM log to write")->required();
  command->add_option("--config", files.config, "also write slamd's configuration for the log (TOML)");
}

void addInput(CLI::App* command, Files& files) {
  command->add_option("IN", files.in, "input, plain or .gz")->required();
}

void addFiles(CLI::App* command, Files& files) {
  addInput(command, files);
  addOutput(command, files);
}

/// Of a conversion from our log, which has no configuration.
void addPair(CLI::App* command, Files& files, const char* out = "output") {
  addInput(command, files);
  command->add_option("OUT", files.out, out)->required();
}

/// Writes the configuration, prints what was found, and refuses what was not understood.
void finish(const slam::Recording& recording, const CLI::App& command, const Files& files) {
  if (!files.config.empty()) {
    const std::string from = files.in.empty() ? "" : " from " + fs::path(files.in).filename().string();
    slam::writeConfig(recording, "Written by slam-convert " + command.get_name() + from, files.config);
  }
  std::cout << slam::reportText(recording, files.out, true);
  if (const std::string doubt = recording.doubt(); !doubt.empty()) throw std::runtime_error(doubt);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Converts recorded data of other systems to an LCM event log that slam-replay reads, and back",
               "slam-convert");
  app.require_subcommand(1);
  Files files;
  std::map<const CLI::App*, std::function<slam::Recording()>> conversions;  // to our log
  const auto add = [&](const char* name, const char* what, const std::function<slam::Recording()>& convert) {
    CLI::App* command = app.add_subcommand(name, what);
    conversions.emplace(command, convert);
    return command;
  };
  CLI::App* any = add("auto", "whatever it is: recognised by its content, with a report of what was found",
                      [&] { return slam::convertAny(files.in, files.out); });
  addFiles(any, files);
  slam::CarmenOptions carmen;
  CLI::App* carmen_command = add("carmen", "CARMEN log (FLASER, ROBOTLASER1 and ODOM lines) to LCM log",
                                 [&] { return slam::convertCarmen(files.in, files.out, carmen); });
  carmen_command
      ->add_option("--period", carmen.period, "[s] between scans, where neither its stamps nor the logger's are times")
      ->check(slam::inRange(1e-3, 10.0));
  addFiles(carmen_command, files);
  slam::RosOptions ros;
  CLI::App* ros_command = add("ros", "bag of ROS 1 (.bag) or ROS 2 (.db3, .mcap, a folder of split ones) to LCM log",
                              [&] { return slam::convertRos(files.in, files.out, ros); });
  ros_command->add_option("--scan", ros.scan, "topic of the lidar, where there are several");
  ros_command->add_option("--odometry", ros.odometry, "topic of nav_msgs/Odometry that stands for the wheels");
  ros_command->add_option("--imu", ros.imu, "topic of the IMU");
  ros_command
      ->add_option("--wheel-radius", ros.wheel_radius,
                   "[m] with --half-track: makes odometry of the wheels' angles in sensor_msgs/JointState")
      ->check(slam::inRange(0.005, 1.0));
  ros_command->add_option("--half-track", ros.half_track, "[m] half the distance between the wheels")
      ->check(slam::inRange(0.01, 2.0));
  addFiles(ros_command, files);
  addFiles(add("lcm", "LCM log with slamd's channels: its sensors alone",
               [&] { return slam::convertLcm(files.in, files.out); }),
           files);
  CLI::App* to_carmen = app.add_subcommand("to-carmen", "our LCM log to CARMEN");
  addPair(to_carmen, files);
  std::string trajectory;
  CLI::App* to_mcap = app.add_subcommand("to-mcap", "our LCM log to MCAP, for Foxglove");
  to_mcap->add_option("--trajectory", trajectory, "poses of the robot in place of the log's own (TUM, of slam-replay)");
  addPair(to_mcap, files);
  addFiles(
      add("mines", "Mines ParisTech rover .dat to LCM log", [&] { return slam::convertMines(files.in, files.out); }),
      files);
  addFiles(
      add("wean", "CMU Wean Hall robotdata .log to LCM log", [&] { return slam::convertWean(files.in, files.out); }),
      files);
  slam::MbotTruth truth;
  slam::MbotBase mbot_base;
  CLI::App* mbot = add("mbot", "LCM log of a Maebot or MBot to ours",
                       [&] { return slam::convertMbot(files.in, files.out, truth, mbot_base); });
  mbot->add_option("--truth", truth.file, "also write the poses that the log holds (TUM)");
  mbot->add_option("--truth-channel", truth.channel, "where they are: the course's own SLAM, or TRUE_POSE")
      ->capture_default_str();
  mbot->add_option("--metres-per-tick", mbot_base.metres_per_tick,
                   "[m] of the encoders: 2.09e-4 in 2014-15, 8.2e-5 in 2016, 1.540e-4 from 2017 on, unless given")
      ->check(slam::inRange(1e-7, 0.1));
  mbot->add_option("--base-width", mbot_base.width, "[m] between the wheels: 0.083 to 2016, 0.210 then, unless given")
      ->check(slam::inRange(0.02, 4.0));
  mbot->add_option("--wheel-radius", mbot_base.wheel_radius, "[m] by which the log's angles are made of ticks")
      ->check(slam::inRange(0.005, 1.0));
  addFiles(mbot, files);
  slam::CsvInput csv;
  bool imu_z_down = false;
  CLI::App* csv_command = add("csv", "tables of scans, speed, encoders and IMU to LCM log", [&] {
    csv.imu_sign_z = imu_z_down ? -1.0 : 1.0;
    return slam::convertCsv(csv, files.out);
  });
  csv_command->add_option(
      "--scans", csv.scans,
      "ranges, in metres or raw SICK words; columns by a header (t, r0.., or bearings, x, y, theta, "
      "angle_min..) or the options below");
  csv_command->add_option("--unit", csv.unit, "of the ranges, where the data does not show it")
      ->check(CLI::IsMember({"m", "cm", "mm", "words"}));
  csv_command->add_option("--stamp-column", csv.stamp_column, "of the scans: name, or number from 1");
  csv_command->add_option("--first-range", csv.first_range, "column of the first range: name, or number from 1");
  csv_command
      ->add_option("--fov", csv.field_of_view, "[deg] from first to last beam, ahead in its middle; below 0: clockwise")
      ->check(slam::inRange(-360.0, 360.0));
  csv_command->add_option("--first-bearing", csv.first_bearing, "[deg] of the first beam, counter-clockwise from ahead")
      ->check(slam::inRange(-360.0, 360.0));
  csv_command->add_option("--period", csv.period, "[s] from scan to scan, where there are no stamps")
      ->check(slam::inRange(1e-3, 10.0));
  csv_command->add_option("--speed", csv.speed, "t_s,v_m_s");
  csv_command->add_option("--imu", csv.imu, "t_s,ax_g,ay_g,az_g,wx_rad_s,wy_rad_s,wz_rad_s");
  csv_command->add_flag("--imu-z-down", imu_z_down, "the IMU's z axis points down: turn its sign");
  csv_command->add_option("--encoders", csv.encoders, "stamp_s and ticks per interval of four wheels");
  csv_command->add_option("--metres-per-tick", csv.metres_per_tick, "of the encoders")->capture_default_str();
  csv_command->add_option("--wheel-radius", csv.wheel_radius, "[m] of the encoders' wheels")->capture_default_str();
  csv_command->add_option("--half-track", csv.half_track, "[m] half the effective track")->capture_default_str();
  addOutput(csv_command, files);

  slam::Disturbance disturbance;
  CLI::App* disturb =
      app.add_subcommand("disturb", "our log with sensors that lie, lag or are mounted wrong, to see what it does");
  disturb->add_option("--jumps", disturbance.wheels.jumps, "sudden false motions at random times")
      ->check(CLI::Range(0, 100000));
  disturb->add_option("--jump-translation", disturbance.wheels.jump_translation, "[m] at most")
      ->check(slam::inRange(0.0, 100.0))
      ->capture_default_str();
  disturb->add_option("--jump-rotation", disturbance.wheels.jump_rotation, "[rad] at most")
      ->check(slam::inRange(0.0, std::numbers::pi))
      ->capture_default_str();
  disturb->add_option("--noise", disturbance.wheels.noise, "[m per sqrt(m), rad per sqrt(m) and per sqrt(rad)]")
      ->check(slam::inRange(0.0, 10.0));
  disturb->add_option("--distance-scale", disturbance.wheels.distance_scale, "[1] error of the wheels' radius")
      ->check(slam::inRange(-0.9, 10.0));
  disturb->add_flag("--reverse-sign", disturbance.wheels.reverse_sign, "driving backwards is reported as forwards");
  disturb
      ->add_option("--wheel-lag", disturbance.wheels.lag,
                   "[s] a wheel sample says where they stood so long before its stamp")
      ->check(slam::inRange(0.0, 10.0));
  disturb->add_flag("--wheels-swapped", disturbance.wheels.swapped, "left and right: they turn the wrong way");
  disturb->add_flag("--wheels-backwards", disturbance.wheels.backwards, "both count backwards");
  disturb->add_flag("--gyro-reversed", disturbance.imu.down, "its z axis points down");
  disturb->add_flag("--lidar-upside-down", disturbance.lidar.upside_down, "its beams are mirrored");
  disturb->add_flag("--lidar-turned", disturbance.lidar.turned, "by 180 degrees");
  disturb->add_flag("--double-scans", disturbance.double_scans, "every scan is sent twice");
  disturb->add_flag("--time-backwards", disturbance.time_backwards,
                    "clocks are set back by 30 s in the middle, and every tenth scan by 0.3 s");
  disturb->add_option("--seed", disturbance.seed, "of times, jumps and noise")->capture_default_str();
  addPair(disturb, files);

  CLI::App* map = app.add_subcommand("wean-map", "the map that comes with Wean Hall's logs to OUT.yaml, .pgm and .png");
  addPair(map, files, "prefix of the map files");

  return slam::runProgram(
      app, argc, argv, SLAMD_VERSION, "slam-convert auto drive.bag drive.lcm --config drive.toml", [&] {
        map->parsed() ? slam::prepareMapFiles(files.out) : slam::prepareOutput(files.out);
        for (const fs::path& file : {fs::path(files.config), truth.file}) slam::prepareOutput(file);
        for (const auto& [command, convert] : conversions) {
          if (command->parsed()) finish(convert(), *command, files);
        }
        if (map->parsed()) slam::writeMapFiles(files.out, slam::readBeesoftMap(files.in), {});
        if (to_carmen->parsed()) std::cout << reportText(slam::convertToCarmen(files.in, files.out), files.out, false);
        if (to_mcap->parsed())
          std::cout << reportText(slam::convertToMcap(files.in, files.out, trajectory), files.out, true);
        if (disturb->parsed()) {
          std::cout << reportText(slam::disturbLog(files.in, files.out, disturbance), files.out, false);
        }
        return slam::kDone;
      });
}
