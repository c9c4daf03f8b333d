"""Sets up the drives of an arm on a CAN bus, one after the other.

New MKS drives get their ids and settings, which the drives keep themselves: a person who leaves
can continue later with the drives that are not ready. CiA 402 drives have theirs from their makers'
programs: of them, the units of speed and ramps are measured. In which direction and how far motors
turn their joints is found with the whole arm (`arm_checks`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialects import Dialect
from armdrive.dialects.bus.tools import (
    BusTools,
    CommissioningTools,
    DriveDialog,
    DrivePlace,
    Listened,
    frame_scripts,
    listen,
)
from armdrive.dialects.controller import Controller
from armdrive.dialects.exchange import ScriptLoop
from armdrive.errors import BadRequest
from armdrive.registry import DIALECTS, language_of
from armdrive.setup.directions import trial_of
from armdrive.setup.prober import is_command
from armdrive.sim.world.body import found_posture
from armdrive.tasks import (
    Done,
    MeasuredUnits,
    MeasureUnits,
    Reply,
    RequestRejected,
    SwitchOn,
    Timeout,
)
from kinematics.text import counted


@dataclass(frozen=True, slots=True)
class CommissioningPlan:
    """An arm and its drives, in the order of its motors."""

    config: ArmConfig
    drives: tuple[DrivePlace, ...]
    bus: BusTools
    tools: CommissioningTools

    def scripts(self) -> ScriptLoop[Any]:
        """Return a loop of scripts that reaches these drives, and a new one."""
        return self.bus.scripts(sorted({self.tools.new_id, *(each.node for each in self.drives)}))

    @property
    def order(self) -> tuple[DrivePlace, ...]:
        """The drives in the order of commissioning: the one with the id of a new drive comes last.

        So each new drive can be plugged in while those with their own ids stay on the bus.
        """
        return tuple(sorted(self.drives, key=lambda each: each.node == self.tools.new_id))


def commissionable() -> tuple[Dialect, ...]:
    """Return the dialects whose drives can be commissioned."""
    return tuple(row for row in DIALECTS.values() if row.bus and row.bus.commissioning)


def plan_of(config: ArmConfig) -> CommissioningPlan:
    """Return the plan for an arm. Raises `BadRequest` for one without drives on a CAN bus."""
    transmission, ids = config.model.transmission, getattr(config.device, "ids", ())
    spoken = config.connection.dialect
    bus = DIALECTS[spoken].bus
    tools = None if bus is None else bus.commissioning
    if transmission is None or bus is None or tools is None:
        known = commissionable()
        titles = " or ".join(language_of(each.name).title for each in known)
        lines = " or ".join(f'dialect = "{each.name}"' for each in known)
        raise BadRequest(
            f"{config.name} has no {titles}: `armdrive can setup` is for arm files that say "
            f"{lines} under [connection]"
        )
    names = [motor.name for motor in transmission.motors]
    if len(ids) < len(names):
        raise BadRequest(
            f"{spoken}.ids names {counted(len(ids), 'drive')}, and the arm has "
            f"{counted(len(names), 'motor')}: give each its own"
        )
    places = zip(names, ids, strict=False)
    drives = tuple(DrivePlace(motor, name, node) for motor, (name, node) in enumerate(places))
    return CommissioningPlan(config, drives, bus, tools)


@dataclass(frozen=True, slots=True)
class CommissioningOutcome:
    """The result: the current in mA of each motor that is ready, 0 if it is not known.

    Also the motors left out, and those whose drives were missing at the end.
    """

    currents_ma: Mapping[str, int]
    left_out: tuple[str, ...]
    missing: tuple[str, ...] = ()

    @property
    def finished(self) -> bool:
        """Whether every drive is set up and answers."""
        return not self.left_out and not self.missing


def commission(
    dialog: DriveDialog, plan: CommissioningPlan, *, again: bool = False
) -> CommissioningOutcome:
    """Commission every drive of an arm; those that are ready are left alone, unless `again`."""
    _introduce(dialog, plan)
    if _others_command(dialog):
        return CommissioningOutcome({}, tuple(each.name for each in plan.drives))
    currents_ma, left_out = {}, []
    for drive in plan.order:
        dialog.say("", f"--- {drive.name} (drive {drive.node})")
        current_ma = plan.tools.set_up(dialog, plan.config, drive, again)
        if current_ma is None:
            left_out.append(drive.name)
        else:
            currents_ma[drive.name] = current_ma
    # drives that were left out cannot answer, and are named already
    missing = () if left_out else ask_together(dialog, plan)
    return CommissioningOutcome(currents_ma, tuple(left_out), missing)


def _introduce(dialog: DriveDialog, plan: CommissioningPlan) -> None:
    listed = ", ".join(f"{each.node} {each.name}" for each in plan.drives)
    dialog.say(
        f"Commissioning {counted(len(plan.drives), 'drive')} of {plan.config.name}: {listed}.",
        "For each of them:",
        *(f"  {number}  {step}" for number, step in enumerate(plan.tools.steps, 1)),
        "Nothing is written and nothing turns without your yes, and each question says what will "
        "happen. Ctrl-C leaves at any time: drives keep what was written to them, and the same "
        "command continues from there.",
        plan.tools.caution,
    )


def _others_command(dialog: DriveDialog) -> bool:
    """Return whether another program commands drives on this bus, and tell the user."""
    frames = frame_scripts()
    traffic: Listened = dialog.carry_out(frames, partial(listen, frames.io, is_command))
    if traffic.commands:
        dialog.say(
            "Another program commands drives on this bus: end it first, then begin again. "
            "`armdrive can monitor` shows what it sends. Nothing was asked or set."
        )
    return bool(traffic.commands)


def ask_together(dialog: DriveDialog, plan: CommissioningPlan) -> tuple[str, ...]:
    """Ask all drives once they are plugged in; return the names of those that do not answer."""
    dialog.say("", "--- all together")
    while True:
        if not dialog.agreed(
            f"Is everything plugged in, {counted(len(plan.drives), 'drive')} in all? Then they are "
            "asked together; nothing turns.",
            "no ends here; the arm file can still be written.",
        ):
            return tuple(each.name for each in plan.drives)
        alone = partial(dialog.on_wire, plan.tools.alone)
        wrong = [drive for drive in plan.drives if not alone(drive.node)]
        if not wrong:
            dialog.say(f"All answer: {counted(len(plan.drives), 'drive')}, each under its own id.")
            return ()
        named = ", ".join(f"{each.name} (drive {each.node})" for each in wrong)
        dialog.say(
            f"Not there, or two drives with one id: {named}. The whole bus needs a resistor of 120 "
            "ohm at each of its two ends, and nowhere else."
        )


# The units in which drives count speeds and ramps: each motor turns a little, slowly, and back.


def measure_units(
    dialog: DriveDialog, config: ArmConfig, controller: Controller
) -> tuple[MeasuredUnits, ...]:
    """Measure the units of every drive of an arm, in the order of its motors.

    Returns none at all if the user declines, or if one of them cannot be measured. The motors stay
    on. One question comes before all turns, since drives stop once this program has not sent its
    heartbeat for a while.
    """
    arm, transmission = config.model.arm, config.transmission
    posture, motors = found_posture(arm), range(len(transmission.motors))
    tried = [trial_of(arm, transmission, posture, motor) for motor in motors]
    dialog.say(
        f"Measuring in which units the {counted(len(tried), 'drive')} of {config.name} count "
        "speeds and ramps. One motor after the other turns slowly, for about ten seconds: by 5° "
        "of its joint at most, usually far less, and back. The others hold. Have the arm stand "
        "clear of everything, and keep a hand at the power switch. Ctrl-C stops.",
    )
    if not dialog.agreed(
        "Switch the motors on and begin?", "Anything but yes leaves the arm alone."
    ):
        return ()
    reply = dialog.carry_out(controller, SwitchOn())
    found: list[MeasuredUnits] = []
    if not isinstance(reply, Done):
        dialog.say(f"The motors were not switched on: {_why(reply)}.")
        return ()
    for trial in tried:
        reply = dialog.carry_out(controller, MeasureUnits(trial.motor, trial.steps))
        if not isinstance(reply, MeasuredUnits):
            dialog.say(f"The {trial.name} was not measured: {_why(reply)}.")
            return ()
        dialog.say(f"{trial.name}: {reply}.")
        found.append(reply)
    return tuple(found)


def _why(reply: Reply) -> str:
    """Return why a request was not carried out."""
    if isinstance(reply, Timeout):
        return "it does not answer"
    return reply.reason if isinstance(reply, RequestRejected) else str(reply)
