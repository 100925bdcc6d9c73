#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints slamd's pose twice a second, and keeps its map as a picture (PGM: dark walls, light free space, grey unknown).

Usage: pose_and_map.py [MAP.pgm]; needs python3-slamd, or its folder python/ in PYTHONPATH"""
import os
import sys

import slamd

PERIOD = 500_000  # [us] between printed poses
UNKNOWN = 128     # grey


GREYS = bytes(UNKNOWN if cell == 255 else 255 - 255 * min(cell, 100) // 100 for cell in range(256))


def write_map(path, width, height, cells):
    """Row 0 of a picture is at its top, row 0 of the map at its bottom."""
    picture = cells.translate(GREYS)
    with open(path + ".new", "wb") as file:
        file.write(b"P5\n%d %d\n255\n" % (width, height))
        for row in reversed(range(height)):
            file.write(picture[row * width:(row + 1) * width])
    os.replace(path + ".new", path)  # whoever shows the picture never sees half of it


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else None
    known, printed = slamd.MapBuilder(), 0
    for message in slamd.Receiver().messages():
        if isinstance(message, slamd.PoseEstimate):
            if abs(message.utime - printed) < PERIOD:
                continue
            printed = message.utime
            sigma = max(message.covariance[0], message.covariance[4]) ** 0.5
            print(f"{slamd.state_of(message)}: x {message.x:.3f} m, y {message.y:.3f} m, theta {message.theta:.3f} rad, "
                  f"sigma {sigma:.3f} m", flush=True)
        elif isinstance(message, (slamd.MapTile, slamd.MapMeta)):
            known.take(message)
            joined = known.joined(message) if path and isinstance(message, slamd.MapMeta) else None
            if joined:
                write_map(path, joined.width, joined.height, joined.cells)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
