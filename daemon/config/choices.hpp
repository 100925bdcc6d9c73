// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "bus/drive_senders.hpp"
#include "estimation/base_kinematics.hpp"
#include "mapping/occupancy_grid.hpp"
#include "matching/match_result.hpp"

/// Keys that take one of a few words. Code compares the enumerators; only the file spells the words.
namespace slam {

enum class RunMode : std::uint8_t { kSlam, kLocalise };
enum class LidarDriver : std::uint8_t { kRplidar, kLcm, kNone };
enum class LidarScanMode : std::uint8_t { kAuto, kExpress, kStandard };
enum class BaseDriver : std::uint8_t { kHandsfree, kCan, kLcm, kNone };
enum class ImuDriver : std::uint8_t { kHandsfree, kHfi, kCan, kLcm, kNone };
enum class DepthDriver : std::uint8_t { kOpenni2, kLcm, kNone };
enum class LogContent : std::uint8_t { kRaw, kAll };

/// One enumerator and its word.
template <typename Enum>
struct Choice {
  Enum value;
  const char* word;
};

/// All words of an enum, in the order in which they are offered.
template <typename Enum>
inline constexpr std::array<Choice<Enum>, 0> kChoices{};

template <>
inline constexpr std::array<Choice<RunMode>, 2> kChoices<RunMode>{
    {{RunMode::kSlam, "slam"}, {RunMode::kLocalise, "localise"}}};
template <>
inline constexpr std::array<Choice<LidarDriver>, 3> kChoices<LidarDriver>{
    {{LidarDriver::kRplidar, "rplidar"}, {LidarDriver::kLcm, "lcm"}, {LidarDriver::kNone, "none"}}};
template <>
inline constexpr std::array<Choice<LidarScanMode>, 3> kChoices<LidarScanMode>{
    {{LidarScanMode::kAuto, "auto"}, {LidarScanMode::kExpress, "express"}, {LidarScanMode::kStandard, "standard"}}};
template <>
inline constexpr std::array<Choice<BaseDriver>, 4> kChoices<BaseDriver>{{{BaseDriver::kHandsfree, "handsfree"},
                                                                         {BaseDriver::kCan, "can"},
                                                                         {BaseDriver::kLcm, "lcm"},
                                                                         {BaseDriver::kNone, "none"}}};
template <>
inline constexpr std::array<Choice<BaseType>, 3> kChoices<BaseType>{
    {{BaseType::kDifferential, "differential"}, {BaseType::kOmni3, "omni3"}, {BaseType::kMecanum4, "mecanum4"}}};
template <>
inline constexpr std::array<Choice<DriveOrder>, 2> kChoices<DriveOrder>{
    {{DriveOrder::kFirst, "first"}, {DriveOrder::kLast, "last"}}};
template <>
inline constexpr std::array<Choice<ImuDriver>, 5> kChoices<ImuDriver>{{{ImuDriver::kHandsfree, "handsfree"},
                                                                       {ImuDriver::kHfi, "hfi"},
                                                                       {ImuDriver::kCan, "can"},
                                                                       {ImuDriver::kLcm, "lcm"},
                                                                       {ImuDriver::kNone, "none"}}};
template <>
inline constexpr std::array<Choice<DepthDriver>, 3> kChoices<DepthDriver>{
    {{DepthDriver::kOpenni2, "openni2"}, {DepthDriver::kLcm, "lcm"}, {DepthDriver::kNone, "none"}}};
template <>
inline constexpr std::array<Choice<Fusion>, 2> kChoices<Fusion>{
    {{Fusion::kLayers, "layers"}, {Fusion::kPaper, "paper"}}};
template <>
inline constexpr std::array<Choice<MatchMethod>, 2> kChoices<MatchMethod>{
    {{MatchMethod::kPointToLine, "plicp"}, {MatchMethod::kPointToPoint, "icp"}}};
template <>
inline constexpr std::array<Choice<LogContent>, 2> kChoices<LogContent>{
    {{LogContent::kRaw, "raw"}, {LogContent::kAll, "all"}}};

template <typename Enum>
concept Chosen = std::is_enum_v<Enum> && !kChoices<Enum>.empty();

/// The word that the file has for a value.
template <Chosen Enum>
constexpr const char* wordOf(Enum value) {
  for (const Choice<Enum>& choice : kChoices<Enum>)
    if (choice.value == value) return choice.word;
  return "";
}

}  // namespace slam
