// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <iostream>
#include <numbers>

#include "mapping/map_files.hpp"
#include "tools/common/program.hpp"
#include "tools/convert/formats.hpp"

namespace {

namespace fs = std::filesystem;

void printReport(const std::string& out, const slam::ConvertReport& report) {
  std::cout << out << ": " << report.scans << " scans, " << report.wheels << " wheel samples, " << report.imu
            << " IMU samples";
  if (report.poses > 0) std::cout << ", " << report.poses << " poses";
  if (report.rejected > 0) {
    std::cout << "; " << report.rejected << " records refused, first at " << report.first_rejection;
  }
  std::cout << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Converts recorded data of other systems to an LCM event log that slam-replay reads, and back",
               "slam-convert");
  app.require_subcommand(1);
  std::string in, out;
  using Convert = slam::ConvertReport (*)(const fs::path&, const fs::path&);
  const auto add = [&](const char* name, const char* what, Convert convert) {
    CLI::App* command = app.add_subcommand(name, what);
    command->add_option("IN", in, "input, plain or .gz")->required();
    command->add_option("OUT", out, "output")->required();
    return std::pair(command, convert);
  };
  const std::pair<CLI::App*, Convert> commands[] = {
      add("carmen", "CARMEN log (FLASER, ROBOTLASER1 and ODOM lines) to LCM log", slam::convertCarmen),
      add("to-carmen", "our LCM log to CARMEN", slam::convertToCarmen),
      add("mines", "Mines ParisTech rover .dat to LCM log", slam::convertMines),
      add("wean", "CMU Wean Hall robotdata .log to LCM log", slam::convertWean),
  };
  slam::MbotTruth truth;
  CLI::App* mbot = app.add_subcommand("mbot", "LCM log of a Maebot or MBot to ours");
  mbot->add_option("--truth", truth.file, "also write the poses that the log holds (TUM)");
  mbot->add_option("--truth-channel", truth.channel, "where they are: the course's own SLAM, or TRUE_POSE")
      ->capture_default_str();
  mbot->add_option("IN", in, "input, plain or .gz")->required();
  mbot->add_option("OUT", out, "output")->required();
  slam::CsvInput csv;
  bool imu_z_down = false;
  CLI::App* csv_command = app.add_subcommand("csv", "tables of scans, speed, encoders and IMU to LCM log");
  csv_command->add_option("--scans", csv.scans, "t_s and raw SICK words of a half turn");
  csv_command->add_option("--speed", csv.speed, "t_s,v_m_s");
  csv_command->add_option("--imu", csv.imu, "t_s,ax_g,ay_g,az_g,wx_rad_s,wy_rad_s,wz_rad_s");
  csv_command->add_flag("--imu-z-down", imu_z_down, "the IMU's z axis points down: turn its sign");
  csv_command->add_option("--encoders", csv.encoders, "stamp_s and ticks per interval of four wheels");
  csv_command->add_option("--metres-per-tick", csv.metres_per_tick, "of the encoders")->capture_default_str();
  csv_command->add_option("--half-track", csv.half_track, "[m] half the effective track")->capture_default_str();
  csv_command->add_option("OUT", out, "output")->required();

  slam::Disturbance disturbance;
  CLI::App* disturb =
      app.add_subcommand("disturb", "our log with sensors that lie, lag or are mounted wrong, to see what it does");
  disturb->add_option("--jumps", disturbance.jumps, "sudden false motions at random times")
      ->check(CLI::Range(0, 100000));
  disturb->add_option("--jump-translation", disturbance.jump_translation, "[m] at most")
      ->check(slam::inRange(0.0, 100.0))
      ->capture_default_str();
  disturb->add_option("--jump-rotation", disturbance.jump_rotation, "[rad] at most")
      ->check(slam::inRange(0.0, std::numbers::pi))
      ->capture_default_str();
  disturb->add_option("--noise", disturbance.noise, "[m per sqrt(m), rad per sqrt(m) and per sqrt(rad)]")
      ->check(slam::inRange(0.0, 10.0));
  disturb->add_option("--distance-scale", disturbance.distance_scale, "[1] error of the wheels' radius")
      ->check(slam::inRange(-0.9, 10.0));
  disturb->add_flag("--reverse-sign", disturbance.reverse_sign, "driving backwards is reported as forwards");
  disturb
      ->add_option("--wheel-lag", disturbance.wheel_lag,
                   "[s] a wheel sample says where they stood so long before its stamp")
      ->check(slam::inRange(0.0, 10.0));
  disturb->add_flag("--wheels-swapped", disturbance.wheels_swapped, "left and right: they turn the wrong way");
  disturb->add_flag("--wheels-backwards", disturbance.wheels_backwards, "both count backwards");
  disturb->add_flag("--gyro-reversed", disturbance.gyro_reversed, "its z axis points down");
  disturb->add_flag("--lidar-upside-down", disturbance.lidar_upside_down, "its beams are mirrored");
  disturb->add_flag("--lidar-turned", disturbance.lidar_turned, "by 180 degrees");
  disturb->add_flag("--double-scans", disturbance.double_scans, "every scan is sent twice");
  disturb->add_flag("--time-backwards", disturbance.time_backwards,
                    "clocks are set back by 30 s in the middle, and every tenth scan by 0.3 s");
  disturb->add_option("--seed", disturbance.seed, "of times, jumps and noise")->capture_default_str();
  disturb->add_option("IN", in, "input, plain or .gz")->required();
  disturb->add_option("OUT", out, "output")->required();

  CLI::App* map = app.add_subcommand("wean-map", "the map that comes with Wean Hall's logs to OUT.yaml, .pgm and .png");
  map->add_option("IN", in, "input, plain or .gz")->required();
  map->add_option("OUT", out, "prefix of the map files")->required();

  return slam::runProgram(app, argc, argv, SLAMD_VERSION, "slam-convert carmen intel.clf.gz intel.lcm", [&] {
    if (csv_command->parsed()) {
      csv.imu_sign_z = imu_z_down ? -1.0 : 1.0;
      printReport(out, slam::convertCsv(csv, out));
    }
    if (map->parsed()) slam::writeMapFiles(out, slam::readBeesoftMap(in), {});
    if (mbot->parsed()) printReport(out, slam::convertMbot(in, out, truth));
    if (disturb->parsed()) printReport(out, slam::disturbLog(in, out, disturbance));
    for (const auto& [command, convert] : commands) {
      if (command->parsed()) printReport(out, convert(in, out));
    }
    return slam::kDone;
  });
}
