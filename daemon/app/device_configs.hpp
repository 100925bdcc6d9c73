// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>

#include "config/config.hpp"
#include "core/samples.hpp"
#include "drivers/base/serial_base.hpp"
#include "drivers/board/handsfree_board.hpp"
#include "drivers/camera/openni_camera.hpp"
#include "drivers/can/can_base.hpp"
#include "drivers/imu/iio_imu.hpp"
#include "drivers/imu/serial_imu.hpp"
#include "drivers/lidar/packet_lidar.hpp"
#include "drivers/lidar/rplidar_unit.hpp"
#include "drivers/lidar/scip/scip_unit.hpp"
#include "drivers/lidar/serial_lidar.hpp"
#include "runtime/worker.hpp"

/// What the configuration is to drivers and threads. Pure, so that a test can follow each key to where it ends.
namespace slam {

HandsfreeConfig handsfreeConfig(const Config& config);
/// The row of a base of the table; nullptr: it is none of these.
const BaseFacts* baseFacts(const Config& config);
/// Of one that has a row.
SerialBaseConfig serialBaseConfig(const Config& config);
CanBaseConfig canBaseConfig(const Config& config);
/// Row of imu.driver; nullptr: it is no IMU of its own at a serial port.
const ImuFacts* imuFacts(const Config& config);
SerialImuConfig serialImuConfig(const Config& config);
IioImuConfig iioImuConfig(const Config& config);
SerialLidarConfig serialLidarConfig(const Config& config);
RplidarConfig rplidarConfig(const Config& config);
ScipConfig scipConfig(const Config& config);
/// The row of a lidar that sends packets; nullptr: it is none of these.
const LidarFacts* lidarFacts(const Config& config);
PacketLidarConfig packetLidarConfig(const Config& config);
OpenniConfig openniConfig(const Config& config);

/// R_base_imu of an IMU that slamd reads.
Eigen::Matrix3d imuRotation(const ImuDeviceConfig& imu);
/// @param sample in the IMU's own axes
ImuSample inBase(const Eigen::Matrix3d& R_base_imu, const ImuSample& sample);

WorkerConfig baseWorker(const Config& config);
WorkerConfig lidarWorker(const Config& config);
WorkerConfig depthWorker(const Config& config);
WorkerConfig estimatorWorker(const Config& config);
WorkerConfig poseWorker(const Config& config);
/// Ticks of the estimator from one published pose to the next.
std::uint64_t ticksPerPose(const Config& config);

}  // namespace slam
