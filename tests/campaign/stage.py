"""One physical arm, its controller, its wire and a disk; and the programs that drive it in turn."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

from armdrive.abilities import Abilities
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import assemble
from armdrive.connect.reconnect import NewLink
from armdrive.connect.target import simulated_config
from armdrive.dialects.controller import Controller
from armdrive.dialects.mks.steering import CATCH_UP_RPM
from armdrive.dialects.robko01.motion import OVERSHOOT_STEPS
from armdrive.dialog.operator import PostureRequest
from armdrive.registry import dialect, simulated_kind
from armdrive.sim.device import DrivesOnBus, Options, SimDevice
from armdrive.sim.simulated_arm import TITLE, SimulatedArm
from armdrive.sim.wire import PacedDevice
from armdrive.sim.world.body import ArmBody
from armdrive.status import State
from armdrive.storage.record import FileRecorder
from armdrive.trace.calls import NO_TRACER
from armdrive.trace.recorder import FlightRecorder
from armdrive.transports.in_process import MemoryLink
from firmware_protocol.mks import COUNTS_S_PER_RPM
from kinematics import Joints, Motors
from kinematics.guards.shapes import Box
from tests.conformance.seen import ON_THE_STEP, rests_within

from .clock import Agenda, CampaignPace
from .disk import Disk
from .lagging import Lagging
from .physical import Bound, Watch, WatchedWorld

STATE = Path("/state/arm.json")
BOX = Box("post", (-60.0, 300.0, 0.0), (60.0, 360.0, 120.0))
RADII_MM = (10.0, 10.0, 10.0)
"""A thing beside the arm, and links that are thick, in a part of the missions."""


@cache
def config_of(name: str, variant: int) -> ArmConfig:
    """Return the arm of a dialect; some have other bursts, a box to keep out of, no idle looks."""
    config = simulated_config(name)
    motion, model = config.motion, config.model
    if variant & 1:
        motion = replace(motion, planned_burst_s=0.2)
    if variant & 2:
        model = replace(model, guards=replace(model.guards, boxes=(BOX,), radii_mm=RADII_MM))
    if variant & 4:
        motion = replace(motion, idle_poll_s=0.3)
    return replace(config, motion=motion, model=model)


VARIANTS = 8
GRBL_BOARDS = ("mega5x", "grbl")
"""The two 8-bit builds, which differ in their buffers, words and lines."""


def board_of(name: str, variant: int) -> dict[str, str]:
    """Return the options of the simulated device: half of the GRBL boards are of either build."""
    return {"firmware": GRBL_BOARDS[variant // 4]} if name == "grbl" else {}


GREETING = ("grbl",)
"""Dialects whose boards greet whenever they begin anew."""
CUT_OFF = ("E407", "E409", "E502")
"""The errors of an arm whose wire was lost, or none of whose drives answers: none is told to hold
where its shaft is until the arm is reset. A shaft that is blocked meanwhile springs when it comes
free, as the page of MKS drives says.
"""
LOOKING = (State.STANDBY, State.HOMING, State.MOVING, State.STOPPING)


class Deadly(MemoryLink[PacedDevice]):
    """A wire at which a program can be killed, having written a part of its message."""

    owner: CampaignPace | None = None
    ends_in: int | None = None
    """Messages until the program is killed; None for never."""
    share = 0.5
    torn: Callable[[], None] = staticmethod(lambda: None)
    """Called as the program dies in the middle of a message."""

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes, or a part of them as the last thing."""
        if self.owner is not None:
            self.owner.live()
            if self.ends_in is not None:
                self.ends_in -= 1
                if self.ends_in < 0:
                    super().write(data[: int(len(data) * self.share)], now_s)
                    self.torn()
                    self.owner.die()
                    self.owner.live()
        super().write(data, now_s)


class Stage:
    """The arm on its table. `arm` is the program that drives it at present, if there is one."""

    def __init__(self, name: str, draw: random.Random, variant: int | None = None) -> None:
        variant = draw.randrange(VARIANTS) if variant is None else variant
        self.config = config_of(name, variant)
        kind = simulated_kind(name)
        self.world = WatchedWorld(ArmBody.of_preset(self.config.model))
        board = kind.make(self.config, self.world, Options(kind.options, board_of(name, variant)))
        device = SimDevice(board)
        self.link = Deadly(device.line(), TITLE)
        self.twin = SimulatedArm.of(self.config, device, self.link)
        self.disk = Disk()
        self.agenda = Agenda()
        self.draw = draw
        self.arm: Arm | None = None
        self.pace = CampaignPace(0.0, self.agenda)
        self.jumped_s = 0.0
        """How long programs have been suspended, since this was last set to 0."""
        self.vouched_s = -math.inf
        """When somebody last said where the arm stands."""
        self.connecting = False
        """Whether a program is connecting, which has no arm yet."""
        self._left_at_zeros = False
        """Whether the last program had been told zeros when it ended."""
        self._now_s = 0.0
        guarded = self.config.model.guards.over(self.config.model.arm)
        near = rests_within(self.config.device)
        self.near_steps = near
        """How far from its target a drive may rest; 0 for steppers, which stand on it."""
        near = max(ON_THE_STEP, near)
        self.unheard_until_s = -math.inf
        self.late_orders_until_s = -math.inf
        """Until when frames of the host may come a period late."""
        self._finishes = False
        """Whether the last promise was that of a pause."""
        self.untold_until_s: dict[int, float] = {}
        """Until when drives cannot be told to hold where their shafts are, by motors from 0."""
        speeds = self.config.model.joint_speeds_rad_s
        slowest_hz = self._controller.usable_rate_hz(0.0)
        # an MKS drive that catches up is told whole rpm: rounded up, and a little more
        setting_hz = COUNTS_S_PER_RPM * (1 + CATCH_UP_RPM) if name == "mks" else 0.0
        tip_mm = self._step_mm() * near
        self.watch = Watch(self.world, guarded, tip_mm, speeds, near, slowest_hz, setting_hz)
        self.watch.lagging = Lagging.of(self.config)
        # its firmware gives up the target of a motion that is stopped
        self.watch.overshoot_steps = OVERSHOOT_STEPS if name == "robko01" else 0
        if isinstance(self.twin.board, DrivesOnBus):  # others catch nothing up
            self.watch.freed.hears = self._hears
            self.world.measured = True

    @property
    def config_abilities(self) -> Abilities:
        """What the arm's controller can do, by the settings of this arm."""
        return self._controller.abilities

    @property
    def _controller(self) -> Controller:
        return dialect(self.config.connection.dialect).controller(self.config)

    # -- programs -------------------------------------------------------------------------------

    def connect(self, *, allow_restored: bool, automatic: bool, recorded: bool) -> Arm:
        """Have a program connect, in place of the last one."""
        self.pace = pace = CampaignPace(self.now_s, self.agenda)
        pace.dying, pace.meanwhile = self._promise_silence, self.link.line.advance
        self.link.owner = self.disk.owner = pace
        self.link.reopen().read(self.now_s)  # what came while nobody listened is gone
        opened = getattr(self.twin.board, "opened", None)
        if opened is not None:
            opened()
        self.leave()
        self.watch.untold(self.now_s)
        self.connecting = True
        try:
            self.arm = arm = Arm(
                assemble(
                    self.config,
                    self.link,
                    pace,
                    simulated=True,
                    recorder=FileRecorder(STATE, self.disk),
                    allow_restored=allow_restored,
                    operator=self._look_and_vouch,
                    tracer=FlightRecorder() if recorded else NO_TRACER,
                    rewiring=NewLink(self.link.reopen, automatic=automatic),
                )
            )
        finally:
            self.connecting = False
        arm.twin = self.twin
        return arm

    def leave(self) -> None:
        """Note that no program drives the arm any more."""
        if self.arm is not None:
            self._left_at_zeros = self.told_zeros
            self.arm = None

    @property
    def alive(self) -> bool:
        """Whether there is a program, that connects or is connected."""
        return (self.arm is not None or self.connecting) and not self.pace.dead

    def bury(self) -> None:
        """Take away a program that was killed: the arm lives on."""
        self._now_s = self.now_s
        self.leave()
        self.disk.owner = self.link.owner = None
        self.disk.ends_in = self.link.ends_in = None

    # -- time -----------------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """The time of this arm's world."""
        return max(self._now_s, self.pace.now_s())

    def look(self) -> Motors:
        """Look at the physical arm as it is now."""
        self.link.line.advance(self.now_s)
        return self.world.motors

    def sleep(self, time_s: float) -> None:
        """Let time pass, with or without a program."""
        until_s = self.now_s + time_s
        if self.arm is not None and not self.pace.dead:
            self.arm.sleep(time_s)
        self._now_s = max(self._now_s, until_s)
        if self.arm is None:
            self.agenda.pass_to(self._now_s)
        self.look()

    # -- the person beside the arm ----------------------------------------------------------------

    def _look_and_vouch(self, request: PostureRequest) -> bool:
        """Bring the arm to a posture, and say so."""
        confirmed = self.twin.operator(request)
        if confirmed:
            self.watch.referred(faultless=self.faultless)
        self.vouched_s = self.now_s
        return confirmed

    @property
    def faultless(self) -> bool:
        """Whether no fault is under way, or about to come on the wire."""
        return not self.twin.faults.active and self.link.line.faults.next_s > 1e9

    @property
    def hears_greetings(self) -> bool:
        """Whether the board says by itself that it begins anew, and a program hears it."""
        alive = self.arm is not None and not self.pace.dead
        there = alive and self.arm.core.state is not State.DISCONNECTED
        return there and self.config.connection.dialect in GREETING

    def _hears(self, motor: int, time_s: float) -> bool:
        """Tell whether a program is there, and hears a motor's drive and may tell it to hold."""
        alive = self.arm is not None and not self.pace.dead
        there = alive and self.arm.core.state is not State.DISCONNECTED
        there = there and self.arm.core.diagnostics.error_code not in CUT_OFF
        return there and time_s >= self.untold_until_s.get(motor, -math.inf)

    @property
    def looks(self) -> bool:
        """Whether a program is there that looks at the arm by and by, or moves it."""
        return self.arm is not None and not self.pace.dead and self.arm.core.state in LOOKING

    @property
    def told_zeros(self) -> bool:
        """Whether all that the program has been told of the registers last is that they are 0."""
        if self.arm is None:
            return self._left_at_zeros
        core = self.arm.core
        return not (
            (core.position.read_back or core.position.acknowledged) - core.position.offset
        ).largest

    def turn_by_hand(self, steps: Motors) -> bool:
        """Have somebody move the arm at its pendant; False where it is busy."""
        device = self.twin.device
        if device.moving or not device.powered or not hasattr(device, "jog"):
            return False
        self.world.by_person = True
        try:
            device.jog(steps)
        finally:
            self.world.by_person = False
        return True

    def bring_to(self, joints: Joints, opening_mm: float) -> None:
        """Have somebody bring the arm to a posture."""
        self.world.by_person = True
        try:
            if isinstance(self.twin.board, DrivesOnBus):  # which would turn their shafts back
                self.twin.device.bring_to(joints, opening_mm)
            else:
                self.world.drive_to(self.world.body.transmission.to_motors(joints, opening_mm))
        finally:
            self.world.by_person = False

    def posture(self) -> tuple[Joints, float]:
        """Return how the arm is seen to stand."""
        return self.world.body.transmission.to_joints(self.look())

    def promise(
        self, what: str, time_s: float, distance_mm: float, *, finishes: bool = False
    ) -> None:
        """Note a promise from now on; while nobody hears the driver, that of silence.

        Where drives hear it one without the other, the motion is not the planned one any more. A
        pause `finishes` what was planned ahead: that is said again and again to drives that have
        not heard it, and they begin as soon as they do.
        """
        self.look()
        self._finishes = finishes or (self._finishes and self.watch.promised)
        if self.arm is not None and self.unheard:
            core = self.arm.core
            joints = core.position.coordinates.joints
            bound = core.stops.bound(core.controller, joints, lost=False, slowed=True)
            time_s = max(time_s, bound.silent_time_s)
            if self._finishes:
                time_s += self.unheard_until_s - self.now_s
            distance_mm = max(distance_mm, bound.silent_distance_mm)
        if self.catches_up:
            time_s, distance_mm = 2.0 * time_s, 4.0 * distance_mm
        self.watch.promise(Bound(what, self.now_s, self.world.tip, time_s, distance_mm))

    @property
    def catches_up(self) -> bool:
        """Whether a SYNC may be a period late, so that drives catch up at twice the speed.

        A stop in that period brakes from there, which takes twice the time and four times the way:
        the exception that docs/controllers/can.md states.
        """
        return self.config.connection.dialect == "cia402" and self.now_s < self.late_orders_until_s

    @property
    def unheard(self) -> bool:
        """Whether what the driver says reaches nobody, which it cannot know at once."""
        return self.now_s < self.unheard_until_s

    def promise_stop(self, what: str) -> None:
        """Note what the status announces of a motion that is to end now."""
        if self.arm is not None and self.arm.core.state is not State.DISCONNECTED:
            bound = self.arm.core.stop_bound()
            self.promise(what, bound.time_s, bound.distance_mm)

    def promise_silence(self, what: str, more_s: float = 0.0) -> None:
        """Note what the status announces of a program that falls silent now."""
        if self.arm is not None:
            bound = self.arm.core.stop_bound()
            if self.arm.core.state is not State.DISCONNECTED:
                self.watch.let_go_on()  # a stop that was about to be asked for will not be
            self.promise(what, bound.silent_time_s + more_s, bound.silent_distance_mm)

    def _promise_silence(self) -> None:
        self.promise_silence("the program was killed")

    def _step_mm(self) -> float:
        """Return how far the tip is off at most where every motor is one step off."""
        levers = self.config.model.arm.levers_mm(None)
        transmission = self.world.body.transmission
        turns = (sum(map(abs, row)) for row in transmission.inverse)
        return sum(turn * lever for turn, lever in zip(turns, levers, strict=False))


def suspend(stage: Stage, by_s: float) -> None:
    """Have the program stand still for so long, as a computer that sleeps does."""
    if stage.told_zeros and not stage.hears_greetings:
        stage.watch.untold()  # a power failure that nobody was awake for may leave what was told
    stage.watch.asleep(stage.now_s, by_s)
    stage.promise_silence("the program stood still", by_s)
    stage.pace.jump(by_s)
    stage.jumped_s += by_s
