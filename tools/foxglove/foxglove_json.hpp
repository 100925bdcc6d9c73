// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <slam/health_t.hpp>
#include <slam/imu_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problem_t.hpp>
#include <slam/wheels_t.hpp>
#include <string>
#include <string_view>

#include "core/pose2.hpp"
#include "tools/foxglove/map_picture.hpp"

/// Single messages in Foxglove's types (docs.foxglove.dev/docs/visualization/message-schemas), and slamd's own where it
/// has none. Times are in microseconds since the epoch. Pure.
namespace slam::foxglove {

/// @param points packed x, y, z [m] and intensity, four float32 for each
nlohmann::json pointCloud(const char* frame, std::int64_t utime, std::string_view points);
nlohmann::json poseInFrame(const char* frame, std::int64_t utime, const Pose2& pose);
nlohmann::json frameTransform(std::int64_t utime, const char* parent, const char* child, const Pose2& pose);
/// One byte a cell: 0 free to 100 occupied, 255 unknown.
nlohmann::json grid(const MapPicture::Picture& map);
/// A problem as a line of the log. @param utime [us since the epoch]
nlohmann::json log(std::int64_t utime, const problem_t& problem);
nlohmann::json estimate(const pose_estimate_t& message);
nlohmann::json wheels(const wheels_t& message);
nlohmann::json imu(const imu_t& message);
nlohmann::json health(const health_t& message);

/// JSON Schema of messages as this one. Viewers know the types of Foxglove by their names.
std::string schemaOf(const std::string& name, const nlohmann::json& message);

}  // namespace slam::foxglove
