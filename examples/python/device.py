#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A device of your own for slamd: sends scans, wheels and a gyro, each with its own stamps.

The readings come from a simulated robot that drives a circle in an L-shaped room; put your device's in their place. slamd
runs beside it with lidar.driver, base.driver and imu.driver = "lcm".
Usage: device.py [SECONDS]; needs python3-slamd, or its folder python/ in PYTHONPATH"""
import math
import sys
import time

import slamd

# Corners of the room [m]; the robot starts at (0, 0) and looks along x.
ROOM = [(-2.5, -1.0), (3.0, -1.0), (3.0, 3.5), (0.8, 3.5), (0.8, 2.7), (-2.5, 2.7)]
SPEED, TURN_RATE = 0.3, 0.3  # [m/s], [rad/s]
TICK = 0.02                  # [s] of wheels and gyro
SCAN_TIME, BEAMS = 0.1, 360  # [s], [1] of a turn of the lidar


def pose_at(t):
    """Where the robot is t seconds after the start: x [m], y [m], theta [rad]."""
    theta = TURN_RATE * t
    radius = SPEED / TURN_RATE
    return radius * math.sin(theta), radius * (1.0 - math.cos(theta)), theta


def range_from(x, y, angle):
    """From a place to the nearest wall in a direction [m]."""
    dx, dy = math.cos(angle), math.sin(angle)
    nearest = math.inf
    for (ax, ay), (bx, by) in zip(ROOM, ROOM[1:] + ROOM[:1]):
        ex, ey = bx - ax, by - ay
        across = dx * ey - dy * ex
        if abs(across) < 1e-9:
            continue  # parallel
        along = ((ax - x) * ey - (ay - y) * ex) / across
        share = ((ax - x) * dy - (ay - y) * dx) / across
        if along > 0.0 and 0.0 <= share <= 1.0:
            nearest = min(nearest, along)
    return nearest


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else math.inf
    send = slamd.Sender()
    start = time.time()
    turn = []  # beams of the turn under way: range, bearing, time offset
    turn_began = t = 0.0
    while t < seconds:
        time.sleep(max(0.0, start + t + TICK - time.time()))
        # The lidar has turned on since the last tick; each beam starts where the robot was at its own time.
        for _ in range(round(BEAMS * TICK / SCAN_TIME)):
            offset = SCAN_TIME * len(turn) / BEAMS
            bearing = 2.0 * math.pi * len(turn) / BEAMS - math.pi
            x, y, theta = pose_at(turn_began + offset)
            turn.append((range_from(x, y, theta + bearing), bearing, offset))
        t += TICK
        stamp = round(1e6 * (start + t))
        send.wheels(stamp, *pose_at(t))
        send.imu(stamp, (0.0, 0.0, TURN_RATE))
        if len(turn) == BEAMS:
            ranges, bearings, offsets = zip(*turn)
            send.scan(round(1e6 * (start + turn_began)), ranges, bearings, offsets, range_min=0.1, range_max=12.0)
            turn, turn_began = [], t
    print("at the end: x %.3f m, y %.3f m, theta %.3f rad from the start" % pose_at(t))


if __name__ == "__main__":
    main()
