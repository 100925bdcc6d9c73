// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "problems/problem.hpp"

/// The table of problems: mounting, signs and sight of the sensors. Numbers: as SensorFault has them, shares in
/// percent.
namespace slam::problem {

inline constexpr ProblemKind kLidarUpsideDown{"lidar_upside_down", "the lidar turns opposite to gyro and wheels", "",
                                              "is it mounted upside down? change lidar.upside_down"};
inline constexpr ProblemKind kLidarAgainstGyro{
    "lidar_against_gyro", "lidar and gyro turn in opposite directions", "",
    "is the lidar upside down (change lidar.upside_down), or does the gyro's z axis point down?"};
inline constexpr ProblemKind kLidarAgainstWheels{
    "lidar_against_wheels", "lidar and wheels turn in opposite directions", "",
    "is the lidar upside down (change lidar.upside_down), or are left and right wheel swapped?"};
inline constexpr const char* kWithoutGyro = "slamd goes on without it";
inline constexpr ProblemKind kGyroReversed{"gyro_reversed",
                                           "the gyro turns opposite to lidar and wheels: does its z axis point down?",
                                           kWithoutGyro, "turn the IMU over, or let its driver negate z"};
inline constexpr ProblemKind kWheelsSwapped{"wheels_swapped",
                                            "the wheels turn opposite to the lidar but drive the same way", "",
                                            "are left and right swapped?"};
inline constexpr ProblemKind kWheelsBackwards{"wheels_backwards", "the wheels drive and turn opposite to the lidar", "",
                                              "do both count backwards?"};
inline constexpr ProblemKind kLidarYawOff{
    "lidar_yaw_off", "the lidar travels in another direction than the wheels", "",
    "is it turned on its mount? add {#0.2} rad to lidar.yaw, or look whether the wheels drive backwards"};
inline constexpr ProblemKind kWheelDistanceOff{"wheel_distance_off",
                                               "the wheels report {#0} % of the distance that the scans show", "",
                                               "check base.wheel_radius (slam-calibrate)"};
inline constexpr ProblemKind kWheelTurnOff{"wheel_turn_off",
                                           "the wheels report {#0} % of the turns that the scans show", "",
                                           "check base.half_track (slam-calibrate)"};
inline constexpr ProblemKind kWheelsContradict{"wheels_contradict", "wheels and scans do not move together", "",
                                               "do the wheels slip or stall, or belong to another clock?"};
inline constexpr ProblemKind kScansRepeated{"scans_repeated", "{#0} scans repeat the one before them", "",
                                            "is a driver or a recorder sending twice, or the lidar stuck?"};
inline constexpr ProblemKind kTimeBackwards{"time_backwards", "{#0} scans are stamped before the one before them", "",
                                            "was a clock set, or are records out of order?"};
inline constexpr ProblemKind kLidarMountOff{
    "lidar_mount_off", "lidar and wheels turn about different centres", "the pose is off by as much",
    "add {#0.2} m to lidar.x and {#1.2} m to lidar.y, or measure it with slam-calibrate"};
inline constexpr ProblemKind kGyroDegrees{"gyro_degrees", "the gyro reports {#0} % of the turns: degrees for radians?",
                                          kWithoutGyro, "let its driver send rad/s"};
inline constexpr ProblemKind kGyroTurnOff{"gyro_turn_off", "the gyro reports {#0} % of the turns of lidar and wheels",
                                          kWithoutGyro, "set its range and unit in its driver"};
inline constexpr ProblemKind kGyroOffset{"gyro_offset", "the gyro reads {#0.3} rad/s at rest", "slamd takes that off",
                                         "keep the robot still while its driver or board calibrates it"};
inline constexpr ProblemKind kGyroFarOff{
    "gyro_far_off", "the gyro reads {#0.3} rad/s at rest, too much for a bias", kWithoutGyro,
    "keep the robot still while its driver or board calibrates it, else replace it"};
inline constexpr ProblemKind kGyroClipped{"gyro_clipped",
                                          "the gyro never reads more than {#0.3} rad/s though the robot turns faster",
                                          "there slamd turns by the wheels", "set a larger range in its driver"};
inline constexpr ProblemKind kGyroContradicts{
    "gyro_contradicts", "the gyro does not turn with lidar and wheels", kWithoutGyro,
    "mount it firmly with its z axis upright, and let one clock stamp it and the wheels"};
inline constexpr ProblemKind kMovesWithRobot{
    "moves_with_robot", "lidar: {#0} degrees about {#1} degrees end on what moves with the robot", "these are left out",
    "mount the lidar free of it, or name them in lidar.mask"};
inline constexpr ProblemKind kNoReturnCodes{
    "no_return_codes", "lidar: beams share a range of {#0.3} m wherever the robot is ({#1} such values)",
    "which is taken for no return", "let its driver send 0"};
inline constexpr ProblemKind kRangesScatter{"ranges_scatter", "lidar: its ranges scatter by {#0.2} m at rest",
                                            "slamd goes on without its scans until a rest shows less",
                                            "clean its window, keep sunlight off it, else replace it"};
inline constexpr ProblemKind kBeamTimesMissing{
    "beam_times_missing", "lidar: the scans carry no beam times though its head turns",
    "slamd spreads the beams over the turn", "let its driver send time offsets"};

inline constexpr ProblemKind kStampsAlone{"stamps_alone", "{#0} samples are stamped far ahead of all others",
                                          "they are left out",
                                          "look after the clock of the program or driver that stamps them"};

inline constexpr ProblemKind kWheelsDead{
    "wheels_dead", "the wheels report that they stand, but scans show that the robot moves",
    "the pose goes by lidar and gyro", "was it pushed or carried? else check the plugs of the encoders"};

inline constexpr ProblemKind kLidarDelay{
    "lidar_delay", "the lidar's stamps are off the gyro's by {#0.3} s (sigma {#1.3} s)", "slamd adds that to them",
    "add it to lidar.time_offset, or let its driver stamp the first beam"};

inline constexpr const char* kWithoutScans = "slamd goes on without scans";
inline constexpr ProblemKind kNoEcho{
    "no_echo",
    "no echo in any direction: nothing stands within the lidar's range, as in a wide hall, or its window is covered or "
    "its "
    "laser off",
    kWithoutScans,
    "drive to where walls are within range, else take the cover off, clean the window, or replace the lidar"};
inline constexpr ProblemKind kEchoesNear{"echoes_near", "no echo beyond range_min, only nearer ones: cover on?",
                                         kWithoutScans,
                                         "take off what is before the lidar, or set lidar.range_min in metres"};
inline constexpr ProblemKind kEchoesFar{"echoes_far",
                                        "no echo within range_max, only ranges beyond it: are they in millimetres?",
                                        kWithoutScans, "send metres, or set lidar.range_max"};

}  // namespace slam::problem
