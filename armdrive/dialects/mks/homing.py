"""The drives' own homing, in the arm file's groups: each searches for its switch or its stop.

A drive that has found it counts from zero there by itself. Nothing here sets a zero.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from armdrive.dialects.bus.drives import (
    NONE_HEARD,
    absent_words,
    midway,
    shared_words,
)
from armdrive.dialects.bus.homing import (
    Groups,
    HomingSearch,
    HomingStatus,
    home_in_groups,
)
from armdrive.dialects.controller import OVERTRAVEL
from armdrive.dialects.mks.contact import OWN_ID, adopt_positions, stall_words, stalled_among
from armdrive.dialects.mks.drive import MksDrive, setting_of
from armdrive.dialects.mks.exchange import MksExchange, MksScript, Script
from armdrive.dialects.mks.motion import prepare, unheard
from armdrive.dialects.mks.stops import halt, relieve
from armdrive.dialects.mks.survey import is_shared
from armdrive.tasks import Alert, AlertKind, Done, Halted, Progress, RequestRejected
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    Ability,
    Code,
    Home,
    HomingState,
    MotorState,
    Outcome,
    ReadEncoder,
    ReadHoming,
    ReadSetting,
    ReadState,
    SetHoming,
    Status,
    slope_of,
)
from kinematics.text import counted

# The gentlest ramp that a drive knows, in counts/s²: on which one it brakes when its watchdog ends
# its homing is not published, and it does not report that.
HOMING_SLOPE = slope_of(1)
# The longest time between two looks at drives that home, since a search takes seconds. Drives with
# a short watchdog are asked as often as in motion, which feeds it.
HOMING_POLL_S = 0.05
# A drive that has homed counts from there, give or take what it turned as it braked.
ZERO_COUNTS = COUNTS_PER_TURN // 8


def two_zeros_words(drive: MksDrive) -> str:
    """Return that a drive's reading and its targets count from different places."""
    return (
        f"{drive} has a new zero, but still reads {counted(drive.count, 'count')} there: its "
        "targets count from another place than its readings, so it would turn to a wrong one. "
        "End this program. Switch the drives' supply off and on, which makes both zero. Then "
        "connect again and reference the arm by hand (without a section [homing])"
    )


def home(io: MksExchange, groups: Groups) -> Script:
    """Home group after group."""
    yield from prepare(io)
    homed = yield from home_in_groups(groups, io.drives, lambda drives: _home_group(io, drives))
    if homed == Done():
        yield from adopt_positions(io)
    return homed


def _home_group(io: MksExchange, drives: tuple[MksDrive, ...]) -> Script:
    yield from read_speeds(io, drives)
    for drive in drives:
        drive.homes, drive.state, drive.homing = True, None, None
    answers = yield from io.ask(dict.fromkeys(drives, Home()), tries=1, text="HOME")
    search = HomingSearch(drives, COUNTS_PER_TURN, io.listened, io.homing)
    for drive, answer in answers.items():
        if answer == Status(Code.HOME, Outcome.FAILED):
            search.wrong = f"{drive} refused to home"
    yield from _search(io, search)
    if search.left:
        began_s = io.now_s
        unstopped = yield from halt(io, search.left, hard=True)
        for drive in search.left:
            drive.stand(io.now_s)
        yield from relieve(io, [each for each in drives if each not in unstopped])
        if unstopped:
            return (yield from unheard(io, unstopped, began_s))
    if search.wrong:
        return RequestRejected((yield from _explained(io, search)))
    if search.left:
        return Halted(kept=False)
    return (yield from _verify_zeros(io, drives))


def _search(io: MksExchange, search: HomingSearch[MksDrive]) -> MksScript[None]:
    """Follow the drives until all have found their switches, one never will, or a stop."""
    due_s = io.now_s
    period_s = min(HOMING_POLL_S, io.settings.poll_s)
    while not io.stop_asked and not search.over:
        if io.now_s >= due_s:
            due_s = io.now_s + period_s
            for drive in search.left:
                drive.state = drive.homing = None
                # positions first, since counts restart at the zero
                for question in (ReadEncoder(), ReadHoming(), ReadState()):
                    io.put(drive, question)
            io.notify(Progress(io.registers()))
        yield from io.hear(due_s)
        for drive in tuple(search.left):
            search.note(drive, _status(drive))
            if drive.questions.lost(io.listened.s):
                missing = yield from io.look()
                words = NONE_HEARD if len(missing) != 1 else absent_words(missing, "id")
                search.wrong = search.wrong or words


def _explained(io: MksExchange, search: HomingSearch[MksDrive]) -> MksScript[str]:
    """Return what went wrong, and report a drive that has released its shaft."""
    stalled = yield from stalled_among(io, search.left)
    if not stalled:
        return search.wrong
    words = stall_words(stalled[0])
    io.notify(Alert(AlertKind.SWITCHED_OFF, words))
    return f"{search.wrong}; {words}, or set the direction of its homing (90) the other way"


def _verify_zeros(io: MksExchange, drives: Sequence[MksDrive]) -> Script:
    """Check that drives which have found their switches count from zero there.

    If another drive answers to the same id, the reading may be of that one.
    """
    for drive in drives:
        drive.homes = False
    began_s = io.now_s
    if missing := (yield from io.look(drives)):
        return midway(io.absence(missing, began_s))
    off = next((drive for drive in drives if abs(drive.count) > ZERO_COUNTS), None)
    if off is None:
        return Done()
    if (yield from is_shared(io, off.node)):
        return RequestRejected(shared_words((off.node,), "id", OWN_ID))
    off.two_zeros = two_zeros_words(off)
    return RequestRejected(off.two_zeros)


def read_speeds(io: MksExchange, drives: Collection[MksDrive]) -> MksScript[None]:
    """Learn how fast drives home, from those that report their settings.

    A drive turns through its range, at whose end its switch stands. One that stands on its
    switch turns away and back, within the part beyond the limits.
    """
    if not io.can(Ability.READ_SETTINGS):
        return
    found = yield from io.read(ReadSetting(Code.HOMING), drives)
    for drive in drives:
        io.homing.forget(drive)
        if isinstance(setting := setting_of(found.get(drive)), SetHoming):
            rate_hz = max(setting.speed_rpm, 1) * COUNTS_S_PER_RPM
            io.homing.note(drive, rate_hz, OVERTRAVEL * io.homing.ranges[drive] / rate_hz)


def _status(drive: MksDrive) -> HomingStatus:
    """Return what a drive reports of its search."""
    if drive.homing is HomingState.FAILED:
        return HomingStatus.FAILED
    found = drive.homing is HomingState.DONE and drive.state is MotorState.STOPPED
    return HomingStatus.FOUND if found else HomingStatus.SEARCHING
