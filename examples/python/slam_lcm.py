# SPDX-License-Identifier: BSD-3-Clause
"""slamd's messages over a UDP socket: what a program without LCM needs to send sensors and to read pose and map.

A datagram is b"LC02", a sequence number, the channel's name with a zero byte behind it, the fingerprint of the message's
type, and its fields in the order of its .lcm file (/usr/share/slamd/lcmtypes), big-endian without padding. Stamps are
microseconds since the epoch, all else SI units; axes are x forward, y left, angles counter-clockwise."""
import socket
import struct
from collections import namedtuple

GROUP = ("239.255.76.67", 7667)
LOCALHOST = "127.0.0.1"  # of the interface; on another computer the address of its own network card

SCAN = bytes.fromhex("92b49ccd55ab5bb2")
WHEELS = bytes.fromhex("9d3e3f72b854cb11")
IMU = bytes.fromhex("21291eea3f200253")
POSE = bytes.fromhex("12873a8e138714b8")
ODOMETRY = bytes.fromhex("677053b1a5f3ba4c")
COMMAND = bytes.fromhex("a55376217e534e3a")
DRIVE = bytes.fromhex("479abf67d547708d")
MAP_META = bytes.fromhex("5d03a978dcc50d54")
MAP_TILE = bytes.fromhex("5b0063056a561b49")

Pose = namedtuple("Pose", "utime map_id x y theta covariance twist state match_quality")
Odometry = namedtuple("Odometry", "utime x y theta covariance twist gyro_bias slip standstill map_odom")
Scan = namedtuple("Scan", "utime range_min range_max ranges bearings time_offsets")
MapMeta = namedtuple("MapMeta", "utime map_id resolution origin_x origin_y tile_side "
                     "column_min column_max row_min row_max tiles keyframes")
MapTile = namedtuple("MapTile", "utime map_id column row side cells")


class Sender:
    """Sends sensors to a slamd whose lidar.driver, base.driver and imu.driver are "lcm"."""

    def __init__(self, interface=LOCALHOST):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(interface))
        self._number = 0

    def scan(self, utime, ranges, bearings, time_offsets, range_min=0.0, range_max=0.0):
        """One turn of the lidar, beams in the order of measurement, at most 4080.

        utime: [us] of the first beam, not of the turn's end; ranges: [m], 0 for no return; bearings: [rad] in the lidar's
        frame; time_offsets: [s] from utime to each beam, all 0 where all are measured at once; range_min, range_max: [m],
        0 leaves the limit to slamd's configuration."""
        n = len(ranges)
        message = SCAN + struct.pack(">qffi", utime, range_min, range_max, n)
        for values in (ranges, bearings, time_offsets, [0.0] * n):  # the last are intensities
            message += struct.pack(f">{n}f", *values)
        self._send(b"SLAM_SCAN", message)

    def wheels(self, utime, x, y, theta):
        """Dead reckoning of the wheels, from any origin: only differences count. [us], [m], [m], [rad]"""
        self._send(b"SLAM_WHEELS", WHEELS + struct.pack(">qddd?i", utime, x, y, theta, True, 0))

    def imu(self, utime, gyro, accel=(0.0, 0.0, 0.0)):
        """Turn rates about forward, left, up [rad/s] and specific force [m/s^2], zeros where it is not measured."""
        self._send(b"SLAM_IMU", IMU + struct.pack(">q3d3d", utime, *gyro, *accel))

    def drive(self, utime, forward, left, turn):
        """The speed that the base shall have [m/s, m/s, rad/s]: obeyed with base.speed_commands, for half a second."""
        self._send(b"SLAM_DRIVE", DRIVE + struct.pack(">q3d", utime, forward, left, turn))

    def set_pose(self, utime, number, x, y, theta):
        """Tells where the base is in the map [m, m, rad]: obeyed with lcm.commands. number: comes back in SLAM_ACK."""
        verb = b"set_pose\0"
        self._send(b"SLAM_COMMAND", COMMAND + struct.pack(">qii", utime, number, len(verb)) + verb +
                   struct.pack(">i", 1) + b"\0" + struct.pack(">3d", x, y, theta))

    def _send(self, channel, message):
        self._number = (self._number + 1) % 2**32
        self._socket.sendto(b"LC02" + struct.pack(">I", self._number) + channel + b"\0" + message, GROUP)


class Receiver:
    """Reads what slamd publishes."""

    def __init__(self, interface=LOCALHOST):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 21)
        self._socket.bind(GROUP)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                                socket.inet_aton(GROUP[0]) + socket.inet_aton(interface))

    def messages(self):
        """Yields each message that decode() knows as it comes."""
        while True:
            message = decode(self._socket.recv(65536))
            if message is not None:
                yield message


class Map:
    """The tiles of the newest map: those of the last one are none of another that has begun."""

    def __init__(self):
        self._map_id, self._tiles = None, {}

    def take(self, message):
        """A MapTile or MapMeta."""
        if message.map_id != self._map_id:
            self._map_id, self._tiles = message.map_id, {}
        if isinstance(message, MapTile):
            self._tiles[message.column, message.row] = message

    def joined(self, meta):
        """@return width, height [cells], and the cells row by row from the lower left (255 unknown); None: no tile yet"""
        if not (meta.tiles and self._tiles):
            return None
        side = meta.tile_side
        width = (meta.column_max - meta.column_min + 1) * side
        height = (meta.row_max - meta.row_min + 1) * side
        cells = bytearray(b"\xff") * (width * height)
        for (column, row), tile in self._tiles.items():
            if not (meta.column_min <= column <= meta.column_max and meta.row_min <= row <= meta.row_max):
                continue  # came after the map grew, before its new geometry
            for line in range(side):
                at = ((row - meta.row_min) * side + line) * width + (column - meta.column_min) * side
                cells[at:at + side] = tile.cells[line * side:(line + 1) * side]
        return width, height, cells


def decode(datagram):
    """The Pose, Odometry, Scan, MapMeta or MapTile in a datagram, or None: another message, or a damaged one."""
    if datagram[:4] != b"LC02":
        return None
    channel, zero, message = datagram[8:].partition(b"\0")
    kind, fields = message[:8], message[8:]
    try:
        if channel == b"SLAM_POSE" and kind == POSE:
            values = struct.unpack(">qi3d9d3dBf", fields)
            return Pose(*values[:5], values[5:14], values[14:17], *values[17:])
        if channel == b"SLAM_ODOMETRY" and kind == ODOMETRY:
            values = struct.unpack(">q3d9d3dd??3d", fields)
            return Odometry(*values[:4], values[4:13], values[13:16], *values[16:19], values[19:])
        if channel == b"SLAM_SCAN" and kind == SCAN:
            *values, n = struct.unpack(">qffi", fields[:20])
            if n < 0:
                return None
            floats = struct.unpack(f">{4 * n}f", fields[20:])
            return Scan(*values, floats[:n], floats[n:2 * n], floats[2 * n:3 * n])
        if channel == b"SLAM_MAP_META" and kind == MAP_META:
            return MapMeta(*struct.unpack(">qi3d7i", fields))
        if channel == b"SLAM_MAP_TILE" and kind == MAP_TILE:
            *values, count = struct.unpack(">qi4i", fields[:28])
            return MapTile(*values, fields[28:]) if count == len(fields) - 28 == values[-1] ** 2 else None
    except struct.error:
        pass
    return None
