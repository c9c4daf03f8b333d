"""The laws that hold after every call of a mission, whatever faults have struck.

- The call ends in time, with its result or with a typed error that has words (`call`).
- A successful call has brought the arm to its goal (`check_arrival`).
- A trusted position is where the motors stand, to a step, as soon as the device could give evidence
  of a change (`check_trust`).
- No law of motion was broken during the call (`check_watch`; `physical` has these laws).
"""

import math
import traceback
from collections.abc import Callable

from armdrive.errors import ArmError, LinkError
from armdrive.errors.table import entry
from armdrive.runtime.engine import CALL_LIMIT_S
from armdrive.runtime.overrides import LONGEST_SIMULATED_WAIT_S
from armdrive.runtime.stop_bounds import homing_bound
from armdrive.status import State, Trust
from kinematics import KinematicsError

from .clock import Hang, ProgramKilled
from .physical import Aim, Command
from .stage import Stage

LONGEST_S = CALL_LIMIT_S + 0.1
"""The longest that a call without motion may take: the driver's own limit, and one engine turn."""
HANG_MESSAGES = ("looped without waiting", "simulated time is stuck")
"""Parts of the errors with which the driver ends a call that hangs; no call should end so."""

FRESH_S = 0.4
"""A motion that ends has read the registers within this time."""

TRUSTED = (Trust.REFERENCED, Trust.RESTORED)
TypedError = ArmError | KinematicsError


class Broken(Exception):
    """A law was broken; the mission ends."""


def call(
    stage: Stage,
    act: Callable[[], object],
    command: Command | None = None,
    longest_s: float = LONGEST_S,
) -> TypedError | None:
    """Make a call and check the laws after it; return the error that it raised, if any.

    Without a command nothing may move. Raises `Broken` if a law was broken, and `ProgramKilled` if
    the program was killed during the call.
    """
    stage.look()
    if stage.no_faults and not stage.twin.device.moving:
        stage.watch.doubts.late_s = 0.0  # the late message has come, and what it moved stands
    arm, began_s, runs_on_s, stops_s = stage.arm, stage.now_s, 0.0, 0.0
    if command is not None:
        assert arm is not None
        motion = stage.config.motion
        burst_s = max(motion.planned_burst_s, motion.jog_burst_s)
        controller = arm.parts.core.controller
        runs_on_s = stops_s = controller.stopping(burst_s).silent_s
        if command.homes and (bound := homing_bound(stage.config, controller)) is not None:
            runs_on_s = max(runs_on_s, bound.silent_time_s)
        if stage.twin.device.moving or stage.now_s <= stage.watch.may_turn_back_until_s:
            # the command begins where the arm comes to rest, which is not known yet
            command.span = command.aim = None
        stage.watch.begin(command)
    if arm is not None and arm.status.paused and command is not None:
        longest_s += LONGEST_SIMULATED_WAIT_S  # the driver gives up the call after this time
    name = command.what if command is not None else getattr(act, "__qualname__", "a call")
    stage.schedule.deadlines.begin(name, stage.now_s + longest_s)
    error: TypedError | None = None
    result: object = None
    stage.suspended_s = 0.0
    try:
        result = act()
    except (ArmError, KinematicsError) as typed:
        error = typed
        check_error(typed)
    except ProgramKilled:
        stage.remove_killed_program()
        if command is not None:
            stage.watch.end(stage.now_s, runs_on_s)
        raise
    except Hang as hangs:
        raise Broken(f"hangs: {hangs}") from None
    except Exception:
        raise Broken(f"a traceback: {traceback.format_exc(limit=-4)}") from None
    finally:
        stage.schedule.deadlines.end()
    if command is not None:
        if not isinstance(error, LinkError):
            runs_on_s = stops_s if error else 0.0
        stage.watch.end(stage.now_s, runs_on_s)
    stage.look()
    took_s = stage.now_s - began_s
    if took_s > longest_s + stage.suspended_s:
        raise Broken(f"it lasted {took_s:.1f} s, and its deadline was {longest_s:.1f} s")
    check_trust(stage, strict=command is not None and command.verified and error is None)
    if error is None and command is not None and command.aim is not None:
        check_arrival(stage, command, command.aim, result)
    return error


def check_arrival(stage: Stage, command: Command, aim: Aim, result: object) -> None:
    """Check that a successful call has brought the physical arm to its goal.

    A program that was suspended during the call has read the registers earlier by that time.
    """
    watch = stage.watch
    excused = watch.with_coupled(watch.doubts.unknown)
    if not command.verified or stage.now_s - stage.suspended_s <= watch.doubts.changed_s + FRESH_S:
        # the motion may have ended before the change
        excused |= watch.with_coupled(watch.moved_in_command)
    if missed := aim.missed(stage.world, result, excused):
        raise Broken(f"{command.what} ended well, but {missed}")


def check_error(error: TypedError) -> None:
    """Check that an error has words, has a code, and is not one that ends a hang."""
    if not str(error):
        raise Broken(f"{type(error).__name__} says nothing")
    if any(words in str(error) for words in HANG_MESSAGES):
        raise Broken(f"hangs: {error}")
    if not entry(error).code:
        raise Broken(f"{type(error).__name__} has no code")


def check_trust(stage: Stage, *, strict: bool = False) -> None:
    """Check that a trusted position is where the motors stand.

    A change may be unknown until the driver could see evidence of it; `strict` if the driver has
    just verified the position.
    """
    check_watch(stage)
    arm = stage.arm
    if arm is None or stage.twin.device.moving or not arm.parts.engine.at_rest:
        return
    status = arm.status
    if status.state is State.DISCONNECTED or status.trust not in TRUSTED:
        return
    doubts = stage.watch.doubts
    if status.state in (State.ERROR_STOP, State.DISABLED) and doubts.changed_s > -math.inf:
        return  # the driver polls again after a reset or enable, before any planned motion
    evident = stage.now_s >= doubts.evident_s
    if not evident and not (strict and stage.now_s > doubts.changed_s + FRESH_S):
        return
    there, here = status.acknowledged, stage.look()
    assert there is not None
    off = {
        motor: real - trusted
        for motor, (real, trusted) in enumerate(zip(here, there, strict=True))
        if abs(real - trusted) > stage.watch.on_the_step and motor not in doubts.unknown
    }
    if off:
        raise Broken(
            f"{status.trust.value} ({status.trust_reason}) at {tuple(there)}, but the motors stand "
            f"at {tuple(here)}"
        )


def check_watch(stage: Stage) -> None:
    """Raise `Broken` if the watch has seen a violation."""
    if stage.watch.broken:
        raise Broken("; ".join(stage.watch.broken))
