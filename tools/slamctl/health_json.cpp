// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/health_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/estimates.hpp"
#include "drivers/device_status.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {
namespace {

using nlohmann::json;
constexpr const char* kLevels[] = {"good", "warning", "fault"};  // of a finding

}  // namespace

std::string stateName(std::int8_t state) {
  const auto index = static_cast<std::uint8_t>(state);
  return index <= static_cast<std::uint8_t>(LocalisationState::kLost) ? nameOf(static_cast<LocalisationState>(index))
                                                                      : "unknown";
}

json problemJson(const problem_t& p) {
  return {{"device", p.device},       {"id", p.id},       {"level", p.level > 1 ? "fault" : "warning"},
          {"numbers", p.numbers},     {"texts", p.texts}, {"cause", p.cause},
          {"meanwhile", p.meanwhile}, {"fix", p.fix}};
}

double rounded(double value, double scale) { return std::round(value * scale) / scale; }

json poseJson(const pose_estimate_t& pose) {
  const double* c = pose.covariance;
  return {
      {"utime", pose.utime},
      {"map", pose.map_id},
      {"x", rounded(pose.x)},
      {"y", rounded(pose.y)},
      {"theta", rounded(pose.theta)},
      {"cov",
       {rounded(c[0], 1e9), rounded(c[1], 1e9), rounded(c[4], 1e9), rounded(c[8], 1e9)}},  // xx, xy, yy, theta theta
      {"speed", rounded(pose.twist[0], 1e3)},
      {"turn", rounded(pose.twist[2], 1e3)},
      {"state", stateName(static_cast<std::int8_t>(pose.state))},
      {"quality", rounded(static_cast<double>(pose.match_quality), 1e2)}};
}

json healthJson(const health_t& health, const problems_t& problems) {
  json devices = json::array(), stages = json::array(), counters = json::object();
  const Findings findings = checkHealth(health, problems);
  for (std::size_t i = 0; i < health.devices.size(); ++i) {
    const device_health_t& d = health.devices[i];
    devices.push_back({{"name", d.name},
                       {"state", nameOf(static_cast<DeviceState>(static_cast<std::uint8_t>(d.state)))},
                       {"level", kLevels[findings[i].level]},
                       {"reason", d.reason},
                       {"advice", findings[i].fix},
                       {"age", rounded(d.age, 1e2)},
                       {"rate", rounded(d.rate, 10)},
                       {"expected", rounded(d.expected, 10)},
                       {"rejects", d.rejects}});
  }
  json wrong = json::array();
  for (const problem_t& p : problems.problems) wrong.push_back(problemJson(p));
  for (const stage_health_t& s : health.stages)
    stages.push_back(
        {{"name", s.name}, {"count", s.count}, {"p50_us", s.p50_us}, {"p99_us", s.p99_us}, {"max_us", s.max_us}});
  for (const counter_t& counter : health.counters) counters[counter.name] = counter.value;
  return {{"utime", health.utime},
          {"uptime", rounded(health.uptime, 10)},
          {"state", stateName(static_cast<std::int8_t>(health.localisation))},
          {"summary", health.summary},
          {"cpu", rounded(health.cpu, 1e3)},
          {"memory_mb", rounded(health.memory_mb, 10)},
          {"disk_free_mb", rounded(health.disk_free_mb, 1)},
          {"devices", std::move(devices)},
          {"problems", std::move(wrong)},
          {"stages", std::move(stages)},
          {"counters", std::move(counters)}};
}

json findingsJson(const std::vector<Finding>& findings) {
  json list = json::array();
  for (const Finding& finding : findings)
    list.push_back({{"level", kLevels[finding.level]}, {"what", finding.what}, {"fix", finding.fix}});
  return list;
}

std::string textOf(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

}  // namespace slam
