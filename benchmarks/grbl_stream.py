"""Ten thousand short segments to a simulated GRBL board on a pseudo-terminal, at 115200 baud.

    python benchmarks/grbl_stream.py [check moving driver] [--json] [--lines N]

Lines are streamed by counting characters, and one at a time, in the same run. Exit code 1 where a
line is refused or unanswered, where the arm does not stand where the lines lead, or where the
wire is used less in check mode than it should be.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys
import tempfile
import time
import tty
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from measuring import Row, Section
from reporting import JSON, asked, machine, show
from sim_process import SimProcess

from armdrive import Arm
from armdrive.blocking import run_blocking
from armdrive.tasks import Done, MoveAlong, MoveBy
from firmware_protocol.grbl import (
    GRBLHAL,
    MEGA_5X,
    Acknowledged,
    CheckMode,
    Command,
    Host,
    Line,
    Refused,
    Restarted,
    SetSetting,
)
from kinematics import Motors

BAUD = 115_200
BYTE_S = 10 / BAUD
LEAST_SHARE = 0.95
"""How much of the wire must be used in check mode."""

PORTIONS = 5
"""The stream is cut into so many, and the middle one counts: a computer that is busy with something
else for a moment says nothing of the stream."""

PATIENCE_S = 5.0
ONE_AT_A_TIME = 5
"""One line at a time is slow: of the lines one in so many is enough to measure it."""


class Failed(Exception):
    """Something is not as it should be."""


@dataclass(frozen=True, slots=True)
class Streamed:
    """How a stream went."""

    lines: int
    bytes: int
    lasted_s: float

    @property
    def share(self) -> float:
        """How much of the wire it used."""
        return self.bytes * BYTE_S / self.lasted_s


class Streamer:
    """A program that streams lines to a port, and counts what comes back."""

    def __init__(self, port: str, host: Host) -> None:
        self.host = host
        self._port = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self._port)
        self._drain()

    def close(self) -> None:
        os.close(self._port)

    def in_portions(self, commands: list[Command]) -> Streamed:
        """Stream lines, and return the portion whose use of the wire is the median."""
        size = max(len(commands) // PORTIONS, 1)
        cuts = range(0, len(commands), size)
        found = [self.stream(commands[start : start + size]) for start in cuts]
        return sorted(found, key=lambda each: each.share)[len(found) // 2]

    def send(self, command: Command) -> None:
        """Send one line and wait for its answer."""
        self.stream([command])

    def stream(self, commands: list[Command]) -> Streamed:
        """Send lines as fast as the ring takes them; raises `Failed` for any but an ok."""
        waiting, oks, sent = commands[::-1], 0, 0
        began_s = time.perf_counter()
        while oks < len(commands):
            out = b""
            while waiting and self.host.room_for(waiting[-1]):
                out += self.host.send(waiting.pop())
            if out:
                sent += os.write(self._port, out)
            self.host.receive_data(self._heard())
            oks += self._answers()
        return Streamed(len(commands), sent, time.perf_counter() - began_s)

    def _answers(self) -> int:
        oks = 0
        while (event := self.host.next_event()) is not None:
            if isinstance(event, Acknowledged):
                oks += 1
            elif isinstance(event, Refused | Restarted):
                raise Failed(f"the board answered {event}")
        return oks

    def _heard(self) -> bytes:
        if not select.select([self._port], [], [], PATIENCE_S)[0]:
            raise Failed(f"no answer for {PATIENCE_S:g} s: {self.host.outstanding_lines[:3]}")
        return os.read(self._port, 4096)

    def _drain(self) -> None:
        while select.select([self._port], [], [], 0.3)[0]:
            os.read(self._port, 4096)


@contextlib.contextmanager
def board(firmware: str) -> Iterator[SimProcess]:
    with (
        tempfile.TemporaryDirectory() as folder,
        SimProcess(Path(folder) / "arm", "grbl", "--set", f"firmware={firmware}") as sim,
    ):
        yield sim


def zigzag(count: int, reach: int = 400) -> list[int]:
    """Return places one step apart, to and fro."""
    up = [*range(1, reach + 1), *range(reach - 1, -1, -1)]
    return [up[n % len(up)] for n in range(count)]


def segments(count: int) -> list[Command]:
    """Return short moves of one axis, in lines of about ten bytes."""
    first, *rest = zigzag(count)
    return [Line(f"G1X{first}F60000"), *(Line(f"G1X{place}.00") for place in rest)]


def pair(what: str, counted: Streamed, single: Streamed) -> tuple[Row, ...]:
    rows = []
    for how, one in (("counting characters", counted), ("one line at a time", single)):
        ratio = {"one at a time": one.lines / one.lasted_s / (single.lines / single.lasted_s)}
        rows += [
            Row(f"{what}, {how}", one.lines / one.lasted_s, "lines/s", times=ratio),
            Row(f"{what}, {how}: the wire's use", one.share * 100, "%"),
        ]
    return tuple(rows)


def single_host(host: Host) -> Host:
    """Return a host that knows no ring, and so has one line outstanding at most."""
    return Host(replace(host.dialect, ring_bytes=None))


def checking(count: int = 10_000) -> Section:
    """In check mode nothing moves: the wire is the only limit."""
    lines = segments(count)
    with board("mega5x") as sim:
        out = Streamer(sim.port, Host(MEGA_5X))
        out.send(CheckMode())
        counted = out.in_portions(lines)
        out.host = single_host(out.host)
        single = out.stream(lines[: max(count // ONE_AT_A_TIME, 1)])
        out.close()
        _expect(sim, lost=0, place=0)
    if counted.share < LEAST_SHARE:
        raise Failed(f"{counted.share:.1%} of the wire was used, not {LEAST_SHARE:.0%}")
    mean = counted.bytes / counted.lines
    return Section(
        "Check mode",
        pair("check mode", counted, single),
        f"{count} lines of {mean:.1f} bytes, every one answered with ok, no byte lost; the median "
        f"of {PORTIONS} portions",
    )


def moving(count: int = 10_000) -> Section:
    """In motion, on a board that plans quickly and with motors that are quick enough."""
    lines = segments(count)
    with board("grblhal") as sim:
        out = Streamer(sim.port, Host(GRBLHAL))
        for setting, value in ((110, 100_000.0), (120, 1_000_000.0)):
            out.send(SetSetting(setting, value))
        counted = out.in_portions(lines)
        _expect(sim, lost=0, place=zigzag(count)[-1])
        out.send(Line("G1X0F60000"))
        out.host = single_host(out.host)
        some = max(count // ONE_AT_A_TIME, 1)
        single = out.stream(lines[:some])
        _expect(sim, lost=0, place=zigzag(some)[-1])
        out.close()
    return Section(
        "In motion",
        pair("in motion", counted, single),
        f"{count} segments of one motor step; the arm stands where they lead, to the step; the "
        f"median of {PORTIONS} portions",
    )


def driver(count: int = 1_000) -> Section:
    """By the driver's own streaming, as a planned motion does it."""
    step_hz, steps = 200.0, 2
    pieces = [MoveBy(Motors((steps, 0, 0, 0, 0, 0)), step_hz) for _ in range(count // 2)]
    pieces += [MoveBy(Motors((-steps, 0, 0, 0, 0, 0)), step_hz) for _ in range(count // 4)]
    with board("mega5x") as sim, Arm.connect(sim.port, dialect="grbl") as arm:
        began_s = time.perf_counter()
        reply = run_blocking(arm.runner.perform(_along(arm, pieces), within_s=600.0))
        lasted_s = time.perf_counter() - began_s
        if not isinstance(reply, Done):
            raise Failed(f"the driver's stream ended otherwise: {reply}")
        _expect(sim, lost=0, place=steps * (count // 2 - count // 4))
    planned_s = sum(piece.duration_s for piece in pieces)
    row = Row(
        "the driver, segments of 10 ms",
        len(pieces) / lasted_s,
        "segments/s",
        times={"as fast as planned": planned_s / lasted_s},
    )
    return Section("By the driver", (row,), f"{len(pieces)} segments in {lasted_s:.1f} s")


def _along(arm: Arm, pieces: list[MoveBy]):
    reply = yield from arm.context.request(
        MoveAlong(iter(pieces), arm.config.motion.planned_burst_s)
    )
    return reply


def _expect(sim: SimProcess, *, lost: int, place: int) -> None:
    """Wait until the arm stands, and look at it: lost bytes, and where its first motor is."""
    until_s = time.monotonic() + PATIENCE_S
    while (state := sim.state())["busy"] and time.monotonic() < until_s:
        time.sleep(0.05)
    if state["lost_bytes"] != lost:
        raise Failed(f"{state['lost_bytes']} bytes were lost")
    if state["registers"][0] != place:
        raise Failed(f"the first motor counts {state['registers'][0]}, not {place}")


SECTIONS: dict[str, Callable[[int], Section]] = {
    "check": checking,
    "moving": moving,
    "driver": driver,
}


def main(argv: list[str] | None = None) -> int:
    lines = {"type": int, "default": 10_000, "help": "how many lines (10000)"}
    options = asked(argv, __doc__, SECTIONS, lines=lines, json=JSON)
    if not options.json:
        print(machine())
    code = 0
    for name in options.names:
        count = options.lines // 10 if name == "driver" else options.lines
        try:
            show(name, SECTIONS[name](count), as_json=options.json)
        except Failed as failure:
            print(f"{name}: {failure}", file=sys.stderr)
            code = 1
    return code


if __name__ == "__main__":
    sys.exit(main())
