"""A bench: one dialect on one transport, and a view of the physical arm."""

from __future__ import annotations

import abc
import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Self

from armdrive.abilities import Abilities, Switching
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.dialog import Operator
from armdrive.registry import dialect
from armdrive.status import Current, State, Trust
from kinematics import Joints, Motors, Transmission

from .observation import ON_THE_STEP, Observation, Point, Standstill, check, place

QUIET_S = 0.6
"""An arm stands if it has not moved for this long."""
BEGINS_S = 10.0
"""Every motion is under way within this time, also on a slow wire."""


class Bench(abc.ABC):
    """One dialect on one transport. Behaviours use only this class, so that they run on each."""

    transport: ClassVar[str]
    real_time: ClassVar[bool]
    look_s: ClassVar[float]
    """The time between two looks at a moving arm."""
    noise_s: ClassVar[float]
    """How much a busy computer may add to an announced time."""
    punctual: ClassVar[bool] = True
    """Whether driver, device and test keep time well enough to check a bound."""
    fault_moments_s: ClassVar[tuple[float | None, ...]] = (None, 0.4)
    """When a fault strikes after the request of a motion, each in a motion of its own; None while
    the arm stands."""
    stops_after_s: ClassVar[tuple[float, ...]] = (0.03, 0.2, 0.55)
    """How long a motion lasts before it is stopped; each in a motion of its own."""
    on_bus: ClassVar[bool] = False
    """Whether the bench can have drives on a CAN bus."""
    bus_is_checked: ClassVar[bool] = True
    """Whether frames are checked on the whole way to the drives, as on a CAN bus itself."""
    simulated: ClassVar[bool] = True
    """Whether the arm is simulated, so that it can come to no harm and do none."""
    trusts_geometry: ClassVar[bool] = False
    """Whether the driver uses the arm's dimensions even if no one has verified them."""

    sees_outputs: ClassVar[bool] = True
    """Whether the bench sees fingers move that are wired to an output."""

    sees_motion: ClassVar[bool] = True
    """Whether the bench sees the motors while they turn."""

    @property
    def sees_current(self) -> bool:
        """Whether the bench sees if the motors have current."""
        return True

    @property
    def settles_steps(self) -> int:
        """How far a motor may turn when its current comes on after a restart."""
        return 0

    def __init__(self, dialect_name: str) -> None:
        self.row = dialect(dialect_name)
        self.arm: Arm | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the arm in tables, the most specific one first."""
        return (self.row.name,)

    # -- each transport's own -----------------------------------------------------------------

    @property
    @abc.abstractmethod
    def config(self) -> ArmConfig:
        """The configuration that the driver gets."""

    @abc.abstractmethod
    def _open(self, **options: Any) -> Arm:
        """Connect a driver."""

    @abc.abstractmethod
    def look(self) -> Observation:
        """Observe the physical arm now."""

    @abc.abstractmethod
    def sleep(self, time_s: float) -> None:
        """Let time pass, with or without a driver."""

    @abc.abstractmethod
    def operator(self) -> Operator:
        """Return an operator who brings the arm to its reference posture."""

    def open_another(self) -> Arm:
        """Connect a second driver while the first one is connected."""
        return self._open()

    @abc.abstractmethod
    def fault(self, words: str) -> None:
        """Inject a fault of the simulator's table."""

    def use_arm_file(self, lines: str) -> None:
        """Use an arm whose file has more `lines` of TOML than its preset."""
        raise NotImplementedError

    def turn_by_hand(self) -> bool:
        """Turn the motors by hand so that no register is zero, if that is quick; return if done."""
        return False

    def call_later(self, time_s: float, call: Callable[[], object]) -> None:
        """Call a function in `time_s`, from outside the driver, while the driver is in a call."""
        raise NotImplementedError

    def replug_elsewhere(self) -> None:
        """Put the cable back; the port has another name from now on."""
        raise NotImplementedError

    @abc.abstractmethod
    def heal(self) -> None:
        """End every fault: the wire works, and the power is on."""

    @property
    def abilities(self) -> Abilities:
        """What the controller can do with the settings of this arm."""
        return self.row.controller(self.config).abilities

    @property
    def board(self) -> type | None:
        """The class of the simulated board, which has its abilities; None for a real board."""
        return None

    # -- common to all benches ----------------------------------------------------------------

    def connect(self, **options: Any) -> Arm:
        """Connect a driver in place of the last one."""
        self.disconnect()
        self.arm = self._open(**options)
        return self.arm

    def ready(self, **options: Any) -> Arm:
        """Connect, switch the motors on, and reference the arm where it stands."""
        arm = self.connect(**options)
        self.reference(arm)
        return arm

    def reference(self, arm: Arm) -> None:
        """Declare the posture in which the physical arm stands, so that it can be moved."""
        self.switch_on(arm)
        joints, opening_mm = self.posture(self.look().motors)
        arm.reference.declare(joints, opening_mm=opening_mm)
        check(arm.status.trust is Trust.REFERENCED, "a declared posture was not taken")

    def switch_on(self, arm: Arm) -> None:
        """Switch the motors on, unless they surely hold or cannot be switched."""
        status = arm.status
        off = status.current is not Current.HELD and self.abilities.current is Switching.BOTH
        if off or status.state is State.DISABLED:
            arm.enable()

    def start_afresh(self) -> None:
        """Disconnect, and use an arm without a history if the bench can make one quickly."""
        self.disconnect()

    def disconnect(self) -> None:
        """Close the driver, if there is one."""
        arm, self.arm = self.arm, None
        if arm is not None:
            arm.close()

    def close(self) -> None:
        """Close the driver, and release what the bench uses."""
        self.disconnect()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        with contextlib.suppress(Exception) if error[0] else contextlib.nullcontext():
            self.close()

    @property
    def transmission(self) -> Transmission:
        """How the motors of the arm on the bench turn its joints."""
        transmission = self.config.model.transmission
        assert transmission is not None
        return transmission

    def posture(self, motors: Motors) -> tuple[Joints, float]:
        """Return the joint angles and the opening of the fingers at some motor steps."""
        return self.transmission.to_joints(motors)

    def tip(self, motors: Motors) -> Point:
        """Return the place of the tip at some motor steps."""
        return place(self.config.model.arm.fk(self.posture(motors)[0]))

    def step_mm(self, motors: Motors) -> float:
        """Return how far the tip is off at most if every motor is one step off."""
        here = self.tip(motors)
        count = len(motors)
        ones = (Motors(int(i == k) for i in range(count)) for k in range(count))
        return math.fsum(math.dist(here, self.tip(motors + one)) for one in ones)

    # -- watching -----------------------------------------------------------------------------

    def watch(self, done: Callable[[], bool], longest_s: float) -> Iterator[Observation]:
        """Yield observations until `done()`. Raises `Broken` after `longest_s`."""
        seen = self.look()
        end_s = seen.time_s + longest_s
        while True:
            yield seen
            if done():
                break
            check(seen.time_s < end_s, f"it had not ended after {longest_s:g} s")
            self.sleep(self.look_s)
            seen = self.look()

    def wait_until(self, done: Callable[[], bool], longest_s: float) -> None:
        """Let time pass until `done()`. Raises `Broken` after `longest_s`."""
        for _ in self.watch(done, longest_s):
            pass

    def wait_until_moving(self, keep: Callable[[], object] = lambda: None) -> None:
        """Wait until the physical arm moves; call `keep` at each look, to renew a held jog."""
        start = self.look().motors
        for _ in self.watch(lambda: self.look().motors != start, BEGINS_S):
            keep()

    def rest(self, start: Observation | None = None, longest_s: float = 30.0) -> Standstill:
        """Watch until the arm stands; return when it stopped, and how far the tip went.

        A sag without current does not count: no bound is announced for it.
        """
        first = last = moved = start or self.look()
        way_mm, sagged = 0.0, False

        def quiet() -> bool:
            return last.time_s - moved.time_s >= QUIET_S

        for last in self.watch(quiet, longest_s):
            sagged = sagged or (first.energised and not last.energised)
            way_mm = way_mm if sagged else max(way_mm, last.off_mm(first))
            if last.motors != moved.motors:
                moved = last
        return Standstill(moved.time_s - first.time_s, way_mm, moved)

    def check_stands(self, for_s: float, why: str) -> Observation:
        """Check that the arm does not move for a while."""
        before = self.look()
        self.sleep(for_s)
        after = self.look()
        check(
            before.motors == after.motors,
            f"{why}: the motors moved by {tuple(after.motors - before.motors)} steps",
        )
        return after

    @contextlib.contextmanager
    def check_unmoved(self, what: str) -> Iterator[None]:
        """Check that no motor has turned at the end of a block."""
        before = self.look().motors
        yield
        check(self.look().motors == before, f"{what} moved the arm")

    def check_trust(self, arm: Arm) -> None:
        """Check that a referenced arm stands where its status says."""
        status, seen = arm.status, self.look()
        if status.trust is not Trust.REFERENCED or status.acknowledged is None:
            return
        check(
            seen.off_steps(status.acknowledged) <= ON_THE_STEP,
            f"referenced at {tuple(status.acknowledged)}, but the motors stand at "
            f"{tuple(seen.motors)}",
        )
