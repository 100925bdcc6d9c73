# SPDX-License-Identifier: BSD-3-Clause
"""Commands to slamd, with the rights of slamctl."""
from __future__ import annotations

import json
import os
import socket
import time
from collections.abc import Mapping
from typing import Any

from .client import GROUP, LOCALHOST, LONGEST, Receiver, Sender, SlamdError
from .codec import packed, unpacked
from .messages import Ack, Command

SERVICE_SOCKET = "/run/slamd/socket"  #: of the service; group slamd may open it
ANSWER = 20.0  #: [s] a large map on a slow disk


class RefusedError(SlamdError):
    """slamd has refused a command; its words are the text."""


def _now() -> int:
    return time.time_ns() // 1000


class Commander:
    """Asks slamd to do something, and waits for its answer. Each call @raises RefusedError where slamd refuses it, and
    SlamdError where none answers or who runs this has no right. @return slamd's words for what was done

    socket: the file of runtime.socket; None: over LCM, which slamd obeys with lcm.commands = true. interface: of LCM."""

    def __init__(self, socket: str | None = SERVICE_SOCKET, interface: str = LOCALHOST, timeout: float = ANSWER):
        self._path, self._interface, self._timeout = socket, interface, timeout

    def save(self, name: str = "") -> str:
        """Stores the map now; with a name, a copy under it."""
        return self.ask("save", name)

    def load(self, name: str) -> str:
        """Stores the present map and goes on in another one."""
        return self.ask("load", name)

    def reset(self) -> str:
        """Stores the present map and begins a new one."""
        return self.ask("reset")

    def set_pose(self, x: float, y: float, theta: float) -> str:
        """Where the base is in the map [m, m, rad]."""
        return self.ask("set_pose", "", (x, y, theta))

    def localise(self) -> str:
        """In the present map, which stays as it is, until slamd is started anew."""
        return self.ask("mode", "localise")

    def slam(self) -> str:
        """Localises, and extends the map."""
        return self.ask("mode", "slam")

    def start_log(self) -> str:
        """Begins the field log."""
        return self.ask("log_start")

    def stop_log(self) -> str:
        """Ends it until start_log(), or the next start of slamd."""
        return self.ask("log_stop")

    def mark(self, what: str) -> str:
        """Notes in the field log what has just happened, in words."""
        return self.ask("log_mark", what)

    def edit(self, edit: Mapping[str, Any]) -> str:
        """Draws into the map: keys as docs/api.md has them, such as {"kind": "free", "points": [[1, 0], [2, 0], [2, 1]]}."""
        return self.ask("map_edit", json.dumps(dict(edit)))

    def undo(self) -> str:
        """Takes the last edit back."""
        return self.ask("map_undo")

    def redo(self) -> str:
        """Makes it again."""
        return self.ask("map_redo")

    def remove_edit(self, number: int) -> str:
        """Takes one edit out."""
        return self.ask("map_remove", str(number))

    def straighten(self, place: str = "") -> str:
        """Turns the map's walls along its axes; a place may be the new origin."""
        return self.ask("map_straighten", place)

    def ask(self, verb: str, argument: str = "", pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> str:
        """Any verb of command_t."""
        command = Command(_now(), int.from_bytes(os.urandom(4), "big") & 0x7FFFFFFF, verb, argument, pose)
        ack = self._ask_lcm(command) if self._path is None else self._ask_socket(command, self._path)
        if not ack.accepted:
            raise RefusedError(ack.message)
        return ack.message

    def _ask_socket(self, command: Command, path: str) -> Ack:
        end = time.monotonic() + self._timeout
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as local:
            local.settimeout(self._timeout)
            try:
                local.connect(path)
                local.send(packed(str(Command.CHANNEL), command, 1))
                while (left := end - time.monotonic()) > 0.0:
                    local.settimeout(left)
                    datagram = local.recv(LONGEST)
                    if not datagram:
                        raise SlamdError(f"{path}: slamd closed the connection: it ends, or has too many clients")
                    answer = unpacked(datagram, {str(Ack.CHANNEL): Ack})
                    if isinstance(answer, Ack) and answer.id == command.id:
                        return answer
            except FileNotFoundError:
                raise SlamdError(f"there is no {path}: slamd does not run, or has another runtime.socket "
                                 "(systemctl status slamd)") from None
            except ConnectionRefusedError:
                raise SlamdError(f"nobody listens on {path}: slamd has ended (journalctl -u slamd -n 50)") from None
            except PermissionError:
                raise SlamdError(f"no right to open {path}: sudo usermod -aG slamd $USER, and log in again") from None
            except TimeoutError:
                pass
            except OSError as error:
                raise SlamdError(f"{path}: {error.strerror}") from error
        raise SlamdError(f"no answer on {path}: slamd hangs or is overloaded (journalctl -u slamd -n 50)")

    def _ask_lcm(self, command: Command) -> Ack:
        with Receiver(self._interface, (Ack,)) as receiver:  # before the question: the answer may be quick
            Sender(self._interface).send(command)
            end = time.monotonic() + self._timeout
            while (left := end - time.monotonic()) > 0.0:
                answer = receiver.next(left)
                if isinstance(answer, Ack) and answer.id == command.id:
                    return answer
        raise SlamdError(f"no slamd answers on {GROUP[0]}:{GROUP[1]}; is it running (systemctl status slamd)? commands need "
                         "lcm.commands = true")


def drive(forward: float, left: float, turn: float, interface: str = LOCALHOST) -> None:
    """The speed that the base shall have [m/s, m/s, rad/s], for half a second: send it at 10 Hz or more. slamd obeys with
    base.speed_commands = true, within base.max_speed and base.max_turn_rate. Nothing answers."""
    Sender(interface).drive(_now(), forward, left, turn)


STOPS = 3  # datagrams: one may be lost


def stop(interface: str = LOCALHOST) -> None:
    """Stops the base, whoever drives it: a zero speed, sent three times. Rights as drive()."""
    sender = Sender(interface)
    for _ in range(STOPS):
        sender.drive(_now(), 0.0, 0.0, 0.0)
