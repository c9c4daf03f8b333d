"""The CiA 402 drives' own homing, in the arm file's groups: each searches for its switch.

A drive that has found it counts from its home offset there by itself. Nothing here sets a zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from armdrive.dialects.bus.homing import (
    Groups,
    HomingSearch,
    HomingStatus,
    home_in_groups,
)
from armdrive.dialects.cia402.drives import Cia402Drive
from armdrive.dialects.cia402.exchange import Cia402Exchange
from armdrive.dialects.cia402.motion import Outcome, lead, prepare
from armdrive.dialects.cia402.objects import homing_words
from armdrive.dialects.cia402.states import hold
from armdrive.dialects.cia402.transfers import Script
from armdrive.dialects.controller import OVERTRAVEL
from armdrive.tasks import Done, Reply, RequestRejected
from firmware_protocol import canopen
from firmware_protocol.canopen import OperationMode, Write

GO = canopen.Controlword.of(canopen.Command.ENABLE_OPERATION, canopen.ControlBit.NEW_SET_POINT)
# A drive may report how an earlier search ended for this many cycles of the next one; after that
# the report is new. Simulated drives clear it in two cycles.
STALE_CYCLES = 10
HOMING_OBJECTS = (
    canopen.HOMING_METHOD,
    canopen.HOMING_SPEED,
    canopen.HOMING_CREEP,
    canopen.HOMING_ACCELERATION,
)


def home(io: Cia402Exchange, groups: Groups) -> Script[Reply]:
    """Home group after group."""
    yield from prepare(io, io.resting_mode)
    return (yield from home_in_groups(groups, io.drives, lambda group: _home_group(io, group)))


def _home_group(io: Cia402Exchange, group: Sequence[Cia402Drive]) -> Script[Reply]:
    yield from io.put({drive: _writes(io, drive) for drive in group})
    yield from read_speeds(io, group)
    yield from hold(io, OperationMode.HOMING, group)
    io.last_command = "HOME"
    search = HomingSearch(group, 1.0, io.listened, io.homing)
    reply = yield from lead(io, None, *_searching(io, search, group))
    if isinstance(reply, Done):
        yield from hold(io, io.resting_mode, group)
    if isinstance(reply, RequestRejected) and not reply.silent:
        searched = "".join(
            f"; homing method (6098) of {drive}: {homing_words(drive.homing_method)}"
            for drive in group
            if drive.homing_method is not None
        )
        return replace(reply, reason=f"{reply.reason}{searched}")
    return reply


def _writes(io: Cia402Exchange, drive: Cia402Drive) -> tuple[Write, ...]:
    """Return the objects that define a drive's search, as far as the arm file states them."""
    settings, writes = io.settings, []
    if settings.homing_methods:
        method = settings.homing_methods[drive.motor]
        writes.append(Write(canopen.HOMING_METHOD, canopen.DataType.I8, method))
    places = (canopen.HOMING_SPEED, canopen.HOMING_CREEP)
    for place, speed in zip(places, settings.homing_speeds, strict=True):
        if speed:
            writes.append(Write(place, canopen.DataType.U32, drive.speed(speed)))
    return tuple(writes)


def read_speeds(io: Cia402Exchange, group: Sequence[Cia402Drive]) -> Script[None]:
    """Learn how fast drives will home, from those that report it and whose units are known."""
    known = [drive for drive in group if drive.speed_unit_hz]
    for result in (yield from io.obtain(dict.fromkeys(known, HOMING_OBJECTS))):
        drive = result.drive
        values = result.values | {each.place: each.value for each in _writes(io, drive)}
        drive.homing_method = values.get(canopen.HOMING_METHOD)
        io.homing.forget(drive)
        bounds = search_bounds(drive, values, io.homing.ranges[drive])
        if bounds is not None:
            io.homing.note(drive, *bounds)


def _searching(
    io: Cia402Exchange, search: HomingSearch[Cia402Drive], group: Sequence[Cia402Drive]
) -> tuple[Callable[[], None], Callable[[], Outcome | None]]:
    """Return what sends the drives of a group to their switches, and what tells the end."""
    cycles = 0
    stale = {
        drive
        for drive in group
        if drive.word is None or _shown(drive.word) is not HomingStatus.SEARCHING
    }

    def send() -> None:
        nonlocal cycles
        cycles += 1
        for drive in group:
            io.command(drive, GO, OperationMode.HOMING, drive.count)

    def ended() -> Outcome | None:
        for drive in list(search.left):
            if drive.missed or drive.word is None:
                continue
            status = _shown(drive.word)
            if status is HomingStatus.SEARCHING:
                stale.discard(drive)
            elif drive in stale and cycles <= STALE_CYCLES:
                status = HomingStatus.SEARCHING  # it may still report how an earlier search ended
            search.note(drive, status)
        over = search.over
        if search.wrong:
            return RequestRejected(search.wrong)
        return Done() if over else None

    return send, ended


def _shown(word: canopen.Statusword) -> HomingStatus:
    """Return what a drive in homing mode reports of this search, or of the one before."""
    if word.has(canopen.StatusBit.FOLLOWING_ERROR):
        return HomingStatus.FAILED
    found = word.has(canopen.StatusBit.ACKNOWLEDGED) and word.has(canopen.StatusBit.REACHED)
    return HomingStatus.FOUND if found else HomingStatus.SEARCHING


def search_bounds(
    drive: Cia402Drive, values: Mapping[canopen.Place, int], range_steps: float
) -> tuple[float, float] | None:
    """Return how fast a drive homes, in increments/s, and for how long at most in this range.

    None if these values of `HOMING_OBJECTS` do not tell: a method of the maker's own has a negative
    number, and may have other speeds than those of 6099. A drive searches there and back, since
    methods 7 to 14 and 23 to 30 of CiA 402 turn around at a limit switch. Then it leaves its
    switch, which may be pressed in all of the part beyond the limits, and by which it has run past
    while it braked. The index pulse, if it seeks that, is no farther away. A ramp up and down, if
    the drive reports its own, makes each of these three ways longer.
    """
    speeds = (values.get(place, 0) for place in (canopen.HOMING_SPEED, canopen.HOMING_CREEP))
    search_hz, creep_hz = (speed * drive.speed_unit_hz for speed in speeds)
    if not search_hz or not creep_hz or values.get(canopen.HOMING_METHOD, 0) < 0:
        return None
    fastest_hz = max(search_hz, creep_hz)
    slope_hz_s = values.get(canopen.HOMING_ACCELERATION, 0) * drive.ramp_unit_hz_s
    ramp_s = fastest_hz / slope_hz_s if slope_hz_s else 0.0
    beyond = (OVERTRAVEL - 1.0) * range_steps + search_hz * ramp_s / 2.0
    search_s = 2.0 * OVERTRAVEL * range_steps / search_hz
    return fastest_hz, search_s + beyond / creep_hz + 3.0 * ramp_s
