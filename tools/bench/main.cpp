// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "config/loader.hpp"
#include "mapping/map_files.hpp"
#include "slam/map_import.hpp"
#include "tools/bench/ablation.hpp"
#include "tools/bench/cold_starts.hpp"
#include "tools/bench/map_commands.hpp"
#include "tools/bench/scan_pairs.hpp"
#include "tools/bench/situation_means.hpp"
#include "tools/common/program.hpp"
#include "tools/replay/stats.hpp"

namespace {

struct NoiseRow {
  double translation, rotation_degrees;  // [m], [deg]
  double csm_success;                    // [%] of the CSM library on the same pairs
};
constexpr NoiseRow kRows[] = {
    {0.0, 0.0, 99.8}, {0.1, 5.0, 98.6}, {0.2, 10.0, 96.6}, {0.3, 20.0, 90.2}, {0.5, 30.0, 81.5}};

void printMatchers(const std::vector<slam::ScanPair>& pairs, const slam::Config& config, std::uint64_t seed) {
  std::printf("%zu pairs of scans, seed %llu; success: within 0.10 m and 2 deg\n", pairs.size(),
              static_cast<unsigned long long>(seed));
  std::printf("%-9s %-18s %8s %6s %14s %18s %12s %18s\n", "matcher", "noise", "success", "CSM", "wrong/refused",
              "median error", "iterations", "time [us]");
  for (const auto& [name, matcher] : {std::pair("ICP", slam::Matcher::kPointToPoint),
                                      {"PL-ICP", slam::Matcher::kPointToLine},
                                      {"+search", slam::Matcher::kPointToLineOrSearch}}) {
    for (const NoiseRow& row : kRows) {
      const auto r = slam::matchPairs(pairs, matcher, row.translation, row.rotation_degrees * std::numbers::pi / 180.0,
                                      seed, config);
      std::printf(
          "%-9s +-%.1f m, %4.1f deg %7.1f%% %5.1f%% %7d/%-6d %.4f m %.3f deg %5.0f p99 %-4.0f %6.0f p99 %-6.0f\n", name,
          row.translation, row.rotation_degrees, 100.0 * r.success, row.csm_success, r.wrong, r.wrong_refused,
          r.median_translation, r.median_rotation, r.median_iterations, r.p99_iterations, r.median_us, r.p99_us);
    }
  }
}

void printColdStarts(const slam::ColdStartReport& report, bool verbose) {
  if (verbose) {
    for (const slam::ColdStart& start : report.starts) {
      if (start.found) {
        std::printf("at %6.1f s: found after %4.1f s, %.2f m %.1f deg off\n", start.begin, start.after,
                    start.error.translation, start.error.rotation);
      } else {
        std::printf("at %6.1f s: not yet", start.begin);
        for (const slam::ColdSearch& search : start.searches) {
          std::printf("%s %.1f s %s %.1f", &search == &start.searches.front() ? ":" : ",", search.after,
                      search.error.right() ? "right by" : "wrong by", search.margin);
        }
        std::printf("\n");
      }
    }
  }
  const auto search = slam::quantiles(report.search_ms);
  std::printf("%zu cold starts: %d right, %d wrong, %d not yet; %zu searches, median %.0f ms, p99 %.0f ms\n",
              report.starts.size(), report.right, report.wrong, report.not_yet, report.search_ms.size(), search.p50,
              search.p99);
  std::printf(
      "truth: the log's own map laid into the given one, %.0f %% of its walls in place, log-likelihood %.0f over the "
      "second best place\n",
      100.0 * report.truth_seen, report.truth_margin);
}

/// What each start would believe first, were such a margin enough.
void printLeads(const slam::ColdStartReport& report) {
  double largest = 0.0;
  int leading = 0;
  for (const slam::ColdStart& start : report.starts) {
    leading += !start.searches.empty() && start.searches.back().error.right();
    for (const slam::ColdSearch& search : start.searches) {
      if (!search.error.right()) largest = std::max(largest, search.margin);
    }
  }
  for (const double margin : {4.0, 4.5, 5.0, 5.5, 6.0, 7.0, 8.0, 9.0}) {
    int right = 0, wrong = 0;
    for (const slam::ColdStart& start : report.starts) {
      const auto believed = std::find_if(start.searches.begin(), start.searches.end(),
                                         [&](const slam::ColdSearch& search) { return search.margin >= margin; });
      if (believed != start.searches.end()) ++(believed->error.right() ? right : wrong);
    }
    std::printf("margin %.1f: %d right, %d wrong\n", margin, right, wrong);
  }
  std::printf("the true place leads at the end: %d; largest margin of a wrong place: %.1f\n", leading, largest);
}

/// Rules of the front end whose names begin with one of `asked`; all where none is.
std::vector<const slam::Rule*> rulesOf(const std::vector<std::string>& asked) {
  std::vector<const slam::Rule*> rules;
  for (const slam::Rule& rule : slam::frontEndRules()) {
    const bool wanted = std::any_of(asked.begin(), asked.end(), [&](const std::string& name) {
      return rule.name == name || rule.name.starts_with(name + " ");
    });
    if (asked.empty() || wanted) rules.push_back(&rule);
  }
  return rules;
}

/// What a case loses without a rule, in words; nothing where it loses and gains nothing.
std::string change(const slam::AblationFigures& with, const slam::AblationFigures& without) {
  constexpr double kRatio = 0.02, kShare = 0.002;  // less is not worth a word
  std::string text;
  char word[64];
  for (std::size_t i = 0; i < with.errors.size(); ++i) {
    const double ratio = without.errors[i] / with.errors[i];
    if (!(std::abs(ratio - 1.0) > kRatio)) continue;
    const char* poses = with.errors.size() == 1 ? "" : i == 0 ? "final " : "causal ";
    std::snprintf(word, sizeof word, "%s%s%.2f", text.empty() ? "" : ", ", poses, ratio);
    text += word;
  }
  for (const auto& [name, share] : {std::pair("not localised", without.lost - with.lost),
                                    {"sure and wrong", without.sure_and_wrong - with.sure_and_wrong}}) {
    if (!(std::abs(share) > kShare)) continue;
    std::snprintf(word, sizeof word, "%s%s %+.1f %%", text.empty() ? "" : ", ", name, 100.0 * share);
    text += word;
  }
  return text;
}

void printAblation(const std::vector<slam::AblationCase>& cases, const std::vector<std::string>& asked, int jobs) {
  std::vector<slam::AblationFigures> with;
  const auto rules = rulesOf(asked);
  slam::ablate(cases, rules, jobs, [&](const slam::Rule* without, const std::vector<slam::AblationFigures>& of_cases) {
    if (without == nullptr) {
      with = of_cases;
      std::printf("| case | error [m] | not localised | sure and wrong |\n|---|---|---|---|\n");
      for (std::size_t i = 0; i < cases.size(); ++i) {
        std::printf("| %s |", cases[i].name.c_str());
        for (const double error : with[i].errors) std::printf(" %.4f", error);
        std::printf(" | %.1f %% | %.1f %% |\n", 100.0 * with[i].lost, 100.0 * with[i].sure_and_wrong);
      }
      std::printf(
          "\n| without | error, mean ratio | largest | what changes, as a ratio of the error |\n|---|---|---|---|\n");
      return;
    }
    double log_sum = 0.0, largest = 0.0;
    int count = 0;
    std::string changes;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      for (std::size_t k = 0; k < with[i].errors.size(); ++k) {
        const double ratio = of_cases[i].errors[k] / with[i].errors[k];
        if (!(with[i].errors[k] > 0.0)) continue;  // of a kind that was never wrong
        log_sum += std::log(std::max(ratio, 1e-3));
        largest = std::max(largest, ratio);
        ++count;
      }
      const std::string words = change(with[i], of_cases[i]);
      if (!words.empty()) changes += (changes.empty() ? "" : "; ") + cases[i].name + " " + words;
    }
    std::printf("| %s | %.3f | %.2f | %s |\n", std::string(without->name).c_str(),
                std::exp(log_sum / std::max(1, count)), largest, changes.c_str());
    std::fflush(stdout);
  });
}

/// A row for each rule and situation.
void printMeans(const std::vector<slam::AblationCase>& cases, const std::vector<std::string>& asked, int jobs) {
  std::vector<slam::AblationFigures> with;
  const auto rules = rulesOf(asked);
  std::printf(
      "| without | situation | drives | error, with it [m] | without | not localised, with it | without | "
      "sure and wrong, with it | without |\n|---|---|---|---|---|---|---|---|---|\n");
  slam::ablate(cases, rules, jobs, [&](const slam::Rule* without, const std::vector<slam::AblationFigures>& of_cases) {
    if (without == nullptr) {
      with = of_cases;
      return;
    }
    for (const slam::SituationMeans& means : slam::situationMeans(cases, with, of_cases)) {
      std::printf("| %s | %s | %d |", std::string(without->name).c_str(), means.situation.c_str(), means.drives);
      for (const double error : {means.with.error, means.without.error})
        std::isnan(error) ? std::printf(" - |") : std::printf(" %.4f |", error);
      for (const double share :
           {means.with.lost, means.without.lost, means.with.sure_and_wrong, means.without.sure_and_wrong})
        std::printf(" %.1f %% |", 100.0 * share);
      std::printf("\n");
    }
    std::fflush(stdout);
  });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Tables of matcher success; see tools/benchmark for all benchmarks", "slam-benchmark");
  app.require_subcommand(1);
  std::string config_file, log, relations;
  std::vector<std::string> overrides;
  std::uint64_t seed = 1;
  CLI::App* matcher = app.add_subcommand("matcher", "ICP and PL-ICP on pairs of scans whose relation is known");
  matcher->add_option("--config", config_file, "slamd configuration (TOML)")->required();
  matcher->add_option("--set", overrides, "section.key=value over the file; may be repeated");
  matcher->add_option("--seed", seed, "of the noise on the guesses")->capture_default_str();
  matcher->add_option("LOG", log, "LCM event log")->required();
  matcher->add_option("RELATIONS", relations, "known relative poses")->required();
  CLI::App* localise = app.add_subcommand("localise", "cold starts all over a log in a given map");
  std::string map, starts;
  int places = 50;
  double seconds = 10.0;
  bool verbose = false, leads = false;
  localise->add_option("--config", config_file, "slamd configuration (TOML)")->required();
  localise->add_option("--set", overrides, "section.key=value over the file; may be repeated");
  localise->add_option("--places", places, "number of starts")->capture_default_str()->check(CLI::Range(1, 100000));
  localise->add_option("--seconds", seconds, "[s] that each drives at most")->capture_default_str();
  localise->add_flag("--verbose", verbose, "a line for each start");
  localise->add_flag("--leads", leads,
                     "believe no place that has a rival: how often the best one was right or wrong, by its margin");
  localise->add_option("--starts", starts, "write a row a start: when, where found, its searches (CSV)");
  localise->add_option("LOG", log, "LCM event log")->required();
  localise->add_option("MAP", map, "map_server .yaml")->required();
  CLI::App* ablate = app.add_subcommand("ablate", "what each rule of the front end is worth on a list of drives");
  std::vector<std::string> rules;
  int jobs = 2;
  ablate->add_option("--rule", rules, "without this rule alone; may be repeated");
  ablate->add_option("--jobs", jobs, "runs at a time")->capture_default_str()->check(CLI::Range(1, 64));
  bool means = false;
  ablate->add_flag("--means", means, "a row for each rule and situation: the means over its seeds");
  ablate->add_option("CASES", log, "list of drives, see tools/bench/ablation.hpp")->required();
  const slam::MapCommands maps(app);
  return slam::runProgram(
      app, argc, argv, SLAMD_VERSION, "slam-benchmark matcher --config config/carmen.toml intel.lcm intel.relations",
      [&] {
        if (maps.parsed()) {
          maps.carryOut();
          return slam::kDone;
        }
        if (ablate->parsed()) {
          (means ? printMeans : printAblation)(slam::readCases(log), rules, jobs);
          return slam::kDone;
        }
        slam::Config config = slam::loadConfig(config_file, overrides);
        if (localise->parsed()) {
          config.mode = slam::RunMode::kLocalise;
          const auto state = slam::importMap(slam::readMapFiles(map));
          slam::showProgress("laying the log into the map");
          const auto report = slam::coldStarts(log, config, state, places, seconds, leads, [&](int done) {
            slam::showProgress(std::to_string(done) + " of " + std::to_string(places) + " starts");
          });
          slam::endProgress();
          if (!starts.empty()) slam::writeStarts(report, starts);
          printColdStarts(report, verbose);
          if (leads) printLeads(report);
          return slam::kDone;
        }
        printMatchers(slam::loadScanPairs(log, relations, config), config, seed);
        return slam::kDone;
      });
}
