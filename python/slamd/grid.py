# SPDX-License-Identifier: BSD-3-Clause
"""The occupancy map of slamd's tiles."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .messages import MapMeta, MapTile

if TYPE_CHECKING:
    import numpy

UNKNOWN = 255
MOST_CELLS = 1 << 26  # of a map; more is a damaged message


@dataclass(frozen=True)
class Map:
    """A whole map. Cells are row by row from the lower left: occupancy in percent 0..100, 255 unknown."""
    utime: int          #: [us since the epoch] of the newest keyframe in it
    map_id: int         #: changes when the map frame starts anew
    resolution: float   #: [m] side of a cell
    x: float            #: [m] lower left corner of the first cell, in map
    y: float            #: [m]
    width: int          #: [cells]
    height: int         #: [cells]
    cells: bytes

    def array(self) -> numpy.ndarray[Any, Any]:
        """The cells as numpy's uint8, height x width; row 0 is the lowest. @raises ImportError: without numpy"""
        import numpy
        return numpy.frombuffer(self.cells, numpy.uint8).reshape(self.height, self.width)

    def occupancy(self, x: float, y: float) -> int | None:
        """Of the cell at x, y [m] in map: 0..100 percent; None: unknown, or outside."""
        column, row = int((x - self.x) // self.resolution), int((y - self.y) // self.resolution)
        if not (0 <= column < self.width and 0 <= row < self.height):
            return None
        cell = self.cells[row * self.width + column]
        return None if cell == UNKNOWN else cell


class MapBuilder:
    """Joins the tiles of the newest map: those of the last one are none of another that has begun."""

    def __init__(self) -> None:
        self._map_id: int | None = None
        self._tiles: dict[tuple[int, int], MapTile] = {}

    def take(self, message: MapTile | MapMeta) -> None:
        if message.map_id != self._map_id:
            self._map_id, self._tiles = message.map_id, {}
        if isinstance(message, MapTile) and len(message.cells) == message.side ** 2:
            self._tiles[message.column, message.row] = message

    def joined(self, meta: MapMeta) -> Map | None:
        """The map whose geometry this is. @return None: no tile of it has come yet, or the geometry is none"""
        side = meta.tile_side
        width, height = (meta.column_max - meta.column_min + 1) * side, (meta.row_max - meta.row_min + 1) * side
        if not (meta.tiles > 0 and self._tiles and 0 < width and 0 < height and width * height <= MOST_CELLS):
            return None
        cells = bytearray([UNKNOWN]) * (width * height)
        for (column, row), tile in self._tiles.items():
            inside = meta.column_min <= column <= meta.column_max and meta.row_min <= row <= meta.row_max
            if not inside or tile.side != side:
                continue  # came after the map grew, before its new geometry
            for line in range(side):
                at = ((row - meta.row_min) * side + line) * width + (column - meta.column_min) * side
                cells[at:at + side] = tile.cells[line * side:(line + 1) * side]
        metres = side * meta.resolution
        return Map(meta.utime, meta.map_id, meta.resolution, meta.origin[0] + meta.column_min * metres,
                   meta.origin[1] + meta.row_min * metres, width, height, bytes(cells))
