"""A bench: one dialect on one transport, and a person who sees the arm that stands on it."""

from __future__ import annotations

import abc
import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

from armdrive.abilities import Abilities, Switching
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.dialog.operator import Operator
from armdrive.registry import dialect
from armdrive.status import Current, State, Trust
from kinematics import Joints, Motors

from .seen import ON_THE_STEP, Point, Rest, Seen, check

QUIET_S = 0.6
"""An arm that has not moved for this long stands."""


class Bench(abc.ABC):
    """One dialect on one transport. Behaviours ask it alone, so that they run on all of them."""

    transport: ClassVar[str]
    real_time: ClassVar[bool]
    look_s: ClassVar[float]
    """How often the arm is looked at while it moves."""
    noise_s: ClassVar[float]
    """What a busy computer may add to a time that was announced."""
    punctual: ClassVar[bool] = True
    """Whether driver, device and test keep time well enough to be held to a bound."""
    moments_s: ClassVar[tuple[float, ...]] = (0.4,)
    """When a fault comes, after a motion has been asked for: one time after the other."""
    stops_after_s: ClassVar[tuple[float, ...]] = (0.03, 0.2, 0.55)
    """How long a motion has been seen before it is stopped: one time after the other."""
    on_bus: ClassVar[bool] = False
    """Whether drives on a CAN bus can stand on it as well."""
    simulated: ClassVar[bool] = True
    """Whether the arm itself is one that nobody can hurt or be hurt by."""
    knows_geometry: ClassVar[bool] = False
    """Whether the driver takes the arm's numbers for true, whoever has verified them."""

    sees_outputs: ClassVar[bool] = True
    """Whether fingers that hang on an output are seen to move."""

    sees_motion: ClassVar[bool] = True
    """Whether the motors are seen while they turn."""

    @property
    def sees_current(self) -> bool:
        """Whether motors without current are told from those that are held."""
        return True

    def __init__(self, dialect_name: str) -> None:
        self.row = dialect(dialect_name)
        self.arm: Arm | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What the arm goes by in tables, the most particular name first."""
        return (self.row.name,)

    # -- what a transport says ----------------------------------------------------------------

    @property
    @abc.abstractmethod
    def config(self) -> ArmConfig:
        """The arm, as the driver is told of it."""

    @abc.abstractmethod
    def _open(self, **options: Any) -> Arm:
        """Connect a driver."""

    @abc.abstractmethod
    def look(self) -> Seen:
        """Look at the physical arm."""

    @abc.abstractmethod
    def sleep(self, time_s: float) -> None:
        """Let time pass, with or without a driver."""

    @abc.abstractmethod
    def operator(self) -> Operator:
        """Return somebody who sees the arm and brings it to its reference posture."""

    def open_another(self) -> Arm:
        """Have another program connect as well."""
        return self._open()

    @abc.abstractmethod
    def fault(self, words: str) -> None:
        """Have a fault of the simulator's table happen."""

    def fit(self, lines: str) -> None:
        """Put an arm on the bench whose file says more than its preset: `lines` of TOML."""
        raise NotImplementedError

    def later(self, time_s: float, call: Callable[[], object]) -> None:
        """Have something done by somebody else while a call waits."""
        raise NotImplementedError

    def replug_elsewhere(self) -> None:
        """Have the cable put back, and the port be called by another name from then on."""
        raise NotImplementedError

    @abc.abstractmethod
    def heal(self) -> None:
        """Undo every fault: the wire carries all again, and the power is on."""

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do, by the settings of this arm."""
        return self.row.controller(self.config).abilities

    @property
    def board(self) -> type | None:
        """The class of the simulated board, which tells what it can do; None of a real one."""
        return None

    # -- what every bench does alike ----------------------------------------------------------

    def connect(self, **options: Any) -> Arm:
        """Connect a driver in place of the last one."""
        self.leave()
        self.arm = self._open(**options)
        return self.arm

    def ready(self, **options: Any) -> Arm:
        """Connect, switch the motors on and say where the arm is, as a person sees it."""
        arm = self.connect(**options)
        self.refer(arm)
        return arm

    def refer(self, arm: Arm) -> None:
        """Make an arm ready for planned motion, by the posture in which it is seen to stand."""
        self.switch_on(arm)
        joints, opening_mm = self.posture(self.look().motors)
        arm.declare_posture(joints, opening_mm=opening_mm)
        check(arm.status.trust is Trust.REFERENCED, "a declared posture was not taken")

    def switch_on(self, arm: Arm) -> None:
        """Switch the motors on, where that can be done and they are not held for certain."""
        status = arm.status
        off = status.current is not Current.HELD and self.abilities.current is Switching.BOTH
        if off or status.state is State.DISABLED:
            arm.enable()

    def begin_anew(self) -> None:
        """Begin with an arm as one finds it in the morning, where that costs nothing."""
        self.leave()

    def leave(self) -> None:
        """Close the driver, if there is one."""
        arm, self.arm = self.arm, None
        if arm is not None:
            arm.close()

    def close(self) -> None:
        """Take the bench down."""
        self.leave()

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *error: object) -> None:
        with contextlib.suppress(Exception) if error[0] else contextlib.nullcontext():
            self.close()

    def posture(self, motors: Motors) -> tuple[Joints, float]:
        """Return the joints and the pull of the fingers at which motors stand."""
        transmission = self.config.model.transmission
        assert transmission is not None
        return transmission.to_joints(motors)

    def tip(self, motors: Motors) -> Point:
        """Return where motors have the tip."""
        pose = self.config.model.arm.fk(self.posture(motors)[0])
        return pose.x_mm, pose.y_mm, pose.z_mm

    def step_mm(self, motors: Motors) -> float:
        """Return how far the tip is off at most where every motor is one step off."""
        here = self.tip(motors)
        count = len(motors)
        ones = (Motors(int(i == k) for i in range(count)) for k in range(count))
        return math.fsum(math.dist(here, self.tip(motors + one)) for one in ones)

    # -- watching -----------------------------------------------------------------------------

    def watch(self, done: Callable[[], bool], longest_s: float) -> Iterator[Seen]:
        """Look at the arm again and again until `done()`; a check fails after `longest_s`."""
        seen = self.look()
        end_s = seen.time_s + longest_s
        while True:
            yield seen
            if done():
                break
            check(seen.time_s < end_s, f"it had not ended after {longest_s:g} s")
            self.sleep(self.look_s)
            seen = self.look()

    def rest(self, start: Seen | None = None, longest_s: float = 30.0) -> Rest:
        """Watch until the arm has stood for a while; say when it stopped, and how far off.

        Where it sags, since it was switched off, nobody has announced how far.
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
        return Rest(moved.time_s - first.time_s, way_mm, moved)

    def stands(self, for_s: float, why: str) -> Seen:
        """Check that the arm does not move for a while."""
        before = self.look()
        self.sleep(for_s)
        after = self.look()
        check(
            before.motors == after.motors,
            f"{why}: the motors moved by {tuple(after.motors - before.motors)} steps",
        )
        return after

    def honest(self, arm: Arm) -> None:
        """Check that a referenced arm stands where it says that it stands."""
        status, seen = arm.status, self.look()
        if status.trust is not Trust.REFERENCED or status.acknowledged is None:
            return
        check(
            seen.off_steps(status.acknowledged) <= ON_THE_STEP,
            f"referenced at {tuple(status.acknowledged)}, but the motors stand at "
            f"{tuple(seen.motors)}",
        )
