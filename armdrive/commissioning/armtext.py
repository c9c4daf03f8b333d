"""From what was found to the arm's file: a new one, or the present one with what differs.

A file that is there is written anew from its own table, so that its comments go; the command keeps
the old text beside it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any

from armdrive.armfile import ArmConfig
from armdrive.commissioning.notes import Notes
from armdrive.commissioning.plan import MM, Plan
from armdrive.interview.signs import Seen, Signs, conclude
from armdrive.interview.toml_text import Entry, Section, document
from firmware_protocol.mks import COUNTS_PER_TURN

DIGITS = 9


def signs_of(plan: Plan, notes: Mapping[str, Notes]) -> Signs:
    """Return which directions are reversed, of the motors that were tried."""
    tried = [(each, notes[each.name]) for each in plan.drives if _was_tried(notes, each.name)]
    seen = [Seen(drive.trial, noted.way, noted.roll) for drive, noted in tried]
    return conclude(seen, plan.roll_joint)


def _was_tried(notes: Mapping[str, Notes], name: str) -> bool:
    return name in notes and bool(notes[name].way)


def merged(config: ArmConfig, plan: Plan, notes: Mapping[str, Notes], port: str) -> dict[str, Any]:
    """Return the table of the arm's file with everything that was found."""
    table: dict[str, Any] = copy.deepcopy(dict(config.source.table if config.source else {}))
    wire = table.setdefault("connection", {})
    wire["dialect"] = config.connection.dialect
    if port:
        wire["port"] = port
    _put_device(table, plan, notes)
    signs = signs_of(plan, notes)
    gears = {each.name: notes[each.name].gear for each in plan.drives if each.name in notes}
    per_unit = {name: COUNTS_PER_TURN * gear for name, gear in gears.items() if gear}
    if "motors" in table:
        _put_motors(table["motors"], per_unit, signs)
    else:
        _put_preset(table, plan, per_unit, signs)
    return table


def _put_device(table: dict[str, Any], plan: Plan, notes: Mapping[str, Notes]) -> None:
    device = table.setdefault("mks", {})
    device["ids"] = [each.node for each in plan.drives]
    device["watchdog_s"] = plan.device.watchdog_s
    device["microsteps"] = plan.device.microsteps
    currents = {each.current_ma for each in notes.values() if each.current_ma}
    if len(currents) == 1 and len(notes) == len(plan.drives):
        device["current_ma"] = currents.pop()


def _put_preset(
    table: dict[str, Any], plan: Plan, per_unit: Mapping[str, float], signs: Signs
) -> None:
    pulling = {each.name for each in plan.drives if each.unit == MM}
    for name, steps in per_unit.items():
        if name in pulling:
            table["steps_per_mm"] = _short(steps)
        else:
            table.setdefault("steps_per_turn", {})[name] = _short(steps)
    for section, names in (("motor_signs", signs.motors), ("joint_signs", signs.joints)):
        for name in names:
            known = table.setdefault(section, {})
            known[name] = -known.get(name, 1)


def _put_motors(motors: list[dict[str, Any]], per_unit: Mapping[str, float], signs: Signs) -> None:
    for motor in motors:
        name = str(motor.get("name"))
        if name in per_unit:
            key = "steps_per_mm" if "steps_per_mm" in motor else "steps_per_turn"
            motor[key] = _short(per_unit[name])
        sees = motor.get("sees", {})
        turned = {joint: -1 for joint in signs.joints if joint in sees}
        own = -1 if name in signs.motors else 1
        motor["sees"] = {joint: one * own * turned.get(joint, 1) for joint, one in sees.items()}


def text_of(table: Mapping[str, Any], name: str, unclear: tuple[str, ...] = ()) -> str:
    """Return the text of an arm file."""
    heading = f"{name}: its drives were commissioned by `armdrive can setup {name}`."
    if unclear:
        heading += f"\nDirections and gears are not tried yet: {', '.join(unclear)}."
    return document(_sections(table), heading)


def _sections(table: Mapping[str, Any], name: str = "", array: bool = False) -> Iterator[Section]:
    inner = {key: each for key, each in table.items() if _is_section(each)}
    if array:  # an array's entries keep their tables inline
        inner = {}
    yield Section(
        name,
        tuple(Entry(key, each) for key, each in table.items() if key not in inner),
        array=array,
    )
    for key, each in inner.items():
        path = f"{name}.{key}" if name else key
        if isinstance(each, Mapping):
            yield from _sections(each, path)
        else:
            for one in each:
                yield from _sections(one, path, array=True)


def _is_section(value: Any) -> bool:
    tables = isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value)
    return isinstance(value, Mapping) or bool(tables)


def _short(steps: float) -> float:
    """Return the number without digits that no arm has."""
    return float(f"{steps:.{DIGITS}g}")
