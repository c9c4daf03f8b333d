"""The stage of a mission: one physical arm with its controller, wire and disk.

Programs drive the arm one after the other, and each leaves it as it is. A person at the arm turns
motors and confirms postures. The stage tells the watch which bounds the driver has announced.
"""

import math
import random
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import assemble
from armdrive.connect.port import NewLink
from armdrive.connect.target import simulated_config
from armdrive.dialects.mks.steering import CATCH_UP_RPM
from armdrive.dialects.robko01.motion import OVERSHOOT_STEPS
from armdrive.dialog import PostureRequest
from armdrive.registry import dialect, simulated_kind
from armdrive.sim.armdroid import BOARDS as ARMDROIDS
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.cia402.quirks import Cia402Quirks
from armdrive.sim.device import SimDevice, Value, chosen
from armdrive.sim.grbl.firmware import FIRMWARES
from armdrive.sim.mks.quirks import MksQuirks
from armdrive.sim.simulated_arm import TITLE, SimulatedArm
from armdrive.sim.wire import MemoryLink
from armdrive.sim.world.body import ArmBody
from armdrive.status import State
from armdrive.storage.record import RecordFile
from armdrive.text.toml import rule_of
from firmware_protocol.mks import COUNTS_S_PER_RPM
from kinematics import Joints, Motors
from kinematics.guards.shapes import Box
from tests.conformance.observation import ON_THE_STEP, rests_within

from .clock import CampaignPace, Schedule
from .disk import Disk
from .physical import NOTICED_S, Bound, Watch, WatchedWorld
from .switches import can_home, with_switches

STATE = Path("/state/arm.json")
BOX = Box("post", (-60.0, 300.0, 0.0), (60.0, 360.0, 120.0))
RADII_MM = (10.0, 10.0, 10.0)
"""An obstacle next to the arm, and the thickness of its links, in half of the missions."""


@cache
def config_of(name: str, variant: int, homes: bool = False) -> ArmConfig:
    """Return the arm of a dialect; variants have other bursts, an obstacle, or frequent polls.

    An arm that `homes` has switches; every other variant leaves their order to its device.
    """
    config = simulated_config(name)
    if homes:
        config = with_switches(config, grouped=bool(variant & 1))
    motion, model = config.motion, config.model
    if variant & 1:
        motion = replace(motion, planned_burst_s=0.2)
    if variant & 2:
        model = replace(model, guards=replace(model.guards, boxes=(BOX,), radii_mm=RADII_MM))
    if variant & 4:
        motion = replace(motion, idle_poll_s=0.3)
    return replace(config, motion=motion, model=model)


NUMBERS = {"flash_ms": 200.0}
"""The values of quirks that are numbers."""
LEFT_OUT: Mapping[str, str] = MappingProxyType(
    {
        "e_series": "armdrive refuses these drives",
        "homes_reversed": "such an arm cannot home, and otherwise is like any other",
        "hold_after_loss": "drives that extrapolate pass their last target while the bus fails",
        "retarget_creeps": "the arm file has to say `segment_s = 0`",
        "speed_unit": "the arm file has to name the unit",
        "ramp_unit": "the arm file has to name the unit",
    }
)
"""The quirks that missions cannot have, and why."""


def quirks(kind: type) -> Iterable[dict[str, Value]]:
    """Yield the options of usual drives, and of drives with one quirk: each of its other values."""
    yield {}
    for each in fields(kind):
        rule = rule_of(each)
        if rule.source and each.name not in LEFT_OUT:
            values = (True, False) if isinstance(each.default, bool) else rule.words
            values = values or (NUMBERS[each.name],)
            yield from ({each.name: value} for value in values if value != each.default)


VARIANTS = 8
BOARDS: Mapping[str, tuple[dict[str, Value], ...]] = MappingProxyType(
    {
        "grbl": tuple({"firmware": name} for name in FIRMWARES),
        "armdroid": tuple({"board": name} for name in ARMDROIDS),
        "mks": tuple(quirks(MksQuirks)),
        "cia402": tuple(quirks(Cia402Quirks)),
    }
)
"""The options of the simulated devices of a dialect that has several, each in every variant."""


def board_of(name: str, variant: int) -> dict[str, Value]:
    """Return the options of the simulated device in a variant."""
    boards = BOARDS.get(name, ({},))
    return boards[variant // VARIANTS]


def variants_of(name: str) -> int:
    """Return how many variants of an arm a mission may have."""
    return VARIANTS * len(BOARDS.get(name, ({},)))


class KillableLink(MemoryLink):
    """A wire that can kill the program while it writes, after a part of a message."""

    owner: CampaignPace | None = None
    kill_after: int | None = None
    """How many more messages the program sends before it is killed; None if it is not."""
    sent_share = 0.5
    """How much of the last message is sent."""
    on_partial_write: Callable[[], None] = staticmethod(lambda: None)
    """Called when the program is killed in the middle of a message."""

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes, or a part of them and then kill the program."""
        if self.owner is not None:
            self.owner.check_alive()
            if self.kill_after is not None:
                self.kill_after -= 1
                if self.kill_after < 0:
                    super().write(data[: int(len(data) * self.sent_share)], now_s)
                    self.on_partial_write()
                    self.owner.kill()
                    self.owner.check_alive()
        super().write(data, now_s)


class Stage:
    """An arm with all around it. `arm` is the program that drives it now; None if there is none.

    An arm that `homes` does so by its switches, if its device can.
    """

    def __init__(
        self, name: str, draw: random.Random, variant: int | None = None, *, homes: bool = False
    ) -> None:
        variant = draw.randrange(variants_of(name)) if variant is None else variant
        self.homes = homes and can_home(name, board_of(name, variant))
        """Whether the arm homes by its switches."""
        self.config = config_of(name, variant, self.homes)
        kind = simulated_kind(name)
        self.world = WatchedWorld(ArmBody.of_preset(self.config.model))
        board = kind.make(self.config, self.world, chosen(kind.settings, board_of(name, variant)))
        device = SimDevice(board)
        self.link = KillableLink(device.line(), TITLE)
        self.twin = SimulatedArm.of(self.config, device, self.link)
        self.disk = Disk()
        self.schedule = Schedule()
        self.draw = draw
        self.arm: Arm | None = None
        self.pace = CampaignPace(0.0, self.schedule)
        self.suspended_s = 0.0
        """How long programs were suspended since this was last set to 0."""
        self.referenced_s = -math.inf
        """When a person last declared or confirmed where the arm stands."""
        self.connecting = False
        """Whether a program is connecting: it has no `arm` yet."""
        self._ended_at_zero = False
        """Whether the last program had read zeros from all registers when it ended."""
        self._now_s = 0.0
        guarded = self.config.model.guards.over(self.config.model.arm)
        near = rests_within(self.config.device)
        self.near_steps = near
        """How far from its target a drive may rest, in counts; 0 for steppers."""
        near = max(ON_THE_STEP, near)
        self.stuck_until_s: dict[int, float] = {}
        """Until when the switch of a motor is stuck; motors count from 0."""
        speeds = self.config.model.joint_speeds_rad_s
        slowest_hz = dialect(name).controller(self.config).usable_rate_hz(0.0)
        # the speed of an MKS drive that catches up is rounded up to whole rpm, and raised
        rounding_up_hz = COUNTS_S_PER_RPM * (1 + CATCH_UP_RPM) if name == "mks" else 0.0
        tip_mm = self._step_mm() * near
        self.watch = Watch(self.world, guarded, tip_mm, speeds, near, slowest_hz, rounding_up_hz)
        # a stop may take an axis of a Robko beyond its target
        self.watch.overshoot_steps = OVERSHOOT_STEPS if name == "robko01" else 0
        self.world.closed_loop = isinstance(self.twin.board, DrivesBoard)

    # -- programs -------------------------------------------------------------------------------

    def connect(self, *, allow_restored: bool, automatic: bool) -> Arm:
        """Connect a new program in place of the last one."""
        self.pace = pace = CampaignPace(self.now_s, self.schedule)
        pace.on_kill, pace.advance_world = self._add_killed_bound, self.link.line.advance
        self.link.owner = self.disk.owner = pace
        self.link.reopen().read(self.now_s)  # drop what arrived without a program
        self._open_port()
        self.program_ended()
        self.connecting, began_s = True, self.now_s
        try:
            self.arm = arm = Arm(
                assemble(
                    self.config,
                    self.link,
                    pace,
                    simulated=True,
                    record_store=RecordFile(STATE, self.disk),
                    allow_restored=allow_restored,
                    operator=self._confirm_posture,
                    rewiring=NewLink(self.link.reopen, automatic=automatic),
                )
            )
        finally:
            self.connecting = False
            if self.watch.doubts.changed_s >= began_s:  # the program polls the arm only afterwards
                self.watch.note_suspension(began_s, self.now_s - began_s)
        arm.twin = self.twin
        return arm

    def _open_port(self) -> None:
        """Let the board notice that its port is opened: some reset then, and let go of the arm."""
        opened = getattr(self.twin.board, "opened", None)
        if opened is not None:
            opened()

    def program_ended(self) -> None:
        """Note that no program drives the arm any more."""
        if self.arm is not None:
            self._ended_at_zero = self.reads_zero
            self.arm = None

    @property
    def has_program(self) -> bool:
        """Whether a program is connected or connecting."""
        return (self.arm is not None or self.connecting) and not self.pace.dead

    def remove_killed_program(self) -> None:
        """Remove a program that was killed; the arm's time goes on."""
        self._now_s = self.now_s
        self.program_ended()
        self.disk.owner = self.link.owner = None
        self.disk.kill_after = self.link.kill_after = None

    # -- time -----------------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """The simulated time."""
        return max(self._now_s, self.pace.now_s())

    def look(self) -> Motors:
        """Bring the physical arm to the present time, and return where its motors stand."""
        self.link.line.advance(self.now_s)
        return self.world.motors

    def sleep(self, time_s: float) -> None:
        """Let time pass, with or without a program."""
        until_s = self.now_s + time_s
        if self.arm is not None and not self.pace.dead:
            self.arm.sleep(time_s)
        self._now_s = max(self._now_s, until_s)
        if self.arm is None:
            self.schedule.run_due(self._now_s)
        self.look()

    # -- the person at the arm --------------------------------------------------------------------

    def _confirm_posture(self, request: PostureRequest) -> bool:
        """Bring the arm to a requested posture, and return whether that is confirmed."""
        confirmed = self.twin.operator(request)
        if confirmed:
            self.watch.begin_reference(no_faults=self.no_faults)
        self.referenced_s = self.now_s
        return confirmed

    @property
    def no_faults(self) -> bool:
        """Whether no fault is active, none waits on the wire, and all have shown."""
        waits = self.link.line.faults.late.next_s < 1e9
        return not (self.twin.faults.active or waits or self.now_s < self.watch.doubts.evident_s)

    @property
    def reads_zero(self) -> bool:
        """Whether the program last read zero from all registers."""
        if self.arm is None:
            return self._ended_at_zero
        core = self.arm.parts.core
        return not (
            (core.position.read_back or core.position.acknowledged) - core.position.offset
        ).largest

    def turn_by_hand(self, steps: Motors) -> bool:
        """Turn motors at the arm's pendant; return False if the arm is busy."""
        device = self.twin.device
        if device.moving or not device.powered or not hasattr(device, "jog"):
            return False
        self.world.moved_by_hand = True
        try:
            device.jog(steps)
        finally:
            self.world.moved_by_hand = False
        return True

    def place_by_hand(self, joints: Joints, opening_mm: float) -> None:
        """Bring the arm to a posture by hand."""
        self.world.moved_by_hand = True
        try:
            if isinstance(self.twin.board, DrivesBoard):  # these would turn their shafts back
                self.twin.device.bring_to(joints, opening_mm)
            else:
                self.world.drive_to(self.world.body.transmission.to_motors(joints, opening_mm))
        finally:
            self.world.moved_by_hand = False

    def posture(self) -> tuple[Joints, float]:
        """Return the joint angles and the opening at which the physical arm stands."""
        return self.world.body.transmission.to_joints(self.look())

    def add_bound(
        self, what: str, time_s: float, distance_mm: float, *, is_pause: bool = False
    ) -> None:
        """Add a bound from now on.

        While messages are lost or late, the bound of a silent program holds. On a bus the driver
        then first has to notice a drive that did not get its orders; a pause (`is_pause`) repeats
        what was planned ahead until all have got it.
        """
        self.look()
        disturbed_s = self.watch.disturbed_until_s - self.now_s
        if self.arm is not None and (disturbed_s > 0.0 or self.watch.doubts.late_s):
            core = self.arm.parts.core
            joints = core.position.coordinates.joints
            silent = core.stops.bound(core.controller, joints, lost=False, slowed=True)
            time_s = max(time_s, silent.silent_time_s)
            distance_mm = max(distance_mm, silent.silent_distance_mm)
        if disturbed_s > 0.0:
            time_s += disturbed_s if is_pause else NOTICED_S
        bound = Bound(what, self.now_s, self.world.tip, time_s, distance_mm, is_pause)
        self.watch.add_bound(bound)

    def disturb(self, for_s: float) -> None:
        """Note that for a time drives may miss orders, also that to stop, or get them late.

        The driver needs some time to notice. Steppers on one board miss no orders singly.
        """
        if not self.world.closed_loop:
            return
        self.look()
        self.watch.disturb(self.now_s + for_s + NOTICED_S)
        if self.watch.bounds:
            paused = any(each.is_pause for each in self.watch.bounds)
            self.add_silence_bound("a stop was lost", for_s if paused else 0.0)

    def add_stop_bound(self, what: str) -> None:
        """Add the bound that the status announces for a stop now."""
        if self.arm is not None and self.arm.parts.core.state is not State.DISCONNECTED:
            bound = self.arm.parts.core.stop_bound()
            self.add_bound(what, bound.time_s, bound.distance_mm)

    def add_silence_bound(self, what: str, more_s: float = 0.0) -> None:
        """Add the bound that the status announces for a program that falls silent now."""
        if self.arm is not None:
            bound = self.arm.parts.core.stop_bound()
            if self.arm.parts.core.state is not State.DISCONNECTED:
                self.watch.clear_bounds()  # a silent program does not request the stop any more
            self.add_bound(what, bound.silent_time_s + more_s, bound.silent_distance_mm)

    def _add_killed_bound(self) -> None:
        self.add_silence_bound("the program was killed")

    def _step_mm(self) -> float:
        """Return how far the tip is off at most if every motor is one step off."""
        levers = self.config.model.arm.levers_mm(None)
        transmission = self.world.body.transmission
        turns = (sum(map(abs, row)) for row in transmission.inverse)
        return sum(turn * lever for turn, lever in zip(turns, levers, strict=False))


def suspend(stage: Stage, by_s: float) -> None:
    """Suspend the program for `by_s`, as a computer does that sleeps."""
    stage.watch.note_suspension(stage.now_s, by_s)
    stage.add_silence_bound("the program stood still", by_s)
    stage.pace.suspend(by_s)
    stage.suspended_s += by_s
