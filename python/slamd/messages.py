# SPDX-License-Identifier: BSD-3-Clause
"""slamd's messages: the types of daemon/lcmtypes as data classes. A test compares each with what lcm-gen makes of it.

Fields that only count another one are left out: its length counts.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from .codec import Message


@dataclass
class Ack(Message):
    """Channel SLAM_ACK: answer to one command_t."""
    #: [us since the epoch]
    utime: int = 0
    #: of the command
    id: int = 0
    accepted: bool = False
    #: what was done, or why not
    message: str = ""

    CHANNEL: ClassVar[str | None] = "SLAM_ACK"
    FINGERPRINT: ClassVar[int] = 0x8283e18dc93e1d69
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("id", "i", None),
        ("accepted", "?", None),
        ("message", "s", None),
    )


@dataclass
class Command(Message):
    """Channel SLAM_COMMAND: a request to slamd; answered on SLAM_ACK. Over LCM only with lcm.commands = true."""
    #: [us since the epoch] of sending
    utime: int = 0
    #: chosen by the sender, comes back in the ack
    id: int = 0
    #: "save", "load", "set_pose", "reset", "mode", "save_map", "log_start", "log_stop", "log_mark", "map_edit",
    #: "map_undo", "map_redo", "map_remove", "map_straighten"
    verb: str = ""
    #: save: name of the copy, or empty for the present map; load: name of the map; mode: slam or localise; log_mark:
    #: what has happened, in a person's words; map_edit: the edit as JSON (docs/api.md); map_remove: its number;
    #: map_straighten: name of the place at the new origin, or empty; others: empty
    argument: str = ""
    #: [m, m, rad] set_pose: T_map_base
    pose: tuple[float, ...] = (0.0, 0.0, 0.0,)

    CHANNEL: ClassVar[str | None] = "SLAM_COMMAND"
    FINGERPRINT: ClassVar[int] = 0xa55376217e534e3a
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("id", "i", None),
        ("verb", "s", None),
        ("argument", "s", None),
        ("pose", "d", 3),
    )


@dataclass
class Config(Message):
    """Channel SLAM_CONFIG, in field logs only: at the beginning of each file, so that one file alone can be replayed.
    """
    #: [us since the epoch] when the file was begun
    utime: int = 0
    #: name of the computer
    host: str = ""
    #: 32 hexadecimal digits, another at each start of the computer; empty: not known
    boot_id: str = ""
    #: as in SLAM_POSE, when the file was begun
    map_id: int = 0
    #: of slamd and of what it runs on, for a person to read
    versions: str = ""
    #: effective one of slamd: TOML, every key; without what is secret
    configuration: str = ""

    CHANNEL: ClassVar[str | None] = "SLAM_CONFIG"
    FINGERPRINT: ClassVar[int] = 0xf13efbc8b9fc80f1
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("host", "s", None),
        ("boot_id", "s", None),
        ("map_id", "i", None),
        ("versions", "s", None),
        ("configuration", "s", None),
    )


@dataclass
class Counter(Message):
    """One counter in health_t."""
    name: str = ""
    #: since start
    value: int = 0

    CHANNEL: ClassVar[str | None] = None
    FINGERPRINT: ClassVar[int] = 0x85bfc43c0b3c07d0
    LAYOUT: ClassVar[tuple] = (
        ("name", "s", None),
        ("value", "q", None),
    )


@dataclass
class Depth(Message):
    """Channel SLAM_DEPTH: a depth image projected to the nearest obstacle per bearing (pseudo-laser), in the depth
    camera's frame levelled to the floor (x forward, y left).
    """
    #: [us since the epoch] of the depth image
    utime: int = 0
    #: [rad] of beam 0, counter-clockwise from x
    bearing_min: float = 0.0
    #: [rad] from one beam to the next
    bearing_step: float = 0.0
    #: [m] along the floor, from the camera
    ranges: Sequence[float] = ()
    #: [m] nearer than this nothing is known; up to the range
    free_from: Sequence[float] = ()
    #: 0 unknown, 1 free up to the range, 2 hit at the range
    kinds: bytes = b""
    #: the beam in whose bearing it lies
    surface_beams: Sequence[int] = ()
    #: [m] along the floor, from the camera
    surface_from: Sequence[float] = ()
    #: [m]
    surface_to: Sequence[float] = ()

    CHANNEL: ClassVar[str | None] = "SLAM_DEPTH"
    FINGERPRINT: ClassVar[int] = 0x98020c9d4847a38b
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("bearing_min", "f", None),
        ("bearing_step", "f", None),
        ("nbeams", "i", None),
        ("ranges", "f", "nbeams"),
        ("free_from", "f", "nbeams"),
        ("kinds", "B", "nbeams"),
        ("nsurfaces", "i", None),
        ("surface_beams", "h", "nsurfaces"),
        ("surface_from", "f", "nsurfaces"),
        ("surface_to", "f", "nsurfaces"),
    )


@dataclass
class DeviceHealth(Message):
    """One device in health_t."""
    #: "lidar", "base", "imu", "depth"
    name: str = ""
    #: 0 absent, 1 opening, 2 streaming, 3 stale, 4 fault
    state: int = 0
    #: in words; empty when all is well
    reason: str = ""
    #: [s] since the last good sample; -1: none yet
    age: float = 0.0
    #: [Hz] of good samples over the last second
    rate: float = 0.0
    #: [Hz]
    expected: float = 0.0
    #: good ones since start
    samples: int = 0
    #: bytes, frames or samples refused since start
    rejects: int = 0

    CHANNEL: ClassVar[str | None] = None
    FINGERPRINT: ClassVar[int] = 0xc9f9af8b1219256a
    LAYOUT: ClassVar[tuple] = (
        ("name", "s", None),
        ("state", "B", None),
        ("reason", "s", None),
        ("age", "d", None),
        ("rate", "d", None),
        ("expected", "d", None),
        ("samples", "q", None),
        ("rejects", "q", None),
    )


@dataclass
class Drive(Message):
    """Channel SLAM_DRIVE: the twist that the base shall have, in base. Obeyed only where base.speed_commands = true, and
    for half a second at most: who drives sends it again and again, at 10 Hz or more. Above base.max_speed or
    base.max_turn_rate all of it is made slower by one factor. A zero of any program stops the base, whatever its
    utime; of several programs that drive, base.drive_order chooses one.
    """
    #: [us since the epoch] of sending
    utime: int = 0
    #: [m/s] forward
    vx: float = 0.0
    #: [m/s] to the left; a differential base leaves it out
    vy: float = 0.0
    #: [rad/s] counter-clockwise
    omega: float = 0.0

    CHANNEL: ClassVar[str | None] = "SLAM_DRIVE"
    FINGERPRINT: ClassVar[int] = 0x479abf67d547708d
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("vx", "d", None),
        ("vy", "d", None),
        ("omega", "d", None),
    )


@dataclass
class StageHealth(Message):
    """Latency of one stage of the pipeline in health_t."""
    #: "match", "scan_to_pose", "map", "tick" ...
    name: str = ""
    #: since start
    count: int = 0
    #: [us] since start
    p50_us: float = 0.0
    #: [us]
    p99_us: float = 0.0
    #: [us]
    max_us: float = 0.0

    CHANNEL: ClassVar[str | None] = None
    FINGERPRINT: ClassVar[int] = 0x6d84cabbb78ee26f
    LAYOUT: ClassVar[tuple] = (
        ("name", "s", None),
        ("count", "q", None),
        ("p50_us", "d", None),
        ("p99_us", "d", None),
        ("max_us", "d", None),
    )


@dataclass
class Health(Message):
    """Channel SLAM_HEALTH, 1 Hz, and at once when a device comes, goes or falls silent: how the daemon is."""
    #: [us since the epoch]
    utime: int = 0
    #: [s]
    uptime: float = 0.0
    #: as pose_estimate_t.state
    localisation: int = 0
    #: one sentence for people
    summary: str = ""
    #: [1] cores in use over the last second
    cpu: float = 0.0
    #: [MB] resident
    memory_mb: float = 0.0
    #: [MB] where maps and records are written, the least; -1: not known
    disk_free_mb: float = 0.0
    devices: Sequence[DeviceHealth] = ()
    stages: Sequence[StageHealth] = ()
    #: ticks, overruns, drops, failed publishes ...
    counters: Sequence[Counter] = ()

    CHANNEL: ClassVar[str | None] = "SLAM_HEALTH"
    FINGERPRINT: ClassVar[int] = 0x736ebfb3e76c6d15
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("uptime", "d", None),
        ("localisation", "B", None),
        ("summary", "s", None),
        ("cpu", "d", None),
        ("memory_mb", "d", None),
        ("disk_free_mb", "d", None),
        ("ndevices", "i", None),
        ("devices", DeviceHealth, "ndevices"),
        ("nstages", "i", None),
        ("stages", StageHealth, "nstages"),
        ("ncounters", "i", None),
        ("counters", Counter, "ncounters"),
    )


@dataclass
class Imu(Message):
    """Channel SLAM_IMU: one reading of the inertial unit in base axes (x forward, y left, z up)."""
    #: [us since the epoch]
    utime: int = 0
    #: [rad/s] counter-clockwise about each axis, bias included
    gyro: tuple[float, ...] = (0.0, 0.0, 0.0,)
    #: [m/s^2] specific force: (0, 0, +9.81) at rest; all 0 where not measured
    accel: tuple[float, ...] = (0.0, 0.0, 0.0,)

    CHANNEL: ClassVar[str | None] = "SLAM_IMU"
    FINGERPRINT: ClassVar[int] = 0x21291eea3f200253
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("gyro", "d", 3),
        ("accel", "d", 3),
    )


@dataclass
class MapEdit(Message):
    """Channel SLAM_MAP_EDITS: one of the edits of the map, as it lies now. All are sent, one message each, when one was
    made or taken back, when the map has moved, and with each refresh of the map; a map that was never edited has
    none.
    """
    #: [us since the epoch] of making it
    utime: int = 0
    #: as in map_meta_t
    map_id: int = 0
    #: counts up with each edit made, undone or removed: what has an older one is outdated
    revision: int = 0
    #: in effect, each in a message of its own; 0: none is, and the fields below say nothing
    edits: int = 0
    #: of this one, from 0
    index: int = 0
    #: from 1, never used twice in a map
    id: int = 0
    #: "erase", "free", "wall", "zone", "room", "place"
    kind: str = ""
    #: of a room or place; others may have none
    name: str = ""
    #: who made it; may be empty
    author: str = ""
    #: [m] in map: corners of an outline, points of a wall, or one spot
    x: Sequence[float] = ()
    y: Sequence[float] = ()
    #: [rad] of a place, in map
    theta: float = 0.0
    #: [m, m, rad] of a place
    sigma: tuple[float, ...] = (0.0, 0.0, 0.0,)

    CHANNEL: ClassVar[str | None] = "SLAM_MAP_EDITS"
    FINGERPRINT: ClassVar[int] = 0x2955526b592d12a6
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("map_id", "i", None),
        ("revision", "i", None),
        ("edits", "i", None),
        ("index", "i", None),
        ("id", "i", None),
        ("kind", "s", None),
        ("name", "s", None),
        ("author", "s", None),
        ("npoints", "i", None),
        ("x", "d", "npoints"),
        ("y", "d", "npoints"),
        ("theta", "d", None),
        ("sigma", "d", 3),
    )


@dataclass
class MapMeta(Message):
    """Channel SLAM_MAP_META: geometry of the map whose tiles are on SLAM_MAP_TILE."""
    #: [us since the epoch] of the newest keyframe in the map
    utime: int = 0
    #: changes when the map frame starts anew
    map_id: int = 0
    #: [m] side of a cell
    resolution: float = 0.0
    #: [m] lower-left corner of cell (0, 0) in map
    origin: tuple[float, ...] = (0.0, 0.0,)
    #: [cells] tile (c, r) begins at cell (c * tile_side, r * tile_side)
    tile_side: int = 0
    #: [tiles] smallest and largest tile column and row in use
    column_min: int = 0
    column_max: int = 0
    row_min: int = 0
    row_max: int = 0
    #: tiles in use; 0: the four fields above say nothing
    tiles: int = 0
    #: drawn into the map
    keyframes: int = 0

    CHANNEL: ClassVar[str | None] = "SLAM_MAP_META"
    FINGERPRINT: ClassVar[int] = 0x5d03a978dcc50d54
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("map_id", "i", None),
        ("resolution", "d", None),
        ("origin", "d", 2),
        ("tile_side", "i", None),
        ("column_min", "i", None),
        ("column_max", "i", None),
        ("row_min", "i", None),
        ("row_max", "i", None),
        ("tiles", "i", None),
        ("keyframes", "i", None),
    )


@dataclass
class MapTile(Message):
    """Channel SLAM_MAP_TILE: one tile of the map, when it has changed and in a full refresh every few seconds. Channels
    SLAM_MAP_LIDAR and SLAM_MAP_DEPTH: its two layers before they become one, of tiles that the depth camera has seen;
    a few at a time, behind it. Of other tiles the lidar's layer is the map.
    """
    #: [us since the epoch] of the newest keyframe in the map
    utime: int = 0
    #: of the map_meta_t it belongs to
    map_id: int = 0
    #: [tiles]
    column: int = 0
    #: [tiles]
    row: int = 0
    #: [cells]
    side: int = 0
    #: row by row from the lower left: occupancy in percent 0..100, 255 unknown
    cells: bytes = b""

    CHANNEL: ClassVar[str | None] = "SLAM_MAP_TILE"
    FINGERPRINT: ClassVar[int] = 0x5b0063056a561b49
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("map_id", "i", None),
        ("column", "i", None),
        ("row", "i", None),
        ("side", "i", None),
        ("ncells", "i", None),
        ("cells", "B", "ncells"),
    )


@dataclass
class Odometry(Message):
    """Channel SLAM_ODOMETRY, 100 Hz: fused wheels and IMU without the lidar. Smooth, drifting, never jumps."""
    #: [us since the epoch] instant that the pose is for
    utime: int = 0
    #: [m] base in odom
    x: float = 0.0
    #: [m]
    y: float = 0.0
    #: [rad] counter-clockwise, -pi..pi
    theta: float = 0.0
    #: of (x, y, theta) in odom, row by row [m^2, m^2, m rad, ..., rad^2]
    covariance: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,)
    #: [m/s, m/s, rad/s] forward, left, counter-clockwise, in base
    twist: tuple[float, ...] = (0.0, 0.0, 0.0,)
    #: [rad/s] reading of the gyro's z axis at rest
    gyro_bias: float = 0.0
    #: wheels contradict the gyro
    slip: bool = False
    standstill: bool = False
    #: [m, m, rad] T_map_odom: T_map_base = T_map_odom * T_odom_base
    map_odom: tuple[float, ...] = (0.0, 0.0, 0.0,)

    CHANNEL: ClassVar[str | None] = "SLAM_ODOMETRY"
    FINGERPRINT: ClassVar[int] = 0x677053b1a5f3ba4c
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("x", "d", None),
        ("y", "d", None),
        ("theta", "d", None),
        ("covariance", "d", 9),
        ("twist", "d", 3),
        ("gyro_bias", "d", None),
        ("slip", "?", None),
        ("standstill", "?", None),
        ("map_odom", "d", 3),
    )


@dataclass
class PoseEstimate(Message):
    """Channel SLAM_POSE, 100 Hz and at once after a scan: pose of base in map."""
    #: [us since the epoch] instant that the pose is for
    utime: int = 0
    #: changes when the map frame starts anew
    map_id: int = 0
    #: [m] base in map
    x: float = 0.0
    #: [m]
    y: float = 0.0
    #: [rad] counter-clockwise, -pi..pi
    theta: float = 0.0
    #: of (x, y, theta) in map, row by row [m^2, m^2, m rad, ..., rad^2]
    covariance: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,)
    #: [m/s, m/s, rad/s] forward, left, counter-clockwise, in base
    twist: tuple[float, ...] = (0.0, 0.0, 0.0,)
    #: 0 initialising, 1 localised, 2 degraded, 3 lost (the pose is then not valid)
    state: int = 0
    #: [1] share of the newest scan's points that met the reference, 0..1
    match_quality: float = 0.0

    CHANNEL: ClassVar[str | None] = "SLAM_POSE"
    FINGERPRINT: ClassVar[int] = 0x12873a8e138714b8
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("map_id", "i", None),
        ("x", "d", None),
        ("y", "d", None),
        ("theta", "d", None),
        ("covariance", "d", 9),
        ("twist", "d", 3),
        ("state", "B", None),
        ("match_quality", "f", None),
    )


@dataclass
class Problem(Message):
    """One problem in problems_t. Programs decide by `id`: its words may become better."""
    #: what it is about: a device of health_t, "pose", "map", "record", "LCM" ...
    device: str = ""
    #: row of slamd's table of problems, such as "port_gone"
    id: str = ""
    #: 1 warning, 2 fault
    level: int = 0
    #: that the words hold, each in its unit there
    numbers: Sequence[float] = ()
    #: that the words hold: paths, names, what the system has answered
    texts: Sequence[str] = ()
    #: what is wrong
    cause: str = ""
    #: what slamd does; may be empty
    meanwhile: str = ""
    #: what a person can do; may be empty
    fix: str = ""

    CHANNEL: ClassVar[str | None] = None
    FINGERPRINT: ClassVar[int] = 0x712d7566aabe4dee
    LAYOUT: ClassVar[tuple] = (
        ("device", "s", None),
        ("id", "s", None),
        ("level", "B", None),
        ("nnumbers", "i", None),
        ("numbers", "d", "nnumbers"),
        ("ntexts", "i", None),
        ("texts", "s", "ntexts"),
        ("cause", "s", None),
        ("meanwhile", "s", None),
        ("fix", "s", None),
    )


@dataclass
class Problems(Message):
    """Channel SLAM_PROBLEMS, before each SLAM_HEALTH: all that is wrong now."""
    #: [us since the epoch]
    utime: int = 0
    problems: Sequence[Problem] = ()

    CHANNEL: ClassVar[str | None] = "SLAM_PROBLEMS"
    FINGERPRINT: ClassVar[int] = 0xced77db58446ba7c
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("nproblems", "i", None),
        ("problems", Problem, "nproblems"),
    )


@dataclass
class Scan(Message):
    """Channel SLAM_SCAN: one turn of the lidar as measured, beams in acquisition order. Input of slamd (source = "lcm")
    and of slam-replay, and what slamd publishes of its own lidar.
    """
    #: [us since the epoch] instant that time_offsets count from: the first beam, where known
    utime: int = 0
    #: [m] shorter returns are not obstacles
    range_min: float = 0.0
    #: [m] longer returns are not trusted; 0: not given, the configured one is the limit
    range_max: float = 0.0
    #: [m]; 0: no return
    ranges: Sequence[float] = ()
    #: [rad] in the lidar's frame, counter-clockwise from its x axis
    bearings: Sequence[float] = ()
    #: [s] from utime to this beam
    time_offsets: Sequence[float] = ()
    #: device units; 0 where the device gives none
    intensities: Sequence[float] = ()

    CHANNEL: ClassVar[str | None] = "SLAM_SCAN"
    FINGERPRINT: ClassVar[int] = 0x92b49ccd55ab5bb2
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("range_min", "f", None),
        ("range_max", "f", None),
        ("nbeams", "i", None),
        ("ranges", "f", "nbeams"),
        ("bearings", "f", "nbeams"),
        ("time_offsets", "f", "nbeams"),
        ("intensities", "f", "nbeams"),
    )


@dataclass
class Wheels(Message):
    """Channel SLAM_WHEELS: dead reckoning of the wheels alone. Only differences count: the origin is arbitrary and a
    lost message loses nothing.
    """
    #: [us since the epoch] when the wheels stood so
    utime: int = 0
    #: [m] base in the wheels' own frame
    x: float = 0.0
    #: [m]
    y: float = 0.0
    #: [rad] counter-clockwise
    theta: float = 0.0
    #: false: the source measures speed only, theta says nothing
    turn_rate_known: bool = False
    #: [rad] accumulated angle of each wheel: left, right, positive driving forward; omni and mecanum bases in the
    #: order and sign of their firmware
    angles: Sequence[float] = ()

    CHANNEL: ClassVar[str | None] = "SLAM_WHEELS"
    FINGERPRINT: ClassVar[int] = 0x9d3e3f72b854cb11
    LAYOUT: ClassVar[tuple] = (
        ("utime", "q", None),
        ("x", "d", None),
        ("y", "d", None),
        ("theta", "d", None),
        ("turn_rate_known", "?", None),
        ("nwheels", "i", None),
        ("angles", "d", "nwheels"),
    )


TYPES: tuple[type[Message], ...] = (
    Ack, Command, Config, Counter, Depth, DeviceHealth, Drive, StageHealth, Health, Imu, MapEdit, MapMeta, MapTile,
    Odometry, PoseEstimate, Problem, Problems, Scan, Wheels,
)
