// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <functional>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <vector>

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

/// The subcommands that make a log of ours, each with what it does.
class Conversions {
 public:
  Conversions(CLI::App& app, Files& files) : app_(app), files_(files) {}

  CLI::App* add(const char* name, const char* what, const std::function<slam::Recording()>& convert) {
    CLI::App* command = app_.add_subcommand(name, what);
    all_.emplace_back(command, convert);
    return command;
  }
  void addWithFiles(const char* name, const char* what, slam::Recording (*convert)(const fs::path&, const fs::path&)) {
    addFiles(add(name, what, [this, convert] { return convert(files_.in, files_.out); }), files_);
  }
  void addCarmen();
  void addRos();
  void addMbot();
  void addCsv();
  const fs::path& truth() const { return truth_.file; }
  /// Runs the one that was asked for, if any.
  void run() const {
    for (const auto& [command, convert] : all_) {
      if (command->parsed()) finish(convert(), *command, files_);
    }
  }

 private:
  CLI::App& app_;
  Files& files_;
  std::vector<std::pair<const CLI::App*, std::function<slam::Recording()>>> all_;
  slam::CarmenOptions carmen_;
  slam::RosOptions ros_;
  slam::MbotTruth truth_;
  slam::MbotBase mbot_;
  slam::CsvInput csv_;
};

void Conversions::addCarmen() {
  CLI::App* command = add("carmen", "CARMEN log (FLASER, ROBOTLASER1 and ODOM lines) to LCM log",
                          [this] { return slam::convertCarmen(files_.in, files_.out, carmen_); });
  command
      ->add_option("--period", carmen_.period, "[s] between scans, where neither its stamps nor the logger's are times")
      ->check(slam::inRange(1e-3, 10.0));
  addFiles(command, files_);
}

void Conversions::addRos() {
  CLI::App* command = add("ros", "bag of ROS 1 (.bag) or ROS 2 (.db3, .mcap, a folder of split ones) to LCM log",
                          [this] { return slam::convertRos(files_.in, files_.out, ros_); });
  command->add_option("--scan", ros_.scan, "topic of the lidar, where there are several");
  command->add_option("--odometry", ros_.odometry, "topic of nav_msgs/Odometry that stands for the wheels");
  command->add_option("--imu", ros_.imu, "topic of the IMU");
  command
      ->add_option("--wheel-radius", ros_.wheel_radius,
                   "[m] with --half-track: makes odometry of the wheels' angles in sensor_msgs/JointState")
      ->check(slam::inRange(0.005, 1.0));
  command->add_option("--half-track", ros_.half_track, "[m] half the distance between the wheels")
      ->check(slam::inRange(0.01, 2.0));
  addFiles(command, files_);
}

void Conversions::addMbot() {
  CLI::App* command = add("mbot", "LCM log of a Maebot or MBot to ours",
                          [this] { return slam::convertMbot(files_.in, files_.out, truth_, mbot_); });
  command->add_option("--truth", truth_.file, "also write the poses that the log holds (TUM)");
  command->add_option("--truth-channel", truth_.channel, "where they are: the course's own SLAM, or TRUE_POSE")
      ->capture_default_str();
  command
      ->add_option("--metres-per-tick", mbot_.metres_per_tick,
                   "[m] of the encoders: 2.09e-4 in 2014-15, 8.2e-5 in 2016, 1.540e-4 from 2017 on, unless given")
      ->check(slam::inRange(1e-7, 0.1));
  command->add_option("--base-width", mbot_.width, "[m] between the wheels: 0.083 to 2016, 0.210 then, unless given")
      ->check(slam::inRange(0.02, 4.0));
  command->add_option("--wheel-radius", mbot_.wheel_radius, "[m] by which the log's angles are made of ticks")
      ->check(slam::inRange(0.005, 1.0));
  addFiles(command, files_);
}

void Conversions::addCsv() {
  CLI::App* command = add("csv", "tables of scans, speed, encoders and IMU to LCM log",
                          [this] { return slam::convertCsv(csv_, files_.out); });
  command->add_option("--scans", csv_.scans,
                      "ranges, in metres or raw SICK words; columns by a header (t, r0.., or bearings, x, y, theta, "
                      "angle_min..) or the options below");
  command->add_option("--unit", csv_.unit, "of the ranges, where the data does not show it")
      ->check(CLI::IsMember({"m", "cm", "mm", "words"}));
  command->add_option("--stamp-column", csv_.stamp_column, "of the scans: name, or number from 1");
  command->add_option("--first-range", csv_.first_range, "column of the first range: name, or number from 1");
  command
      ->add_option("--fov", csv_.field_of_view,
                   "[deg] from first to last beam, ahead in its middle; below 0: clockwise")
      ->check(slam::inRange(-360.0, 360.0));
  command->add_option("--first-bearing", csv_.first_bearing, "[deg] of the first beam, counter-clockwise from ahead")
      ->check(slam::inRange(-360.0, 360.0));
  command->add_option("--period", csv_.period, "[s] from scan to scan, where there are no stamps")
      ->check(slam::inRange(1e-3, 10.0));
  command->add_option("--speed", csv_.speed, "t_s,v_m_s");
  command->add_option("--imu", csv_.imu, "t_s,ax_g,ay_g,az_g,wx_rad_s,wy_rad_s,wz_rad_s");
  command->add_flag_callback(
      "--imu-z-down", [this] { csv_.imu_sign_z = -1.0; }, "the IMU's z axis points down: turn its sign");
  command->add_option("--encoders", csv_.encoders, "stamp_s and ticks per interval of four wheels");
  command->add_option("--metres-per-tick", csv_.metres_per_tick, "of the encoders")->capture_default_str();
  command->add_option("--wheel-radius", csv_.wheel_radius, "[m] of the encoders' wheels")->capture_default_str();
  command->add_option("--half-track", csv_.half_track, "[m] half the effective track")->capture_default_str();
  addOutput(command, files_);
}

CLI::App* addDisturb(CLI::App& app, Files& files, slam::Disturbance& disturbance) {
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
  return disturb;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Converts recorded data of other systems to an LCM event log that slam-replay reads, and back",
               "slam-convert");
  app.require_subcommand(1);
  Files files;
  Conversions conversions(app, files);
  conversions.addWithFiles("auto", "whatever it is: recognised by its content, with a report of what was found",
                           slam::convertAny);
  conversions.addCarmen();
  conversions.addRos();
  conversions.addWithFiles("lcm", "LCM log with slamd's channels: its sensors alone", slam::convertLcm);
  CLI::App* to_carmen = app.add_subcommand("to-carmen", "our LCM log to CARMEN");
  addPair(to_carmen, files);
  std::string trajectory;
  CLI::App* to_mcap = app.add_subcommand("to-mcap", "our LCM log to MCAP, for Foxglove");
  to_mcap->add_option("--trajectory", trajectory, "poses of the robot in place of the log's own (TUM, of slam-replay)");
  addPair(to_mcap, files);
  CLI::App* to_bag = app.add_subcommand("to-bag", "our LCM log to a bag of ROS 2: .db3 or .mcap, by OUT's name");
  addPair(to_bag, files);
  conversions.addWithFiles("mines", "Mines ParisTech rover .dat to LCM log", slam::convertMines);
  conversions.addWithFiles("wean", "CMU Wean Hall robotdata .log to LCM log", slam::convertWean);
  conversions.addMbot();
  conversions.addCsv();
  slam::Disturbance disturbance;
  CLI::App* disturb = addDisturb(app, files, disturbance);
  CLI::App* map = app.add_subcommand("wean-map", "the map that comes with Wean Hall's logs to OUT.yaml, .pgm and .png");
  addPair(map, files, "prefix of the map files");

  return slam::runProgram(
      app, argc, argv, SLAMD_VERSION, "slam-convert auto drive.bag drive.lcm --config drive.toml", [&] {
        map->parsed() ? slam::prepareMapFiles(files.out) : slam::prepareOutput(files.out);
        for (const fs::path& file : {fs::path(files.config), conversions.truth()}) slam::prepareOutput(file);
        conversions.run();
        if (map->parsed()) slam::writeMapFiles(files.out, slam::readBeesoftMap(files.in), {});
        if (to_carmen->parsed()) std::cout << reportText(slam::convertToCarmen(files.in, files.out), files.out, false);
        if (to_mcap->parsed())
          std::cout << reportText(slam::convertToMcap(files.in, files.out, trajectory), files.out, true);
        if (to_bag->parsed()) std::cout << reportText(slam::convertToBag(files.in, files.out), files.out, true);
        if (disturb->parsed()) {
          std::cout << reportText(slam::disturbLog(files.in, files.out, disturbance), files.out, false);
        }
        return slam::kDone;
      });
}
