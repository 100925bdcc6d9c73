// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/text/metrics_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>
#include <sstream>

#include "bus/problem_message.hpp"
#include "problems/devices.hpp"

namespace slam::metrics_text_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;
constexpr Timestamp kNow{Duration(100s)};

void fill(WebState& state) {
  state.begin(kNow);
  pose_estimate_t pose{};
  pose.utime = 1'700'000'000'000'000;
  pose.map_id = 5;
  pose.x = -1.5;
  pose.covariance[0] = 0.0004;
  pose.covariance[4] = 0.0001;
  pose.state = 2;
  state.take(pose, kNow);
  problems_t problems{};
  problems.problems = {toMessage("lidar", Problem(problem::kSilent), true)};
  state.take(problems, kNow);
  health_t health{};
  health.memory_mb = 42.0;
  device_health_t lidar{};
  lidar.name = "lidar \"A1\"\n";
  lidar.state = 2;
  lidar.rate = 5.5;
  health.devices = {lidar};
  stage_health_t match{};
  match.name = "match";
  match.p99_us = 1250.0;
  health.stages = {match};
  counter_t closures{};
  closures.name = "loop_closures";
  closures.value = 7;
  health.counters = {closures};
  state.take(health, kNow);
}

TEST(MetricsText, HasPoseDevicesStagesCountersAndProblems) {
  WebState state{Config{}};
  fill(state);
  const std::string text = metricsText(state, FoxgloveCounts{}, "1.2.3", kNow + 2s);
  for (const char* line :
       {"slamd_build_info{version=\"1.2.3\"} 1\n", "slamd_silence_seconds 2\n", "slamd_state{state=\"degraded\"} 1\n",
        "slamd_state{state=\"localised\"} 0\n", "slamd_pose_x_metres -1.5\n", "slamd_pose_sigma_metres 0.02\n",
        "slamd_memory_bytes 42000000\n", "slamd_stage_seconds{stage=\"match\",quantile=\"0.99\"} 0.00125\n",
        "slamd_counter{name=\"loop_closures\"} 7\n",
        "slamd_problem{device=\"lidar\",id=\"silent\",level=\"fault\"} 1\n"})
    EXPECT_THAT(text, HasSubstr(line));
}

TEST(MetricsText, KeepsTheFormatWhateverANameHolds) {
  WebState state{Config{}};
  fill(state);
  std::istringstream lines(metricsText(state, FoxgloveCounts{}, "1.2.3", kNow));
  const std::regex comment(R"(# (HELP|TYPE) [a-z_]+ .+)");
  const std::regex sample(
      R"re([a-z_]+(\{[a-z]+="([^"\\]|\\["\\n])*"(,[a-z]+="([^"\\]|\\["\\n])*")*\})? -?[0-9.e+-]+)re");
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(std::regex_match(line, line.starts_with("#") ? comment : sample)) << line;
}

TEST(MetricsText, HasTheSilenceAloneBeforeSlamdHasSentAnything) {
  WebState state{Config{}};
  state.begin(kNow);
  const std::string text = metricsText(state, FoxgloveCounts{}, "1.2.3", kNow + 5s);
  EXPECT_THAT(text, HasSubstr("slamd_silence_seconds 5\n"));
  EXPECT_THAT(text, Not(HasSubstr("slamd_pose")));
}

}  // namespace
}  // namespace slam::metrics_text_test
