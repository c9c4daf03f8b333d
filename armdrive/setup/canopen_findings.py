"""From a survey of a CANopen bus to findings: what answers, what state it is in, what is wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from armdrive.dialects.cia402.objects import (
    DRIVES,
    device_words,
    mode_words,
    modes_words,
    object_words,
    register_words,
    state_words,
)
from armdrive.dialects.cia402.survey import PRODUCT, REVISION, SERIAL, VENDOR, CanopenSurvey, Node
from armdrive.dialog import Finding, note, ok, problem
from armdrive.setup.findings import numbers, of_lost
from armdrive.transports.can_health import BusHealth
from firmware_protocol.canopen.drive_modes import OperationMode, mode_of, supported_modes
from firmware_protocol.canopen.drive_words import DriveState, Statusword
from firmware_protocol.canopen.emcy_codes import error_words
from firmware_protocol.canopen.nmt import NodeState
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.canopen.standard import (
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    MODE_SHOWN,
    POSITION,
    STATUSWORD,
    SUPPORTED_MODES,
)

HEARTBEAT_MISSING = 0x8130
"""The error of a drive whose master has fallen silent; it has stopped, and holds."""
_BROKEN = (DriveState.FAULT, DriveState.FAULT_REACTION)


def of_answers(found: CanopenSurvey, health: BusHealth, arm: str = "NAME") -> list[Finding]:
    """Say who answered, and what each tells of itself."""
    findings = []
    if found.there:
        words = ", ".join(map(str, found.there))
        findings.append(ok(f"of the nodes {numbers(found.asked)} there answer: {words} (CANopen)"))
        missed = sum(each.missed for each in found.nodes)
        findings += of_lost(missed, found.garbled, health)
    for each in found.nodes:
        findings += of_node(each, arm)
    return findings


def of_node(node: Node, arm: str = "NAME") -> list[Finding]:
    """Say what one node tells of itself, and what is wrong with it."""
    name = f"node {node.number}"
    if not node.answers:
        return [_mute(name, node)]
    found = [ok(f"{name}: {', '.join(_self_words(node))}")]
    if node.doubled:
        found.append(
            problem(
                f"{name}: two devices have this number",
                "plug in one at a time, and give each a number of its own by its maker's program "
                "or its switches",
            )
        )
    if node.profile != DRIVES:
        found.append(_no_drive(name, node))
        return found
    found.append(ok(f"{name}: {', '.join(_drive_words(node))}"))
    return found + [each for each in (_fault(name, node, arm), *_modes(name, node)) if each]


def of_arm(ids: Sequence[int], found: CanopenSurvey) -> list[Finding]:
    """Say which of an arm file's nodes are there and are no drives."""
    return [
        problem(
            f"node {each.number} of the arm file is no CiA 402 drive ({_type_words(each)})",
            "cia402.ids of the arm file has the numbers of the drives, in the order of the motors",
        )
        for each in found.nodes
        if each.answers and each.number in ids and each.profile != DRIVES
    ]


def view(node: Node) -> dict[str, object]:
    """Return a node as plain data."""
    word = node.number_of(STATUSWORD)
    state = None if word is None else Statusword(word).state
    return {
        "id": node.number,
        "protocol": "canopen",
        "answers": node.answers,
        "profile": node.profile,
        "device": _type_words(node) if node.answers else "",
        "name": node.name,
        "identity": [node.number_of(each) for each in (VENDOR, PRODUCT, REVISION, SERIAL)],
        "nmt": None if node.state is None else node.state.name.lower(),
        "state": None if state is None else state.name.lower(),
        "mode": node.number_of(MODE_SHOWN),
        "counts": node.number_of(POSITION),
        "error": node.number_of(ERROR_CODE),
        "doubled": node.doubled,
        "refused": {str(place): why for place, why in node.refused.items()},
    }


def _mute(name: str, node: Node) -> Finding:
    if node.state is NodeState.STOPPED:
        return problem(
            f"{name}: stopped (NMT), so it answers no question",
            "whoever stopped it starts it again; connecting to its arm does",
        )
    return problem(
        f"{name}: says heartbeats, and answers no question (SDO)",
        "see whether another program asks it at the same time, and that its number is its own",
    )


def _self_words(node: Node) -> list[str]:
    words = [_type_words(node)]
    if name := node.name:
        words.append(f"called {name}")
    identity = [("vendor", VENDOR), ("product", PRODUCT), ("revision", REVISION)]
    for word, place in identity:
        if (number := node.number_of(place)) is not None:
            words.append(f"{word} {number:08X}")
    if serial := node.number_of(SERIAL):
        words.append(f"serial number {serial}")
    if node.state is not None:
        words.append(node.state.name.lower().replace("_", "-"))
    return words


def _type_words(node: Node) -> str:
    word = node.number_of(DEVICE_TYPE)
    return "it does not tell what it is" if word is None else device_words(word)


def _drive_words(node: Node) -> list[str]:
    shown = node.number_of(MODE_SHOWN)
    mode = None if shown is None else mode_of(shown)
    rows: tuple[tuple[Place, Callable[[int], str]], ...] = (
        (STATUSWORD, lambda value: state_words(value, mode)),
        (MODE_SHOWN, lambda value: f"mode {mode_words(value)}"),
        (POSITION, lambda value: f"at {value}"),
        (SUPPORTED_MODES, lambda value: f"can do {modes_words(value)}"),
    )
    said = []
    for place, words in rows:
        value = node.number_of(place)
        said.append(f"{object_words(place)} is not told" if value is None else words(value))
    return said


def _no_drive(name: str, node: Node) -> Finding:
    return note(f"{name}: no CiA 402 drive ({_type_words(node)}), so no motor of an arm", "")


def _fault(name: str, node: Node, arm: str) -> Finding | None:
    word, register = node.number_of(STATUSWORD), node.number_of(ERROR_REGISTER) or 0
    code = node.number_of(ERROR_CODE) or 0
    broken = word is not None and Statusword(word).state in _BROKEN
    if not broken and not register:
        return None
    why = f"error {code:04X}, {error_words(code)}" if code else "without an error code"
    kinds = f" ({register_words(register)})" if register else ""
    mend = "see what caused it, then call `reset()`; that moves nothing"
    if broken:
        return problem(f"{name}: fault: {why}{kinds}", mend)
    if code == HEARTBEAT_MISSING:
        mend = f"the program that drove it has ended: `armdrive enable --arm {arm}` goes on"
    return note(f"{name}: it remembers {why}{kinds}", mend)


def _modes(name: str, node: Node) -> list[Finding]:
    word = node.number_of(SUPPORTED_MODES)
    if word is None:
        return [note(f"{name}: it does not tell which modes it has (6502)", "")]
    modes = supported_modes(word)
    if OperationMode.PROFILE_POSITION not in modes:
        return [problem(f"{name}: it has no profile position, which armdrive needs", "")]
    if OperationMode.CYCLIC_POSITION not in modes:
        return [
            note(f"{name}: without cyclic position its arm moves in bursts (profile position)", "")
        ]
    return []
