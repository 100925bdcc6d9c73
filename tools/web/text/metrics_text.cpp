// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/text/metrics_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "drivers/device_status.hpp"

namespace slam {
namespace {

using Labels = std::initializer_list<std::pair<const char*, std::string_view>>;

/// A value of a label: the format knows three escapes.
std::string escaped(std::string_view value) {
  std::string text;
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    c == '\n' ? text += "\\n" : text += c;
  }
  return text;
}

class Metrics {
 public:
  /// Begins a family of metrics. @param type "gauge" or "counter"
  void begin(const char* name, const char* type, const char* help) {
    name_ = name;
    text_ += std::string("# HELP ") + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
  }
  void add(double value, Labels labels = {}) {
    text_ += name_;
    char separator = '{';
    for (const auto& [label, of] : labels) {
      text_ += separator + std::string(label) + "=\"" + escaped(of) + "\"";
      separator = ',';
    }
    char number[32];
    std::snprintf(number, sizeof number, "%s %.12g\n", labels.size() > 0 ? "}" : "", value);
    text_ += number;
  }
  void addOne(const char* name, const char* help, double value) {
    begin(name, "gauge", help);
    add(value);
  }
  std::string take() { return std::move(text_); }

 private:
  const char* name_ = "";
  std::string text_;
};

void addPose(Metrics& metrics, const pose_estimate_t& pose) {
  constexpr std::pair<LocalisationState, const char*> kStates[] = {{LocalisationState::kInitialising, "initialising"},
                                                                   {LocalisationState::kLocalised, "localised"},
                                                                   {LocalisationState::kDegraded, "degraded"},
                                                                   {LocalisationState::kLost, "lost"}};
  metrics.begin("slamd_state", "gauge", "1 for the state that the pose is in; it is valid when localised or degraded.");
  for (const auto& [state, name] : kStates)
    metrics.add(static_cast<std::uint8_t>(pose.state) == static_cast<std::uint8_t>(state) ? 1.0 : 0.0,
                {{"state", name}});
  metrics.addOne("slamd_pose_x_metres", "Of base in map.", pose.x);
  metrics.addOne("slamd_pose_y_metres", "Of base in map.", pose.y);
  metrics.addOne("slamd_pose_heading_radians", "Of base in map, counter-clockwise.", pose.theta);
  const double variance = std::max({0.0, pose.covariance[0], pose.covariance[4]});
  metrics.addOne("slamd_pose_sigma_metres", "Standard deviation, the larger one of x and y.", std::sqrt(variance));
  metrics.addOne("slamd_match_quality_ratio", "Share of the newest scan's points that met the reference.",
                 static_cast<double>(pose.match_quality));
}

void addDevices(Metrics& metrics, const health_t& health) {
  metrics.begin("slamd_device_streaming", "gauge", "1 while the device's samples come.");
  for (const device_health_t& d : health.devices)
    metrics.add(d.state == static_cast<std::int8_t>(DeviceState::kStreaming) ? 1.0 : 0.0, {{"device", d.name}});
  metrics.begin("slamd_device_rate_hertz", "gauge", "Samples a second.");
  for (const device_health_t& d : health.devices) metrics.add(d.rate, {{"device", d.name}});
  metrics.begin("slamd_device_rejects_total", "counter", "Samples and frames of the device that were refused.");
  for (const device_health_t& d : health.devices) metrics.add(static_cast<double>(d.rejects), {{"device", d.name}});
}

void addHealth(Metrics& metrics, const health_t& health) {
  metrics.addOne("slamd_uptime_seconds", "Since slamd has started.", health.uptime);
  metrics.addOne("slamd_cpu_ratio", "Share of one core.", health.cpu);
  metrics.addOne("slamd_memory_bytes", "Resident memory.", 1e6 * health.memory_mb);
  metrics.addOne("slamd_disk_free_bytes", "Where slamd writes; below zero: it writes nothing.",
                 1e6 * health.disk_free_mb);
  addDevices(metrics, health);
  metrics.begin("slamd_stage_seconds", "gauge", "Time that a stage takes, since the start.");
  for (const stage_health_t& s : health.stages) {
    metrics.add(1e-6 * s.p50_us, {{"stage", s.name}, {"quantile", "0.5"}});
    metrics.add(1e-6 * s.p99_us, {{"stage", s.name}, {"quantile", "0.99"}});
  }
  metrics.begin("slamd_counter", "gauge", "A row of docs/counters.md.");
  for (const counter_t& c : health.counters) metrics.add(static_cast<double>(c.value), {{"name", c.name}});
}

}  // namespace

std::string metricsText(const WebState& state, const FoxgloveCounts& foxglove, const std::string& version,
                        Timestamp now) {
  Metrics metrics;
  metrics.begin("slamd_build_info", "gauge", "Always 1; the version is in its label.");
  metrics.add(1.0, {{"version", version}});
  metrics.addOne("slamd_silence_seconds", "Since slamd's last message came.", toSeconds(state.silence(now)));
  metrics.addOne("slamd_foxglove_clients", "Connections by Foxglove's protocol.",
                 static_cast<double>(foxglove.clients));
  metrics.begin("slamd_foxglove_dropped_messages_total", "counter", "Of clients that read too slowly.");
  metrics.add(static_cast<double>(foxglove.dropped_messages));
  metrics.begin("slamd_foxglove_ended_clients_total", "counter",
                "Clients that took nothing, sent too much that is wrong, or made place.");
  metrics.add(static_cast<double>(foxglove.ended_clients));
  if (state.pose()) addPose(metrics, *state.pose());
  if (!state.health()) return metrics.take();
  addHealth(metrics, *state.health());
  metrics.begin("slamd_problem", "gauge", "1 for each problem that slamd has now; its id stays when words change.");
  for (const problem_t& p : state.problems().problems)
    metrics.add(1.0, {{"device", p.device}, {"id", p.id}, {"level", p.level > 1 ? "fault" : "warning"}});
  return metrics.take();
}

}  // namespace slam
