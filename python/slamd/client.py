# SPDX-License-Identifier: BSD-3-Clause
"""LCM over UDP multicast: what slamd publishes, and sensors for it."""
from __future__ import annotations

import socket
import time
from collections.abc import Iterator, Sequence
from typing import TypeVar

from .codec import Message, packed, unpacked
from .grid import Map, MapBuilder
from .messages import (Command, Drive, Health, Imu, MapMeta, MapTile, Odometry, PoseEstimate, Problems, Scan, TYPES, Wheels)
from .state import State, state_of

GROUP = ("239.255.76.67", 7667)
LOCALHOST = "127.0.0.1"  #: of the interface; on another computer the address of its own network card
PATIENCE = 3.0           #: [s] slamd sends its pose at 100 Hz and its health at 1 Hz
RECEIVE_BUFFER = 1 << 21  # [bytes]
LONGEST = 65536          # [bytes] of a datagram

_Kind = TypeVar("_Kind", bound=Message)


class SlamdError(RuntimeError):
    """Cause and fix, in words."""


class SilenceError(SlamdError):
    """Nothing of slamd came in time."""

    def __init__(self, channel: str, timeout: float):
        super().__init__(f"no {channel} came within {timeout:g} s: is slamd running (systemctl status slamd), and lo or the "
                         "network's route for multicast there (slamctl doctor)?")


class Receiver:
    """Reads what slamd publishes. kinds: the types that are wanted; all where it is left out."""

    def __init__(self, interface: str = LOCALHOST, kinds: Sequence[type[Message]] = TYPES):
        self._kinds = {kind.CHANNEL: kind for kind in kinds if kind.CHANNEL}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        self._socket.bind(GROUP)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                                socket.inet_aton(GROUP[0]) + socket.inet_aton(interface))

    def next(self, timeout: float | None = None) -> Message | None:
        """The next message; what is damaged is passed over. timeout: [s], None waits for ever. @return None: none came"""
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0.0:
                return None
            self._socket.settimeout(left)
            try:
                message = unpacked(self._socket.recv(LONGEST), self._kinds)
            except TimeoutError:
                return None
            if message is not None:
                return message

    def messages(self) -> Iterator[Message]:
        """Each message as it comes, for ever."""
        while True:
            message = self.next()
            assert message is not None
            yield message

    def close(self) -> None:
        self._socket.close()

    def __enter__(self) -> Receiver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Sender:
    """Sends sensors to a slamd whose lidar.driver, base.driver and imu.driver are "lcm", and what LCM may command."""

    def __init__(self, interface: str = LOCALHOST):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(interface))
        self._number = 0

    def send(self, message: Message) -> None:
        """On the channel of its type."""
        assert message.CHANNEL is not None
        self._number += 1
        self._socket.sendto(packed(message.CHANNEL, message, self._number), GROUP)

    def scan(self, utime: int, ranges: Sequence[float], bearings: Sequence[float], time_offsets: Sequence[float],
             range_min: float = 0.0, range_max: float = 0.0) -> None:
        """One turn of the lidar, beams in the order of measurement, at most 4080.

        utime: [us] of the first beam, not of the turn's end; ranges: [m], 0 for no return; bearings: [rad] in the lidar's
        frame; time_offsets: [s] from utime to each beam, all 0 where all are measured at once; range_min, range_max: [m],
        0 leaves the limit to slamd's configuration."""
        self.send(Scan(utime, range_min, range_max, ranges, bearings, time_offsets, [0.0] * len(ranges)))

    def wheels(self, utime: int, x: float, y: float, theta: float) -> None:
        """Dead reckoning of the wheels, from any origin: only differences count. [us], [m], [m], [rad]"""
        self.send(Wheels(utime, x, y, theta, True))

    def imu(self, utime: int, gyro: Sequence[float], accel: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Turn rates about forward, left, up [rad/s] and specific force [m/s^2], zeros where it is not measured."""
        self.send(Imu(utime, tuple(gyro), tuple(accel)))

    def drive(self, utime: int, forward: float, left: float, turn: float) -> None:
        """The speed that the base shall have [m/s, m/s, rad/s]: obeyed with base.speed_commands, for half a second."""
        self.send(Drive(utime, forward, left, turn))

    def set_pose(self, utime: int, number: int, x: float, y: float, theta: float) -> None:
        """Where the base is in the map [m, m, rad]: obeyed with lcm.commands. number: comes back in SLAM_ACK."""
        self.send(Command(utime, number, "set_pose", "", (x, y, theta)))


def _each(kind: type[_Kind], interface: str, timeout: float | None) -> Iterator[_Kind]:
    with Receiver(interface, (kind,)) as receiver:
        while True:
            message = receiver.next(timeout)
            if message is None:
                raise SilenceError(str(kind.CHANNEL), timeout or 0.0)
            yield message  # type: ignore[misc]


def poses(interface: str = LOCALHOST, timeout: float | None = None) -> Iterator[PoseEstimate]:
    """Poses of base in map at 100 Hz, valid or not (is_valid()). timeout: [s] None waits for ever.
    @raises SilenceError: after the timeout"""
    return _each(PoseEstimate, interface, timeout)


def odometry(interface: str = LOCALHOST, timeout: float | None = None) -> Iterator[Odometry]:
    """Wheels and gyro fused, at 100 Hz: smooth, drifting, never jumps. @raises as poses()"""
    return _each(Odometry, interface, timeout)


def scans(interface: str = LOCALHOST, timeout: float | None = None) -> Iterator[Scan]:
    """Turns of the lidar as measured. @raises as poses()"""
    return _each(Scan, interface, timeout)


def maps(interface: str = LOCALHOST, timeout: float | None = None) -> Iterator[Map]:
    """The map each time that it has changed. The first one may lack tiles until the next refresh (lcm.map_refresh).
    @raises as poses()"""
    builder, changed = MapBuilder(), False
    with Receiver(interface, (MapMeta, MapTile)) as receiver:
        while True:
            message = receiver.next(timeout)
            if message is None:
                raise SilenceError(str(MapMeta.CHANNEL), timeout or 0.0)
            builder.take(message)  # type: ignore[arg-type]
            changed = changed or isinstance(message, MapTile)
            joined = builder.joined(message) if changed and isinstance(message, MapMeta) else None
            if joined is not None:
                changed = False
                yield joined


def pose(interface: str = LOCALHOST, timeout: float = PATIENCE) -> PoseEstimate:
    """The newest pose, valid or not. @raises SilenceError"""
    return next(poses(interface, timeout))


def state(interface: str = LOCALHOST, timeout: float = PATIENCE) -> State:
    """Whether the robot is found. @raises SilenceError"""
    return state_of(pose(interface, timeout))


def health(interface: str = LOCALHOST, timeout: float = PATIENCE) -> Health:
    """How slamd and its devices are. @raises SilenceError"""
    return next(_each(Health, interface, timeout))


def problems(interface: str = LOCALHOST, timeout: float = PATIENCE) -> Problems:
    """All that is wrong now, each with cause and fix. @raises SilenceError"""
    return next(_each(Problems, interface, timeout))
