# SPDX-License-Identifier: BSD-3-Clause
"""slamd from Python: its pose, map, scans and problems, and commands to it. Needs nothing but Python.

    import slamd

    for pose in slamd.poses():
        print(pose.x, pose.y, pose.theta)

    print(slamd.state())                            # State.LOCALISED
    cells = next(slamd.maps()).array()              # numpy, where it is installed
    slamd.Commander().save("kitchen")               # needs the group slamd

Units are SI, angles are radians and counter-clockwise, axes x forward and y left; utime is in microseconds since the
epoch. All functions read slamd of this computer; `interface` is the address of a network card for another one.
"""
from __future__ import annotations

from .client import (LOCALHOST, Receiver, Sender, SilenceError, SlamdError, health, maps, odometry, pose, poses, problems,
                     scans, state)
from .codec import DecodeError, Message
from .commands import SERVICE_SOCKET, Commander, RefusedError, drive, stop
from .grid import Map, MapBuilder
from .messages import (Depth, Health, Imu, MapEdit, MapMeta, MapTile, Odometry, PoseEstimate, Problem, Problems, Scan,
                       Wheels)
from .state import State, is_valid, state_of

__version__ = "0.2.0"
__all__ = ["Commander", "DecodeError", "Depth", "Health", "Imu", "LOCALHOST", "Map", "MapBuilder", "MapEdit", "MapMeta",
           "MapTile", "Message", "Odometry", "PoseEstimate", "Problem", "Problems", "Receiver", "RefusedError",
           "SERVICE_SOCKET", "Scan", "Sender", "SilenceError", "SlamdError", "State", "Wheels", "drive", "health",
           "is_valid", "maps", "odometry", "pose", "poses", "problems", "scans", "state", "state_of", "stop"]
