# SPDX-License-Identifier: BSD-3-Clause
"""How slamd's messages stand in a datagram.

A datagram is b"LC02", a sequence number, the channel's name with a zero byte behind it, and the message: the fingerprint
of its type, and its fields in the order of its .lcm file, big-endian without padding.
"""
from __future__ import annotations

import dataclasses
import struct
from typing import ClassVar

MAGIC = b"LC02"


class DecodeError(ValueError):
    """The bytes are no message of the type."""


class _Reader:
    def __init__(self, data: bytes):
        self.data, self.at = data, 0

    def take(self, code: str, count: int) -> tuple:
        size = struct.calcsize(code) * count
        if count < 0 or self.at + size > len(self.data):
            raise DecodeError("it ends too soon")
        values = struct.unpack_from(f">{count}{code}", self.data, self.at)
        self.at += size
        return values

    def take_bytes(self, count: int) -> bytes:
        if count < 0 or self.at + count > len(self.data):
            raise DecodeError("it ends too soon")
        self.at += count
        return self.data[self.at - count:self.at]

    def text(self) -> str:
        raw = self.take_bytes(self.take("i", 1)[0])
        if not raw.endswith(b"\0"):
            raise DecodeError("a text has no end")
        return raw[:-1].decode("utf-8", "replace")


class Message:
    """A message of slamd. LAYOUT: name, type and length of each field, in the order of the bytes; a length is None, a
    number, or the name of the field that counts."""

    CHANNEL: ClassVar[str | None] = None
    FINGERPRINT: ClassVar[int] = 0
    LAYOUT: ClassVar[tuple] = ()

    @classmethod
    def decode(cls, data: bytes):
        """@raises DecodeError: for bytes that are no such message"""
        reader = _Reader(bytes(data))
        if reader.take("Q", 1)[0] != cls.FINGERPRINT:
            raise DecodeError(f"not a {cls.__name__}")
        message = cls._read(reader)
        if reader.at != len(reader.data):
            raise DecodeError("more bytes than it has fields")
        return message

    def encode(self) -> bytes:
        """The message with its fingerprint in front."""
        parts = [struct.pack(">Q", self.FINGERPRINT)]
        self._write(parts)
        return b"".join(parts)

    @classmethod
    def _read(cls, reader: _Reader):
        values, counts = {}, {}
        names = {field.name for field in dataclasses.fields(cls)}
        for name, kind, length in cls.LAYOUT:
            count = 1 if length is None else length if isinstance(length, int) else counts[length]
            if not isinstance(kind, str):
                if count < 0 or count > len(reader.data):
                    raise DecodeError("a list is longer than the message")
                value = tuple(kind._read(reader) for _ in range(count))
            elif kind == "s":
                if count < 0 or count > len(reader.data):
                    raise DecodeError("a list is longer than the message")
                value = tuple(reader.text() for _ in range(count))
            elif kind == "B" and length is not None:
                value = reader.take_bytes(count)
            else:
                value = reader.take(kind, count)
            if length is None:
                value = value[0]
            if name in names:
                values[name] = value
            else:
                counts[name] = value
        return cls(**values)

    def _write(self, parts: list[bytes]) -> None:
        counts = {}
        for name, _, length in self.LAYOUT:
            if isinstance(length, str) and counts.setdefault(length, len(getattr(self, name))) != len(getattr(self, name)):
                raise ValueError(f"{name} has another length than the others that {length} counts")
        for name, kind, length in self.LAYOUT:
            value = counts[name] if name in counts else getattr(self, name)
            values = (value,) if length is None else value
            if isinstance(length, int) and len(values) != length:
                raise ValueError(f"{name} needs {length} values")
            if not isinstance(kind, str):
                for one in values:
                    one._write(parts)
            elif kind == "s":
                for one in values:
                    raw = one.encode() + b"\0"
                    parts += [struct.pack(">i", len(raw)), raw]
            elif kind == "B" and length is not None:
                parts.append(bytes(values))
            else:
                parts.append(struct.pack(f">{len(values)}{kind}", *values))


def packed(channel: str, message: Message, number: int) -> bytes:
    """A datagram. number: counts up with each one of a sender."""
    return MAGIC + struct.pack(">I", number % 2**32) + channel.encode() + b"\0" + message.encode()


def unpacked(datagram: bytes, kinds: dict[str, type[Message]]) -> Message | None:
    """The message in a datagram, or None: of a channel that is not in kinds, or damaged."""
    if datagram[:4] != MAGIC:
        return None
    channel, _, data = datagram[8:].partition(b"\0")
    kind = kinds.get(channel.decode("ascii", "replace"))
    if kind is None:
        return None
    try:
        return kind.decode(data)
    except DecodeError:
        return None
