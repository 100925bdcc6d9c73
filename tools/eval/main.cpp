// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "config/loader.hpp"
#include "mapping/colour_image.hpp"
#include "mapping/map_files.hpp"
#include "tools/common/output_file.hpp"
#include "tools/common/program.hpp"
#include "tools/eval/live_report.hpp"
#include "tools/eval/map_metrics.hpp"
#include "tools/eval/metrics.hpp"
#include "tools/eval/overlay.hpp"
#include "tools/eval/trust.hpp"

namespace {

void printRelations(const slam::RelationErrors& e, bool json) {
  if (json) {
    std::printf(
        "{\"relations\": %d, \"left_out\": %d, \"translation_m\": {\"mean\": %.6f, \"std\": %.6f}, "
        "\"rotation_deg\": {\"mean\": %.6f, \"std\": %.6f}, \"squared_translation_m2\": {\"mean\": %.8f, \"std\": "
        "%.8f}, "
        "\"squared_rotation_deg2\": {\"mean\": %.8f, \"std\": %.8f}}\n",
        e.used, e.left_out, e.translation.mean, e.translation.deviation, e.rotation.mean, e.rotation.deviation,
        e.squared_translation.mean, e.squared_translation.deviation, e.squared_rotation.mean,
        e.squared_rotation.deviation);
    return;
  }
  std::printf("relations used            %d (%d outside the trajectory's time left out)\n", e.used, e.left_out);
  std::printf("translation [m]           %.4f +- %.4f\n", e.translation.mean, e.translation.deviation);
  std::printf("rotation [deg]            %.3f +- %.3f\n", e.rotation.mean, e.rotation.deviation);
  std::printf("squared translation [m^2] %.6f +- %.6f\n", e.squared_translation.mean, e.squared_translation.deviation);
  std::printf("squared rotation [deg^2]  %.5f +- %.5f\n", e.squared_rotation.mean, e.squared_rotation.deviation);
}

void printAte(const slam::AteErrors& e, bool json) {
  if (json) {
    std::printf(
        "{\"poses\": %d, \"left_out\": %d, \"rmse_m\": %.6f, \"mean_m\": %.6f, \"max_m\": %.6f, "
        "\"rotation_mean_deg\": %.6f}\n",
        e.used, e.left_out, e.rmse, e.mean, e.max, e.rotation_mean);
    return;
  }
  std::printf("poses used     %d (%d outside the truth's time left out)\n", e.used, e.left_out);
  std::printf("ATE RMSE [m]   %.4f\nmean [m]       %.4f\nworst [m]      %.4f\n", e.rmse, e.mean, e.max);
  std::printf("heading [deg]  %.3f mean\n", e.rotation_mean);
}

void printMap(const slam::MapErrors& e, bool json) {
  if (json) {
    std::printf(
        "{\"cells\": %d, \"completeness\": %.5f, \"occupied\": {\"precision\": %.5f, \"recall\": %.5f, \"f1\": %.5f}, "
        "\"free\": {\"precision\": %.5f, \"recall\": %.5f, \"f1\": %.5f}, \"false_obstacles\": %.5f}\n",
        e.compared, e.completeness, e.occupied.precision, e.occupied.recall, e.occupied.f1, e.free.precision,
        e.free.recall, e.free.f1, e.false_obstacles);
    return;
  }
  std::printf("cells known in the truth  %d, of which the map knows %.1f %%\n", e.compared, 100.0 * e.completeness);
  std::printf("%-10s %9s %9s %9s\n", "", "precision", "recall", "F1");
  std::printf("%-10s %8.1f%% %8.1f%% %8.1f%%\n", "occupied", 100.0 * e.occupied.precision, 100.0 * e.occupied.recall,
              100.0 * e.occupied.f1);
  std::printf("%-10s %8.1f%% %8.1f%% %8.1f%%\n", "free", 100.0 * e.free.precision, 100.0 * e.free.recall,
              100.0 * e.free.f1);
  std::printf("free cells called occupied  %.2f %%\n", 100.0 * e.false_obstacles);
}

void writePair(const std::string& left, const std::string& right, const std::string& out) {
  constexpr int kScale = 3;  // [pixels] side of a cell
  const auto picture = [](const std::string& file) { return slam::colourMap(slam::readMapFiles(file), kScale); };
  std::ofstream png(out, std::ios::binary);
  png << slam::encodePng(slam::sideBySide(picture(left), picture(right)));
  if (!png.flush()) throw std::runtime_error(out + ": cannot be written");
}

void printWaypoints(const slam::WaypointErrors& e, bool json) {
  if (e.position.empty()) throw std::runtime_error("no waypoint lies within the trajectory's time");
  const auto mean = [](const std::vector<double>& values) { return slam::meanAndDeviation(values).mean; };
  const double worst = *std::max_element(e.position.begin(), e.position.end());
  const double worst_heading = *std::max_element(e.heading.begin(), e.heading.end());
  std::printf(json ? "{\"waypoints\": %zu, \"left_out\": %d, \"position_m\": {\"mean\": %.6f, \"worst\": %.6f}, "
                     "\"heading_deg\": {\"mean\": %.6f, \"worst\": %.6f}}\n"
                   : "waypoints %zu (%d left out)\nposition [m]   mean %.4f  worst %.4f\n"
                     "heading [deg]  mean %.3f  worst %.3f\n",
              e.position.size(), e.left_out, mean(e.position), worst, mean(e.heading), worst_heading);
}

void printOverlay(const slam::OverlayErrors& e, bool json) {
  std::printf(json ? "{\"mean_m\": %.6f, \"paired\": %.4f, \"points\": %d, \"first_scans\": %d, \"last_scans\": %d}\n"
                   : "point to line [m] %.4f mean\npaired            %.3f of %d points\n"
                     "scans             %d of the first visit, %d of the last\n",
              e.mean, e.paired, e.points, e.first_scans, e.last_scans);
}

void printTrust(const slam::TrustErrors& e, bool json) {
  if (e.scans == 0) throw std::runtime_error("the estimates and the truth have no time in common");
  const std::string noticed = e.noticed ? std::to_string(*e.noticed) : json ? "null" : "never";
  std::printf(json
                  ? "{\"scans\": %d, \"left_out\": %d, \"localised\": %d, \"sure_and_wrong\": %.6f, "
                    "\"needlessly_lost\": %.6f, \"worst_m\": %.4f, \"nees\": %.4f, \"noticed_s\": %s}\n"
                  : "scans                      %d (%d outside the truth's time left out)\n"
                    "localised                  %d\nof these sure and wrong    %.4f\nneedlessly lost            %.4f\n"
                    "worst while localised [m]  %.4f\nNEES, 3 is right           %.2f\nkidnapping noticed [s]     %s\n",
              e.scans, e.left_out, e.localised, e.sureAndWrong(), e.needlesslyLost(), e.worst, e.nees, noticed.c_str());
}

void addTrustOptions(CLI::App* trust, bool& no_align, slam::TrustOptions& options) {
  trust->add_flag("--no-align", no_align, "the map lies in the truth's frame; default: laid on it by the first 2 s");
  trust->add_option("--kidnapped", options.kidnapped, "[s] behind the first scan: when the robot was carried away");
}

CLI::App* addLive(CLI::App& app, slam::LiveInput& input) {
  CLI::App* live = app.add_subcommand("live", "table of a recorded live run of slamd against the simulator's truth");
  live->add_option("--record", input.record, "slamd's record (output.record)")->required();
  live->add_option("--truth", input.truth, "true poses (TUM)")->required();
  live->add_option("--waypoints", input.waypoints, "true poses at the measured waypoints (TUM)");
  live->add_option("--map", input.map, "map written by slamd (yaml)");
  live->add_option("--truth-map", input.truth_map, "true map (yaml)");
  live->add_option("--trajectory", input.trajectory, "write SLAM's poses (TUM)");
  return live;
}

struct OverlayArguments {
  slam::OverlayOptions options;
  std::string config_file;
  std::vector<std::string> overrides;
};

void addOverlayOptions(CLI::App* overlay, OverlayArguments& arguments) {
  overlay->add_option("--config", arguments.config_file, "slamd configuration (TOML)")->required();
  overlay->add_option("--set", arguments.overrides, "section.key=value over the file; may be repeated");
  overlay->add_option("--first-seconds", arguments.options.first_seconds, "[s] of the log that are the first visit")
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Accuracy of trajectories and maps", "slam-eval");
  app.require_subcommand(1);
  std::string estimate, truth;
  bool json = false, no_align = false;
  const auto add = [&](const char* name, const char* what, const char* first, const char* second) {
    CLI::App* command = app.add_subcommand(name, what);
    command->add_option(first, estimate)->required();
    command->add_option(second, truth)->required();
    command->add_flag("--json", json, "machine-readable");
    return command;
  };
  CLI::App* relations = add("relations", "trajectory against known relative poses", "TRAJ.tum", "FILE.relations");
  CLI::App* ate = add("ate", "absolute trajectory error after rigid alignment", "TRAJ.tum", "TRUTH.tum");
  ate->add_flag("--no-align", no_align, "compare in the files' own frames");
  slam::TrustOptions trust_options;
  CLI::App* trust = add("trust", "whether a robot that was sure was right", "ESTIMATES.csv", "TRUTH.tum");
  addTrustOptions(trust, no_align, trust_options);
  CLI::App* waypoints = add("waypoints", "position and heading at a few true poses", "TRAJ.tum", "WAYPOINTS.tum");
  slam::LiveInput live_input;
  CLI::App* live = addLive(app, live_input);
  CLI::App* map = add("map", "occupied and free cells against a true map", "MAP.yaml", "TRUTH.yaml");
  std::string picture;
  CLI::App* pair = app.add_subcommand("pair", "picture of two maps side by side");
  pair->add_option("LEFT.yaml", estimate)->required();
  pair->add_option("RIGHT.yaml", truth)->required();
  pair->add_option("OUT.png", picture)->required();
  OverlayArguments overlaid;
  CLI::App* overlay =
      add("overlay", "scans of the last visit to the start on the walls that the first one saw", "TRAJ.tum", "LOG.lcm");
  addOverlayOptions(overlay, overlaid);

  return slam::runProgram(
      app, argc, argv, SLAMD_VERSION, "slam-eval relations out/trajectory.tum intel.relations", [&] {
        if (relations->parsed()) {
          const auto errors = slam::relationErrors(slam::readTrajectory(estimate), slam::readRelations(truth));
          if (errors.used == 0) throw std::runtime_error("no relation lies within the trajectory's time");
          printRelations(errors, json);
        } else if (ate->parsed()) {
          const auto errors =
              slam::absoluteErrors(slam::readTrajectory(estimate), slam::readTrajectory(truth), !no_align);
          if (errors.used == 0) throw std::runtime_error("the two trajectories have no time in common");
          printAte(errors, json);
        } else if (trust->parsed()) {
          if (no_align) trust_options.align_seconds = 0.0;
          printTrust(slam::trustErrors(slam::readEstimates(estimate), slam::readTrajectory(truth), trust_options),
                     json);
        } else if (waypoints->parsed()) {
          printWaypoints(slam::waypointErrors(slam::readTrajectory(estimate), slam::readTrajectory(truth)), json);
        } else if (live->parsed()) {
          slam::prepareOutput(live_input.trajectory);
          slam::printLiveReport(live_input);
        } else if (map->parsed()) {
          printMap(slam::compareMaps(slam::readMapFiles(estimate), slam::readMapFiles(truth)), json);
        } else if (pair->parsed()) {
          slam::prepareOutput(picture);
          writePair(estimate, truth, picture);
        } else if (overlay->parsed()) {
          const slam::Config config = slam::loadConfig(overlaid.config_file, overlaid.overrides);
          printOverlay(slam::overlayVisits(slam::readTrajectory(estimate), truth, config, overlaid.options), json);
        }
        return slam::kDone;
      });
}
