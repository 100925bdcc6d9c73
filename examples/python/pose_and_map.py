#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints slamd's pose twice a second, and keeps its map as a picture (PGM: dark walls, light free space, grey unknown).

Usage: pose_and_map.py [MAP.pgm]"""
import os
import sys

from slam_lcm import MapMeta, MapTile, Pose, Receiver

STATES = ("initialising", "localised", "degraded", "lost")
PERIOD = 500_000  # [us] between printed poses
UNKNOWN = 128     # grey


def write_map(path, meta, tiles):
    """Joins the tiles. Row 0 of a picture is at its top, row 0 of the map at its bottom."""
    side = meta.tile_side
    columns = meta.column_max - meta.column_min + 1
    rows = meta.row_max - meta.row_min + 1
    picture = bytearray([UNKNOWN]) * (columns * side * rows * side)
    for (column, row), tile in tiles.items():
        if not (meta.column_min <= column <= meta.column_max and meta.row_min <= row <= meta.row_max):
            continue  # came after the map grew, before its new geometry
        grey = bytes(UNKNOWN if cell == 255 else 255 - 255 * min(cell, 100) // 100 for cell in tile.cells)
        for line in range(side):
            top = (meta.row_max - row) * side + side - 1 - line
            at = top * columns * side + (column - meta.column_min) * side
            picture[at:at + side] = grey[line * side:(line + 1) * side]
    with open(path + ".new", "wb") as file:
        file.write(b"P5\n%d %d\n255\n" % (columns * side, rows * side) + picture)
    os.replace(path + ".new", path)  # whoever shows the picture never sees half of it


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else None
    map_id, tiles, printed = None, {}, 0
    for message in Receiver().messages():
        if isinstance(message, Pose):
            if abs(message.utime - printed) < PERIOD:
                continue
            printed = message.utime
            state = STATES[message.state] if message.state < len(STATES) else "unknown"
            sigma = max(message.covariance[0], message.covariance[4]) ** 0.5
            print(f"{state}: x {message.x:.3f} m, y {message.y:.3f} m, theta {message.theta:.3f} rad, "
                  f"sigma {sigma:.3f} m", flush=True)
        elif message.map_id != map_id:  # another map has begun: tiles of the last one are none of it
            map_id, tiles = message.map_id, {}
        if isinstance(message, MapTile):
            tiles[message.column, message.row] = message
        elif isinstance(message, MapMeta) and message.tiles and tiles and path:
            write_map(path, message, tiles)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
