"""The laws that hold after every call, whatever has happened.

- The call ends in time, with its result or with a typed error that has words.
- A successful call has brought the arm to its goal.
- A trusted position is where the motors stand, to a step, as soon as the device could give evidence
  of a change.
- No law of motion was broken during the call (`watch`).
"""

import math
import traceback
from collections.abc import Callable

from armdrive.errors import ArmError, LinkError
from armdrive.errors.table import entry
from armdrive.runtime.engine import CALL_LIMIT_S
from armdrive.runtime.overrides import LONGEST_SIMULATED_WAIT_S
from armdrive.runtime.stop_bounds import homing_bound
from armdrive.status import State
from kinematics import KinematicsError
from tests.conformance.observation import Broken, check

from .program import Hang, ProgramKilled
from .stage import Stage
from .watch import Command, Excuse

LONGEST_S = CALL_LIMIT_S + 0.1
"""The longest that a call without motion may take: the driver's own limit, and one engine turn."""
HANG_MESSAGES = ("looped without waiting", "simulated time is stuck")
"""Parts of the errors with which the driver ends a call that hangs; no call should end so."""
FRESH_S = 0.4
"""A motion that ends has read the registers within this time."""

TypedError = ArmError | KinematicsError


def call(
    stage: Stage,
    act: Callable[[], object],
    command: Command | None = None,
    longest_s: float = LONGEST_S,
    *,
    references: bool = False,
) -> TypedError | None:
    """Make a call and check the laws after it; return the error that it raised, if any.

    Without a command nothing may move. `references`: the call reads where the arm stands. Raises
    `Broken` if a law was broken, and `ProgramKilled` if the program was killed during the call.
    """
    stage.look()
    stage.forget_excuses(commanded=command is not None)
    arm, began_s, runs_on_s, stops_s = stage.arm, stage.now_s, 0.0, 0.0
    if command is not None:
        assert arm is not None
        motion, controller = stage.config.motion, arm.parts.core.controller
        burst_s = max(motion.planned_burst_s, motion.jog_burst_s)
        runs_on_s = stops_s = controller.stopping(burst_s).silent_s
        if command.homes and (bound := homing_bound(stage.config, controller)) is not None:
            runs_on_s = max(runs_on_s, bound.silent_time_s)
        if stage.twin.device.moving:  # where it comes to rest is not known yet, nor how fast it is
            command.span, command.reaches, command.speed = None, None, 1.0
        stage.watch.begin(command)
        if arm.status.paused:
            longest_s += LONGEST_SIMULATED_WAIT_S  # the driver gives up the call after this time
    name = command.what if command is not None else getattr(act, "__qualname__", "a call")
    stage.timeline.begin_call(name, stage.now_s + longest_s)
    error: TypedError | None = None
    result: object = None
    stage.suspended_s, stage.referencing = 0.0, references
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
    except Broken:
        raise
    except Exception:
        raise Broken(f"a traceback: {traceback.format_exc(limit=-4)}") from None
    finally:
        stage.timeline.end_call()
        stage.referencing = False
    if command is not None:
        if not isinstance(error, LinkError):
            runs_on_s = stops_s if error else 0.0
        stage.watch.end(stage.now_s, runs_on_s)
    stage.look()
    took_s = stage.now_s - began_s
    if took_s > longest_s + stage.suspended_s:
        raise Broken(f"it lasted {took_s:.1f} s, and its deadline was {longest_s:.1f} s")
    check_trust(stage, strict=command is not None and command.verified and error is None)
    if error is None and command is not None and command.reaches is not None:
        watch = stage.watch
        judged = watch.excuse is Excuse.NOTHING and not watch.hidden
        wrong = command.reaches(stage.world, result) if judged else ""
        check(not wrong, f"{command.what} ended well, but {wrong}")
    return error


def check_error(error: TypedError) -> None:
    """Check that an error has words, has a code, and is not one that ends a hang."""
    check(bool(str(error)), f"{type(error).__name__} says nothing")
    check(not any(words in str(error) for words in HANG_MESSAGES), f"hangs: {error}")
    check(bool(entry(error).code), f"{type(error).__name__} has no code")


def check_trust(stage: Stage, *, strict: bool = False) -> None:
    """Check that a trusted position is where the motors stand.

    A change may be unknown until the driver could see evidence of it; `strict` if the driver has
    just verified the position.
    """
    watch = stage.watch
    check(not watch.broken, "; ".join(watch.broken))
    arm = stage.arm
    if arm is None or stage.twin.device.moving or not arm.parts.engine.at_rest or watch.hidden:
        return
    status = arm.status
    if status.state is State.DISCONNECTED or not stage.trusted:
        return
    if status.state in (State.ERROR_STOP, State.DISABLED) and math.isfinite(watch.changed_s):
        return  # the driver polls again after a reset or enable, before any planned motion
    evident = stage.now_s >= watch.evident_s
    if evident or (strict and stage.now_s > watch.changed_s + FRESH_S):
        check(
            stage.is_true(),
            f"{status.trust.value} ({status.trust_reason}) at {status.acknowledged}, but the "
            f"motors stand at {tuple(stage.look())}",
        )
