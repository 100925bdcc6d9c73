// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <slam/ack_t.hpp>
#include <slam/command_t.hpp>
#include <slam/config_t.hpp>
#include <slam/depth_t.hpp>
#include <slam/drive_t.hpp>
#include <slam/health_t.hpp>
#include <slam/imu_t.hpp>
#include <slam/map_edit_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problems_t.hpp>
#include <slam/scan_t.hpp>
#include <slam/wheels_t.hpp>
#include <span>

/// Decoding of datagrams from outside. The decoders that lcm-gen writes trust array and string lengths (a 34-byte
/// message can ask for 2 GiB), so each length is compared with the datagram's size before they run.
namespace slam {

/// @return std::nullopt for a wrong fingerprint, or a size that does not follow from the lengths inside
template <typename Message>
std::optional<Message> decodeChecked(std::span<const std::uint8_t> data);

template <>
std::optional<scan_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<wheels_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<imu_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<depth_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<drive_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<command_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<ack_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<config_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<health_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<problems_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<pose_estimate_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<map_edit_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<odometry_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<map_meta_t> decodeChecked(std::span<const std::uint8_t> data);
template <>
std::optional<map_tile_t> decodeChecked(std::span<const std::uint8_t> data);

}  // namespace slam
