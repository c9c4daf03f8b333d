"""The stage: one simulated arm with its controller, wire, disk and people, in simulated time.

Programs drive the arm one after the other, and each leaves it as it is. `arm` is the program that
drives it now. The stage injects what happens, and tells the watch what no driver can know of it.
"""

import math
import random
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import assemble
from armdrive.connect.port import NewLink
from armdrive.errors import BadRequest
from armdrive.registry import dialect, simulated_kind
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import SimDevice, Value, chosen
from armdrive.sim.faults import parse_words
from armdrive.sim.robko01 import SimRobkoBoard
from armdrive.sim.simulated_arm import TITLE, SimulatedArm
from armdrive.sim.wire import MemoryLink
from armdrive.sim.world.body import ArmBody
from armdrive.status import State, Trust
from armdrive.storage.record import RecordFile
from kinematics import Joints, Motors

from .disk import Disk
from .happenings import Effect, Happening
from .program import ProgramTime, Timeline
from .watch import Bound, Excuse, Watch, WatchedWorld

STATE = Path("/state/arm.json")
NOTICED_S = 0.6
"""The driver notices within this time that a device does not follow, and stops it."""
POLLED_S = 0.5
"""A poll that is due has begun within this time, whatever its result."""
RESET_S = 0.15
"""A device that is reset holds its motors again after this time."""
NEAR_ZERO = 64
"""After a restart, a drive that had counted no more than this seems to be where it was."""
NO_OPTIONS: Mapping[str, Value] = MappingProxyType({})


class StageLink(MemoryLink):
    """A wire whose writes can be observed, lost, or cut short by the end of their program."""

    owner: ProgramTime | None = None
    loses: Callable[[bytes], bool] = staticmethod(lambda data: False)
    on_message: Callable[[bytes], None] = staticmethod(lambda data: None)
    kill_after: int | None = None
    """How many more messages the program sends before it is killed; None if it is not."""
    sent_share = 0.5
    """How much of the last message is sent."""

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes, unless they are lost, or a part of them and then kill the program."""
        self.on_message(data)
        if self.owner is not None:
            self.owner.check_alive()
            if self.kill_after is not None:
                self.kill_after -= 1
                if self.kill_after < 0:
                    super().write(data[: int(len(data) * self.sent_share)], now_s)
                    self.owner.kill()
                    self.owner.check_alive()
        super().write(b"" if self.loses(data) else data, now_s)


class Stage:
    """An arm with all around it; `options` are those of the simulated device."""

    def __init__(self, config: ArmConfig, options: Mapping[str, Value] = NO_OPTIONS) -> None:
        self.config = config
        kind = simulated_kind(config.connection.dialect)
        self.world = WatchedWorld(ArmBody.of_preset(config.model))
        device = SimDevice(kind.make(config, self.world, chosen(kind.settings, options)))
        self.link = StageLink(device.line(), TITLE)
        self.twin = SimulatedArm.of(config, device, self.link)
        self.disk = Disk()
        self.timeline = Timeline()
        self.arm: Arm | None = None
        self.pace = ProgramTime(0.0, self.timeline)
        self.suspended_s = 0.0
        """How long programs were suspended since this was last set to 0."""
        self.referencing = False
        """Whether a call connects or references: what is moved meanwhile shows to no one."""
        self._now_s = 0.0
        self._ended_at_zero = False
        """Whether the last program had read zeros from all registers when it ended."""

    @cached_property
    def watch(self) -> Watch:
        """The judge of all motions from the first time on that it is asked for."""
        controller = dialect(self.config.connection.dialect).controller(self.config)
        return Watch(self.world, self.config, controller)

    # -- programs -------------------------------------------------------------------------------

    def connect(self, *, allow_restored: bool = False, automatic: bool = False, **more: Any) -> Arm:
        """Connect a new program in place of the last one."""
        self.pace = pace = ProgramTime(self.now_s, self.timeline)
        pace.on_kill = lambda: self.add_silence_bound("the program was killed")
        pace.advance_world = self.link.line.advance
        self.link.owner = self.disk.owner = pace
        self.link.reopen().read(self.now_s)  # drop what arrived without a program
        opened = getattr(self.twin.board, "opened", None)
        if opened is not None:  # some boards notice that their port is opened, and reset
            opened()
        self.program_ended()
        self.arm = arm = Arm(
            assemble(
                self.config,
                self.link,
                pace,
                simulated=True,
                record_store=RecordFile(STATE, self.disk),
                allow_restored=allow_restored,
                operator=self.twin.operator,
                rewiring=NewLink(self.link.reopen, automatic=automatic),
                **more,
            )
        )
        arm.twin = self.twin
        return arm

    def ready(self) -> Arm:
        """Connect a program, switch the motors on, and declare where the arm stands."""
        arm = self.connect()
        if arm.status.state is State.DISABLED:
            arm.enable()
        joints, opening_mm = self.posture()
        arm.reference.declare(joints, opening_mm=opening_mm)
        return arm

    def program_ended(self) -> None:
        """Note that no program drives the arm any more."""
        self._now_s = self.now_s
        if self.arm is not None:
            self._ended_at_zero = self.reads_zero
            self.arm = None

    def remove_killed_program(self) -> None:
        """Remove a program that was killed; the arm's time goes on."""
        self.program_ended()
        self.disk.owner = self.link.owner = None
        self.disk.kill_after = self.link.kill_after = None

    def suspend(self, by_s: float) -> None:
        """Suspend the program, as a computer does that sleeps."""
        if self.now_s < self.watch.evident_s:
            self.watch.evident_s += by_s
        self.add_silence_bound("the program stood still", by_s)
        self.pace.suspend(by_s)
        self.suspended_s += by_s

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
            self.timeline.run_due(self._now_s)
        self.look()

    # -- the person at the arm ------------------------------------------------------------------

    def turn_by_hand(self, steps: Motors) -> bool:
        """Turn motors at the arm's controls; return False if the arm is busy."""
        device = self.twin.device
        if device.moving or not device.powered:
            return False
        with self.world.by_itself():
            device.jog(steps)
        return True

    def place_by_hand(self, joints: Joints, opening_mm: float) -> None:
        """Bring the arm to a posture by hand."""
        with self.world.by_itself():
            if isinstance(self.twin.board, DrivesBoard):  # these would turn their shafts back
                self.twin.device.bring_to(joints, opening_mm)
            else:
                self.world.drive_to(self.world.body.transmission.to_motors(joints, opening_mm))

    def posture(self) -> tuple[Joints, float]:
        """Return the joint angles and the opening at which the physical arm stands."""
        return self.world.body.transmission.to_joints(self.look())

    # -- what happens ---------------------------------------------------------------------------

    def request(self, words: str) -> str:
        """Request a fault of the console; return the words, with the reason if it is refused."""
        self.look()
        try:
            self.twin.faults.ask(parse_words(words.split()))
        except BadRequest as error:
            return f"{words}: {error}"
        return words

    def strike(self, happening: Happening, draw: random.Random) -> str:
        """Let something happen, with numbers that are drawn; return its words."""
        drawn = happening.draw(draw, len(self.world.motors))
        self.look()
        match happening.effect:
            case Effect.DISTURBS:
                self.disturb(drawn.lasts_s)
            case Effect.UNCHECKED if not isinstance(self.twin.board, DrivesBoard | SimRobkoBoard):
                self.misdirect()
            case Effect.UNCHECKED if drawn.lasts_s:
                self.disturb(drawn.lasts_s)
            case Effect.MISDIRECTS:
                self.misdirect()
            case Effect.RESTARTS:
                self.restart(drawn.motors, drawn.lasts_s)
            case Effect.SLIPS if self.watch.closed_loop:
                self.watch.pardon(Excuse.MOTION)  # a shaft that comes free turns back
            case Effect.SLIPS:
                self.watch.pardon(Excuse.PATH)
                self.watch.hidden = True
            case Effect.STICKS:
                self.watch.hidden = self.watch.hidden or self.referencing
                self.watch.stuck_until_s = self.now_s + drawn.lasts_s
            case Effect.CUTS_OFF:
                self.add_silence_bound(happening.name)
        seed = draw.randrange(1 << 30)
        return self.request(f"{drawn.words} seed={seed}")

    def disturb(self, for_s: float) -> None:
        """Note that the device may miss orders, or get them late, and when that is over at last."""
        silent_s = 0.0 if self.arm is None else self.arm.status.silent_time_s
        self.watch.pardon(Excuse.PATH, for_s + silent_s + NOTICED_S)

    def misdirect(self) -> None:
        """Note that the device may do what its driver did not order."""
        self.watch.pardon(Excuse.MOTION)
        self.watch.hidden = self.watch.hidden or self.referencing

    def restart(self, motors: tuple[int, ...], for_s: float) -> None:
        """Note that motors lose their power for a time, and then count from zero.

        The next poll shows that, unless they had counted about as much before.
        """
        self.disturb(max(for_s, RESET_S))
        self.note_change()
        near = NEAR_ZERO if self.watch.closed_loop else 0
        counts = self.twin.device.registers
        if self.reads_zero or all(abs(counts[motor]) <= near for motor in motors):
            self.watch.hidden = True

    def note_change(self) -> None:
        """Note that the arm changes without a command: the next poll of the program shows it."""
        known_by_s = self.now_s + self.config.motion.idle_poll_s + POLLED_S
        self.watch.note_change(self.now_s, known_by_s)
        self.watch.hidden = self.watch.hidden or self.referencing

    @property
    def reads_zero(self) -> bool:
        """Whether the program last read zero from all registers."""
        if self.arm is None:
            return self._ended_at_zero
        position = self.arm.parts.core.position
        return not ((position.read_back or position.acknowledged) - position.offset).largest

    @property
    def no_faults(self) -> bool:
        """Whether no fault is active, none waits on the wire, and all have shown."""
        waits = math.isfinite(self.link.line.faults.late.next_s)
        return not (self.twin.faults.active or waits or self.now_s < self.watch.evident_s)

    def is_true(self) -> bool:
        """Return whether the program acknowledges the steps on which the motors stand."""
        assert self.arm is not None
        there = self.arm.status.acknowledged
        return there is not None and (self.look() - there).largest <= self.watch.on_the_step

    def forget_excuses(self, *, commanded: bool = True) -> None:
        """Judge by every law again, if no fault is at work and the position is right.

        If the driver does not trust it, the path of a new command is judged by no position.
        """
        if self.arm is None or not self.no_faults or self.twin.device.moving:
            return
        known = self.arm.parts.core.position_known
        if not (self.is_true() if known else commanded):
            return
        self.watch.forget_excuses()
        if known:
            self.watch.hidden = False

    # -- announced bounds -----------------------------------------------------------------------

    def add_bound(self, what: str, time_s: float, distance_mm: float) -> None:
        """Add a bound from now on."""
        self.look()
        self.watch.add_bound(Bound(what, self.now_s, self.world.tip, time_s, distance_mm))

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

    @property
    def trusted(self) -> bool:
        """Whether the program trusts its position."""
        return self.arm is not None and self.arm.status.trust in (Trust.REFERENCED, Trust.RESTORED)
