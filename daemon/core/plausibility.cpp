// SPDX-License-Identifier: BSD-3-Clause
#include "core/plausibility.hpp"

#include <iomanip>
#include <sstream>

namespace slam {
namespace {

/// "x = 1e+06 m"
std::string named(const char* name, double value, const char* unit) {
  std::ostringstream text;
  text << name << " = " << value << (*unit == '\0' ? "" : " ") << unit;
  return text.str();
}

std::string kilometres(double metres) {
  std::ostringstream text;
  text << metres / 1000.0 << " km";
  return text.str();
}

std::string farOff(const char* name, double value, double farthest) {
  if (isWithin(value, farthest)) return "";
  if (!std::isfinite(value)) return std::string(name) + " is no finite number";
  return named(name, value, "m") + " is more than " + kilometres(farthest) + " from the map's origin";
}

}  // namespace

std::string implausibilityOf(const Pose2& T_map_base, double farthest) {
  for (const auto& [name, value] : {std::pair("x", T_map_base.x), {"y", T_map_base.y}}) {
    if (std::string words = farOff(name, value, farthest); !words.empty()) return words;
  }
  if (isWithin(T_map_base.theta, kPlausible.turn)) return "";
  if (!std::isfinite(T_map_base.theta)) return "theta is no finite number";
  return named("theta", T_map_base.theta, "rad") + " is more than a full turn";
}

std::string implausibilityOfResolution(double resolution) {
  if (resolution >= kPlausible.finest && resolution <= kPlausible.coarsest) return "";
  std::ostringstream text;
  text << "its resolution of " << resolution << " m for a cell is not between " << kPlausible.finest << " m and "
       << kPlausible.coarsest << " m";
  return text.str();
}

std::string implausibilityOfSize(std::int64_t width, std::int64_t height) {
  if (width > 0 && height > 0 && width <= kPlausible.picture_cells / height) return "";
  return "its " + std::to_string(width) + " x " + std::to_string(height) + " cells are not 1 to " +
         std::to_string(kPlausible.picture_cells) + " in all";
}

std::string implausibilityOfPicture(double resolution, double x, double y, std::int64_t width, std::int64_t height) {
  if (std::string words = implausibilityOfResolution(resolution); !words.empty()) return words;
  const double right = x + static_cast<double>(width) * resolution, top = y + static_cast<double>(height) * resolution;
  for (const auto& [name, value] :
       {std::pair("left edge x", x), {"lower edge y", y}, {"right edge x", right}, {"upper edge y", top}}) {
    if (std::string words = farOff(name, value, kPlausible.farthest); !words.empty()) return "its " + words;
  }
  return implausibilityOfSize(width, height);
}

}  // namespace slam
