#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""slamd for ROS 2: one node, which needs rclpy, ROS's own messages and python3-slamd, and no LCM.

Publishes   /tf            map -> odom -> base_link, at the rate of slamd's odometry
            slamd/pose     geometry_msgs/PoseWithCovarianceStamped, while slamd is localised or degraded
            odom           nav_msgs/Odometry: wheels and gyro fused; smooth, never jumps
            map            nav_msgs/OccupancyGrid, kept for late subscribers
            scan           sensor_msgs/LaserScan, as slamd has it
Subscribes  initialpose    geometry_msgs/PoseWithCovarianceStamped -> set_pose (slamd: lcm.commands = true)
            cmd_vel        geometry_msgs/Twist -> speeds of the base (slamd: base.speed_commands = true)
Parameters  interface      address of the network card on which slamd is, 127.0.0.1 for this computer
            lidar_x, lidar_y, lidar_yaw   mount of the lidar, as in slamd's configuration, for the frame "laser"
"""
import math
import threading
import time

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

import slamd

KINDS = slamd.PoseEstimate, slamd.Odometry, slamd.Scan, slamd.MapTile, slamd.MapMeta
MAP_PERIOD = 1.0  # [s] between two maps: one holds all cells
KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE)


def set_stamp(header, utime, frame):
    header.stamp.sec, rest = divmod(utime, 1_000_000)
    header.stamp.nanosec = 1000 * rest
    header.frame_id = frame


def set_heading(quaternion, theta):
    quaternion.z, quaternion.w = math.sin(theta / 2.0), math.cos(theta / 2.0)


def spread(covariance):
    """Of (x, y, theta), row by row, as that of (x, y, z, roll, pitch, yaw)."""
    wide = [0.0] * 36
    for i, row in enumerate((0, 1, 5)):
        for k, column in enumerate((0, 1, 5)):
            wide[6 * row + column] = covariance[3 * i + k]
    return wide


def transform(utime, parent, child, x, y, theta):
    message = TransformStamped()
    set_stamp(message.header, utime, parent)
    message.child_frame_id = child
    message.transform.translation.x, message.transform.translation.y = x, y
    set_heading(message.transform.rotation, theta)
    return message


def even_scan(scan):
    """LaserScan has even bearings: each return goes to the nearest of as many bins as the scan has beams."""
    message = LaserScan()
    beams = max(1, len(scan.ranges))
    set_stamp(message.header, scan.utime, "laser")
    message.angle_min, message.angle_increment = -math.pi, 2.0 * math.pi / beams
    message.angle_max = message.angle_min + message.angle_increment * (beams - 1)
    message.range_min, message.range_max = scan.range_min, scan.range_max or 100.0
    message.scan_time = max(scan.time_offsets, default=0.0)
    ranges = [math.inf] * beams
    for distance, bearing in zip(scan.ranges, scan.bearings):
        if distance > 0.0:
            at = round((bearing - message.angle_min) / message.angle_increment) % beams
            ranges[at] = min(ranges[at], distance)
    message.ranges = ranges
    return message


class Slamd(Node):
    def __init__(self):
        super().__init__("slamd")
        interface = self.declare_parameter("interface", slamd.LOCALHOST).value
        mount = [self.declare_parameter(f"lidar_{name}", 0.0).value for name in ("x", "y", "yaw")]
        self.mount = mount
        self.receiver, self.sender = slamd.Receiver(interface, KINDS), slamd.Sender(interface)
        self.tf = self.create_publisher(TFMessage, "/tf", 10)
        self.pose = self.create_publisher(PoseWithCovarianceStamped, "slamd/pose", 10)
        self.odometry = self.create_publisher(Odometry, "odom", 10)
        self.map = self.create_publisher(OccupancyGrid, "map", KEPT)
        self.scan = self.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
        self.create_subscription(PoseWithCovarianceStamped, "initialpose", self.set_pose, 1)
        self.create_subscription(Twist, "cmd_vel", self.drive, 1)
        self.known, self.changed, self.published = slamd.MapBuilder(), False, 0.0
        self.commands = 0
        self.takers = dict(zip(KINDS, (self.take_pose, self.take_odometry, self.take_scan, self.take_tile, self.take_meta)))

    def read(self):
        """Takes slamd's messages, for ever."""
        for message in self.receiver.messages():
            self.takers[type(message)](message)

    def take_pose(self, pose):
        if not slamd.is_valid(pose):
            return
        message = PoseWithCovarianceStamped()
        set_stamp(message.header, pose.utime, "map")
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        set_heading(message.pose.pose.orientation, pose.theta)
        message.pose.covariance = spread(pose.covariance)
        self.pose.publish(message)

    def take_odometry(self, odometry):
        message = Odometry()
        set_stamp(message.header, odometry.utime, "odom")
        message.child_frame_id = "base_link"
        message.pose.pose.position.x, message.pose.pose.position.y = odometry.x, odometry.y
        set_heading(message.pose.pose.orientation, odometry.theta)
        message.pose.covariance = spread(odometry.covariance)
        message.twist.twist.linear.x, message.twist.twist.linear.y = odometry.twist[:2]
        message.twist.twist.angular.z = odometry.twist[2]
        self.odometry.publish(message)
        self.tf.publish(TFMessage(transforms=[
            transform(odometry.utime, "map", "odom", *odometry.map_odom),
            transform(odometry.utime, "odom", "base_link", odometry.x, odometry.y, odometry.theta),
            transform(odometry.utime, "base_link", "laser", *self.mount)]))

    def take_scan(self, scan):
        self.scan.publish(even_scan(scan))

    def take_tile(self, tile):
        self.known.take(tile)
        self.changed = True

    def take_meta(self, meta):
        self.known.take(meta)
        if not self.changed or time.monotonic() < self.published + MAP_PERIOD:
            return
        joined = self.known.joined(meta)
        if joined is None:
            return
        message = OccupancyGrid()
        set_stamp(message.header, meta.utime, "map")
        message.info.resolution = joined.resolution
        message.info.width, message.info.height = joined.width, joined.height
        message.info.origin.position.x, message.info.origin.position.y = joined.x, joined.y
        message.info.origin.orientation.w = 1.0
        message.data = [cell - 256 if cell > 127 else cell for cell in joined.cells]
        self.map.publish(message)
        self.changed, self.published = False, time.monotonic()

    def set_pose(self, message):
        pose, q = message.pose.pose, message.pose.pose.orientation
        self.commands += 1
        self.sender.set_pose(time.time_ns() // 1000, self.commands, pose.position.x, pose.position.y,
                             2.0 * math.atan2(q.z, q.w))

    def drive(self, message):
        self.sender.drive(time.time_ns() // 1000, message.linear.x, message.linear.y, message.angular.z)


def main():
    rclpy.init()
    node = Slamd()
    threading.Thread(target=node.read, daemon=True).start()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
