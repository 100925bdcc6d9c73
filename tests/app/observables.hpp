// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "config/config.hpp"

/// What a configuration makes of slamd, in text: two texts differ where a key has an effect.
namespace slam::test {

using Observable = std::string (*)(const Config&);

// What slam-replay makes of a short log: poses, map, counters; or its refusal.
std::string drive(const Config& config);           ///< wheels, gyro, lidar and depth in a furnished room
std::string driveWithoutGyro(const Config&);       ///< the same, by wheels and lidar
std::string roughDrive(const Config& config);      ///< slipping wheels, sensors that fall silent, late samples
std::string spinningWheels(const Config& config);  ///< wheels that spin for long; at the end the robot is pushed aside
std::string kidnapped(const Config& config);       ///< lifted from one end of a ring of corridors to another place
std::string ringDrive(const Config& config);       ///< once around the ring and on, with wheels alone in between
std::string states(const Config& config);          ///< what a FrontEnd says at each step of the rough drive

// What a back end makes of simulated keyframes, and what is believed of wheels that slip for a while.
std::string backEnd(const Config& config);      ///< more than once around the ring
std::string movedRoom(const Config& config);    ///< a room that was moved aside while the robot was away
std::string lostBackEnd(const Config& config);  ///< once around, then from an unknown place of the ring on
std::string wheelTrust(const Config& config);

// What is handed to drivers, threads and the front end.
std::string boardSettings(const Config& config);
std::string baseSettings(const Config& config);  ///< of a base of the table
std::string canSettings(const Config& config);
std::string imuSettings(const Config& config);
std::string lidarSettings(const Config& config);
std::string cameraSettings(const Config& config);
std::string threads(const Config& config);
std::string projection(const Config& config);  ///< pseudo-laser of rendered images
std::string keeping(const Config& config);     ///< which map is kept and when it is written
std::string savedMap(const Config& config);    ///< whether the mapper thread leaves map files

}  // namespace slam::test
