"""What holds after every call of a mission, whatever has gone wrong meanwhile.

A call ends in time, with what was asked for or a typed error in words. A position that is trusted
is where the physical arm is, to a step, as far as the device gave any evidence. (That nothing
moves without a command, nor beyond a limit, a guard or an announced bound, is the watch's.)
"""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable

from armdrive.errors import ArmError
from armdrive.errors.table import entry
from armdrive.runtime.engine import CALL_LIMIT_S
from armdrive.runtime.overrides import LONGEST_SIMULATED_PAUSE_S
from armdrive.status import State, Trust
from kinematics import KinematicsError

from .clock import Hangs, Killed
from .physical import Aim, Command
from .stage import Stage

LONGEST_S = CALL_LIMIT_S + 0.1
"""No call that moves nothing lasts longer, whatever is wrong with the wire: the driver's own limit,
and the turn in which it is kept."""
FLAWS = ("looped without waiting", "simulated time is stuck")
"""Words of errors by which the driver ends what hangs; no program should ever meet them."""

FRESH_S = 0.4
"""A motion that ends has looked at the registers so long ago."""

TRUSTED = (Trust.REFERENCED, Trust.RESTORED)
Typed = ArmError | KinematicsError


class Broken(Exception):
    """A promise is not kept: the mission ends."""


def call(
    stage: Stage,
    act: Callable[[], object],
    command: Command | None = None,
    longest_s: float = LONGEST_S,
) -> Typed | None:
    """Make a call under the laws; return the error with which it ended, if it did.

    Without a command nothing may move. Raises `Broken`, and `Killed` where the program was ended.
    """
    stage.look()
    arm, began_s, runs_on_s = stage.arm, stage.now_s, 0.0
    if command is not None:
        assert arm is not None
        motion = stage.config.motion
        burst_s = max(motion.planned_burst_s, motion.jog_burst_s)
        runs_on_s = arm.core.controller.stopping(burst_s).silent_s
        turned = stage.watch.turned
        turns_back = turned is not None and stage.now_s <= turned.until_s
        if stage.twin.device.moving or turns_back:
            # where it comes to rest decides where the command begins
            command.span = command.aim = None
        stage.watch.begin(command)
    if arm is not None and arm.paused and command is not None:
        longest_s += LONGEST_SIMULATED_PAUSE_S  # it waits, and is given up then
    name = command.what if command is not None else getattr(act, "__qualname__", "a call")
    stage.agenda.patience.begin(name, stage.now_s + longest_s)
    error: Typed | None = None
    result: object = None
    stage.jumped_s = 0.0
    try:
        result = act()
    except (ArmError, KinematicsError) as typed:
        error = typed
        said_well(typed)
    except Killed:
        stage.bury()
        if command is not None:
            stage.watch.end(stage.now_s, runs_on_s)
        raise
    except Hangs as hangs:
        raise Broken(f"hangs: {hangs}") from None
    except Exception:
        raise Broken(f"a traceback: {traceback.format_exc(limit=-4)}") from None
    finally:
        stage.agenda.patience.end()
    if command is not None:
        stage.watch.end(stage.now_s, runs_on_s if error else 0.0)
    stage.look()
    took_s = stage.now_s - began_s
    if took_s > longest_s + stage.jumped_s:
        raise Broken(f"it lasted {took_s:.1f} s, and its deadline was {longest_s:.1f} s")
    honest(stage, strict=command is not None and command.verified and error is None)
    if error is None and command is not None and command.aim is not None:
        arrived(stage, command, command.aim, result)
    return error


def arrived(stage: Stage, command: Command, aim: Aim, result: object) -> None:
    """Check that a call that ended well has brought the physical arm where it was asked to.

    A program that was suspended during the call has looked that much earlier.
    """
    watch = stage.watch
    excused = watch.with_coupled(watch.adrift)
    if not command.verified or stage.now_s - stage.jumped_s <= watch.changed_s + FRESH_S:
        # it had ended by then, perhaps
        excused |= watch.with_coupled(watch.disturbed | watch.sagged)
    if missed := aim.missed(stage.world, result, excused):
        raise Broken(f"{command.what} ended well, but {missed}")


def said_well(error: Typed) -> None:
    """Check that an error has words, and a row in the catalogue."""
    if not str(error):
        raise Broken(f"{type(error).__name__} says nothing")
    if any(words in str(error) for words in FLAWS):
        raise Broken(f"hangs: {error}")
    if not entry(error).code:
        raise Broken(f"{type(error).__name__} has no code")


def honest(stage: Stage, *, strict: bool = False) -> None:
    """Check that a trusted position is where the arm is; `strict` where it was just verified."""
    kept(stage)
    arm = stage.arm
    if arm is None or stage.twin.device.moving or not arm.engine.at_rest:
        return
    status = arm.status
    if status.state is State.DISCONNECTED or status.trust not in TRUSTED:
        return
    changed_s = stage.watch.changed_s
    if status.state in (State.ERROR_STOP, State.DISABLED) and changed_s > -math.inf:
        return  # nobody looks before it is reset or enabled, and nothing can be moved by plans
    seen = stage.now_s >= stage.watch.evidence_by_s
    if not seen and not (strict and stage.now_s > changed_s + FRESH_S):
        return
    there, here = status.acknowledged, stage.look()
    assert there is not None
    off = {
        motor: real - told
        for motor, (real, told) in enumerate(zip(here, there, strict=True))
        if abs(real - told) > stage.watch.on_the_step and motor not in stage.watch.unknowable
    }
    if off:
        raise Broken(
            f"{status.trust.value} ({status.trust_reason}) at {tuple(there)}, but the motors stand "
            f"at {tuple(here)}"
        )


def kept(stage: Stage) -> None:
    """Raise `Broken` for what the watch has seen."""
    if stage.watch.broken:
        raise Broken("; ".join(stage.watch.broken))
