"""A busy computer: every turn comes late, and so do the drives' answers. The position stays known.

Late drives are not to blame: the motion waits for them. If a drive stops by itself, for example
because it missed a heartbeat, that is reported.
"""

import itertools
import math
import random

import pytest
from amounts import amount, every_row
from cia402_rig import QUICK, Rig, steps

from armdrive.dialects.exchange import ListenedTime
from armdrive.tasks import (
    AlertKind,
    ClearFault,
    Done,
    Halted,
    MeasuredUnits,
    MeasureUnits,
    MoveAlong,
    MoveBy,
)
from firmware_protocol.canopen import REPORT_PDO, Service, service_of
from firmware_protocol.frames import Frame, Unpacker, pack

LINE = tuple(MoveBy(steps(1000, -500), 20_000.0) for _ in range(40))
LATE_S = (0.02, 0.15)
TREMBLE = (-1, 0, 1, 2)
"""Increments."""
NAMED_S = 5.0
"""A blocked drive is named within this time, however late everything is; in time it takes 0.7 s."""
MISSED_BEAT = "has stopped by itself, and holds: a heartbeat or life guard is missing"


class BusyRig(Rig):
    """A controller that is called late, or hears late what its drives say, while it is busy."""

    def __init__(self, late: str, seed: int, **settings) -> None:
        super().__init__(QUICK | settings)
        self.busy = False
        self._program, self._wire = "program" in late, "wire" in late
        self._random = random.Random(seed)
        self._frames = Unpacker()
        self._came_s = self._last_s = 0.0
        self.waits_s = self._late_s
        read = self.link.read
        self.link.read = lambda now_s: b"".join(
            map(self._trembling, self._frames.feed(read(now_s)))
        )

    def _late_s(self, _frame: Frame, host: bool) -> float:
        """Hold back what drives say; nothing overtakes what came before."""
        if host:
            return 0.0
        if self.now_s > self._came_s:  # what came together is heard together
            late_s = self._random.uniform(*LATE_S) if self.busy and self._wire else 0.0
            self._came_s, self._last_s = self.now_s, max(self.now_s + late_s, self._last_s)
        return self._last_s - self.now_s

    def _trembling(self, frame: Frame) -> bytes:
        """Have a drive that tells its position tremble, as a closed loop does that holds."""
        found = service_of(frame.can_id)
        if found is None or found[0] is not Service.TPDO1:
            return pack(frame)
        word, mode, position = REPORT_PDO.unpack(frame.data)
        position = int(position) + self._random.choice(TREMBLE)
        return pack(Frame(frame.can_id, REPORT_PDO.pack((word, mode, position))))

    def _step(self, end_s: float) -> None:
        late_s = self._random.uniform(*LATE_S) if self.busy and self._program else 0.0
        due_s = min(self.link.next_s(), self.controller.next_s(), end_s)
        if late_s:
            self.now_s = max(due_s, self.now_s) + late_s
        super()._step(end_s)


LATE, SEEDS = ["program", "wire", "program and wire"], range(amount(1, 4))
STEADY = {"heartbeat_timeout_ms": 2000, "period_ms": 40}
"""With these, drives miss no heartbeat of a program that is so late."""


def keeps_its_reference(rig: BusyRig, reply: object, wanted: object) -> bool:
    """Tell whether the motion ended as asked; else it has to say that a heartbeat was missed."""
    alerts = rig.alerts()
    assert not any(alert.kind is AlertKind.OFF_PATH for alert in alerts), (reply, alerts)
    if reply == wanted:
        assert not alerts
        return True
    assert MISSED_BEAT in str(reply), reply
    return False


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("how", "late"), [("stop", LATE[0]), ("release", LATE[1]), *(("end", late) for late in LATE)]
)
def test_a_motion_that_ends_on_a_busy_computer_keeps_the_position(late, seed, how):
    settings = {} if how == "end" else STEADY  # a motion also goes on with less patient drives
    rig, released = BusyRig(late, seed, **settings).ready(), []
    before = rig.positions
    line = LINE[:10] if how == "end" else LINE
    rig.begin(MoveAlong(iter(line), 0.3, released=lambda: bool(released)))
    rig.run(0.4)
    rig.busy = True
    if how == "stop":
        rig.stop()
    elif how == "release":
        released.append(True)
    reply = rig.finish()
    assert reply == (Done() if how == "end" else Halted()), reply
    assert not rig.alerts()
    assert rig.positions != before
    stood = rig.positions
    assert rig.along(*LINE[:4]) == Done()
    assert not rig.alerts()
    assert (rig.positions - stood - steps(4000, -2000)).largest <= rig.config.device.position_window


@pytest.mark.parametrize("seed", range(amount(1, 40)))
@pytest.mark.parametrize("late", LATE)
def test_a_released_jog_stands_soon_and_reports_drives_that_miss_a_heartbeat(late, seed):
    rig, released = BusyRig(late, seed).ready(), []
    rig.begin(MoveAlong(iter(LINE), 0.3, released=lambda: bool(released)))
    rig.run(0.4)
    rig.busy = True
    released.append(True)
    rig.run(0.5)
    stood = rig.positions
    if not keeps_its_reference(rig, rig.finish(1.5), Halted()):
        assert rig.do(ClearFault()) == Done()
    assert (rig.positions - stood).largest <= rig.config.device.position_window
    assert not any(alert.kind is AlertKind.OFF_PATH for alert in rig.alerts())


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("late", LATE)
def test_a_blocked_drive_is_named_soon_and_gets_no_target_far_ahead_meanwhile(late, seed):
    rig = BusyRig(late, seed).ready()
    rig.begin(MoveAlong(iter(LINE), 0.3))
    rig.run(0.3)
    rig.twin.world.stalled.add(0)
    rig.busy = True
    began_s, stood = rig.now_s, rig.positions[0]
    reply = rig.finish()
    assert "it is blocked" in str(reply), reply
    assert rig.now_s - began_s < NAMED_S / (1 + (late == "program"))
    ahead = max(target for _, target in rig.targets(1, began_s)) - stood
    # the drive itself would end in a fault at its whole window
    assert ahead < 0.8 * rig.config.device.following_window


@pytest.mark.parametrize("late", LATE)
def test_a_drive_that_is_read_off_its_target_is_blamed_however_late_the_report_is(late):
    rig = BusyRig(late, 0, **STEADY).ready()
    rig.begin(MoveAlong(iter(LINE[:10]), 0.3))
    while rig.positions[0] < 9700:
        rig.run(0.002)
    rig.twin.world.stalled.add(0)
    rig.busy, began_s = True, rig.now_s
    reply = rig.finish()
    assert rig.now_s - began_s < NAMED_S / 2
    assert "drive 1 (base) is at" in str(reply)
    assert "it is blocked" in str(reply)
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.OFF_PATH]


@every_row(
    "calls, listened_s",
    [
        (((0.0, 0.1), (0.1, 0.2), (0.2, 0.3)), 0.2),  # in time
        (((0.0, 0.1), (0.05, 0.1), (0.1, 0.2)), 0.1),  # sooner: something came
        (((0.0, 0.1), (0.9, 1.0), (1.0, 1.1)), 0.2),  # late by 0.8 s
        (((0.0, -math.inf), (0.5, 0.6), (0.6, 0.7)), 0.1),  # at once, as for a stop, and late
    ],
)
def test_the_time_by_which_a_program_is_called_late_is_not_listened(calls, listened_s):
    listened = ListenedTime()
    for now_s, due_s in calls:
        listened.pass_to(now_s)
        listened.expect(due_s)
    assert listened.s == pytest.approx(listened_s)


@pytest.mark.parametrize("late", LATE[-amount(1, 3) :])
def test_units_measured_on_a_busy_computer_would_be_wrong_and_are_refused(late):
    rig = BusyRig(late, 1, period_ms=20).ready()
    rig.busy = True
    assert "come too late to time its motor" in str(rig.do(MeasureUnits(0, 500), 60.0))
    assert not rig.alerts()


def turns_away(rig):
    """Measure the units of a drive to the end; return how often its motor was turned away."""
    found = rig.finish(60.0)
    assert isinstance(found, MeasuredUnits)
    assert found.speed_hz == pytest.approx(1.0, rel=0.03)
    away = itertools.groupby(target > 100 for _, target in rig.targets(1))
    return sum(is_away for is_away, _ in away)


def measuring():
    """Return a rig that measures the units of a drive."""
    rig = BusyRig("program and wire", 1, period_ms=20).ready()
    rig.begin(MeasureUnits(0, 500))
    return rig


@pytest.fixture(scope="module")
def prompt_turns():
    """Return how often the motor is turned away if all readings come in time."""
    return turns_away(measuring())


@pytest.mark.parametrize("from_s", [4.0, 8.0][: amount(1, 2)])  # of the speed, of the ramp
def test_a_turn_whose_readings_came_late_is_made_again(prompt_turns, from_s):
    late = measuring()
    late.run(from_s)
    late.busy = True
    late.run(0.4)
    late.busy = False
    assert turns_away(late) > prompt_turns
