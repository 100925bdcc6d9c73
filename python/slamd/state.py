# SPDX-License-Identifier: BSD-3-Clause
"""What slamd is sure of."""
from __future__ import annotations

import enum

from .messages import Health, PoseEstimate


class State(enum.IntEnum):
    """Of the pose."""
    INITIALISING = 0
    LOCALISED = 1
    DEGRADED = 2
    LOST = 3

    def __str__(self) -> str:
        return self.name.lower()


def state_of(message: PoseEstimate | Health) -> State:
    """@raises ValueError: for a state that this version has no name for"""
    return State(message.state if isinstance(message, PoseEstimate) else message.localisation)


def is_valid(pose: PoseEstimate) -> bool:
    """Whether the pose may be used: it is localised or degraded."""
    return pose.state in (State.LOCALISED, State.DEGRADED)
