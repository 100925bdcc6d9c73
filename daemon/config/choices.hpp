// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "bus/drive_senders.hpp"
#include "estimation/base_kinematics.hpp"
#include "firmware_if/can_frame.hpp"
#include "mapping/occupancy_grid.hpp"
#include "matching/match_result.hpp"

/// Keys that take one of a few words. Code compares the enumerators; only the file spells the words.
namespace slam {

enum class RunMode : std::uint8_t { kSlam, kLocalise };
/// A lidar that slamd reads, by its model where several makes differ (drivers/lidar/lidar_facts.cpp has their rows), or
/// where else scans come from.
enum class LidarDriver : std::uint8_t {
  kRplidar,
  kLd06,
  kLd19,
  kStl19p,
  kStl27l,
  kMs200,
  kLds02,
  kYdlidarX2,
  kYdlidarX4,
  kYdlidarX4Pro,
  kYdlidarG2,
  kYdlidarG4,
  kYdlidarTmini,
  kCoinD4,
  kLds01,
  kXv11,
  kRoborock,
  kCamsenseX1,
  kHokuyo,
  kSick,
  kAuto,
  kYdlidar,  ///< as kAuto: which one of the family answers
  kLds,      ///< that of LdsModel, or the same
  kLcm,
  kNone
};
/// Which of the family of lidar.driver = "lds". No search tells an XV-11 from a Roborock, and an LDS-01 waits for its
/// start.
enum class LdsModel : std::uint8_t { kAuto, kLds01, kLds02, kXv11, kRoborock };
enum class LidarScanMode : std::uint8_t { kAuto, kExpress, kStandard };
/// A base that slamd reads (drivers/base/base_facts.cpp has the rows of those at a serial port, but for the HandsFree
/// board), or where else the wheels' angles come from.
enum class BaseDriver : std::uint8_t {
  kHandsfree,
  kRosArduinoBridge,
  kCreate2,
  kKobuki,
  kFrame,
  kRoboclaw,
  kOpencr,
  kVesc,
  kCan,
  kLcm,
  kNone
};
enum class ImuDriver : std::uint8_t { kHandsfree, kBase, kHfi, kBno08x, kWitmotion, kXsens, kIio, kCan, kLcm, kNone };
enum class DepthDriver : std::uint8_t { kOpenni2, kLcm, kNone };
enum class LogContent : std::uint8_t { kRaw, kAll };
/// Who may look at the page: anybody, or who has the token.
enum class WebReaders : std::uint8_t { kAnybody, kToken };

/// The words of an enum that a key takes, by enumerator.
template <typename Enum>
inline constexpr std::array<const char*, 0> kWords{};
template <>
inline constexpr std::array kWords<RunMode>{"slam", "localise"};
template <>
inline constexpr std::array kWords<LidarDriver>{
    "rplidar",    "ld06",           "ld19",       "stl19p",     "stl27l",         "ms200",   "lds02", "ydlidar-x2",
    "ydlidar-x4", "ydlidar-x4-pro", "ydlidar-g2", "ydlidar-g4", "ydlidar-t-mini", "coin-d4", "lds01", "xv11",
    "roborock",   "camsense-x1",    "hokuyo",     "sick",       "auto",           "ydlidar", "lds",   "lcm",
    "none"};
template <>
inline constexpr std::array kWords<LdsModel>{"auto", "lds01", "lds02", "xv11", "roborock"};
template <>
inline constexpr std::array kWords<LidarScanMode>{"auto", "express", "standard"};
template <>
inline constexpr std::array kWords<BaseDriver>{"handsfree", "text", "create", "kobuki", "frame", "roboclaw",
                                               "opencr",    "vesc", "can",    "lcm",    "none"};
template <>
inline constexpr std::array kWords<can::Protocol>{"odrive", "vesc"};
template <>
inline constexpr std::array kWords<BaseType>{"differential", "omni3", "mecanum4"};
template <>
inline constexpr std::array kWords<DriveOrder>{"first", "last"};
template <>
inline constexpr std::array kWords<WebReaders>{"anybody", "token"};
template <>
inline constexpr std::array kWords<ImuDriver>{"handsfree", "base", "hfi", "bno08x", "witmotion",
                                              "xsens",     "iio",  "can", "lcm",    "none"};
template <>
inline constexpr std::array kWords<DepthDriver>{"openni2", "lcm", "none"};
template <>
inline constexpr std::array kWords<Fusion>{"layers", "paper"};
template <>
inline constexpr std::array kWords<MatchMethod>{"plicp", "icp"};
template <>
inline constexpr std::array kWords<LogContent>{"raw", "all"};

template <typename Enum>
concept Chosen = std::is_enum_v<Enum> && !kWords<Enum>.empty();

/// The word that the file has for a value.
template <Chosen Enum>
constexpr const char* wordOf(Enum value) {
  return kWords<Enum>[static_cast<std::size_t>(value)];
}

}  // namespace slam
