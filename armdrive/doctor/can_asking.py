"""Which protocols a CAN bus is asked in, in which order, and which ids without harm.

CANopen is asked first: reading objects by SDO does nothing to MKS drives, whatever their ids
(canopen_survey tells why). MKS drives are asked by ids of one frame, and from 128 on those are
CANopen's: SYNC, process data, orders to drives. So where a CANopen node was heard or has answered,
no MKS drive is asked for beyond 127, which CANopen leaves free.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from armdrive.doctor import can_findings, canopen_findings
from armdrive.doctor.can_survey import Survey, ask_round
from armdrive.doctor.canopen_survey import CanopenSurvey, Put, Talk, ask_nodes
from armdrive.doctor.carrying import Clock
from armdrive.doctor.findings import Finding
from armdrive.transports.can_health import BusHealth
from armdrive.transports.link import Link
from armdrive.wording.canopen_drives import DRIVES
from firmware_protocol.canopen.cob import NODE_MAX as CANOPEN_MAX
from firmware_protocol.canopen.nmt import NodeState
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import NODE_MAX as MKS_MAX

if TYPE_CHECKING:
    from armdrive.commissioning.drives import Known

Heard: TypeAlias = Mapping[int, NodeState]


@dataclass(frozen=True, slots=True)
class Answers:
    """What came of asking in one protocol: who is there, in words and as plain data.

    `drives` are those that an arm can have: without devices of another kind.
    """

    protocol: str
    asked: tuple[int, ...]
    there: tuple[int, ...] = ()
    drives: tuple[int, ...] = ()
    views: tuple[dict[str, object], ...] = ()
    findings: Callable[[BusHealth, str], list[Finding]] = lambda _health, _arm: []
    of_arm: Callable[[Sequence[int]], list[Finding]] = lambda _ids: []


@dataclass(frozen=True, slots=True)
class Protocol:
    """One row: how a bus is asked in it, by ids up to `most`.

    `connects` tells that connecting to such an arm sets nothing, so that its settings may be
    compared unasked; `next` is the command for drives that no arm file has, and `hint` what is
    said of it to who makes such a file otherwise.
    """

    name: str
    dialect: str
    most: int
    connects: bool
    next: str
    hint: str
    ask: Callable[[Link, Clock, Sequence[int], Heard], Answers]


def _ask_canopen(link: Link, clock: Clock, ids: Sequence[int], heard: Heard) -> Answers:
    found: CanopenSurvey = carried(ask_nodes(ids, heard), link, clock)
    drives = [each for each in found.nodes if each.profile == DRIVES]
    return Answers(
        "canopen",
        found.asked,
        found.there,
        tuple(each.number for each in drives),
        tuple(map(canopen_findings.view, found.nodes)),
        lambda health, arm: canopen_findings.of_answers(found, health, arm),
        lambda ids: canopen_findings.of_arm(ids, found),
    )


def _ask_mks(link: Link, clock: Clock, ids: Sequence[int], _heard: Heard) -> Answers:
    from armdrive.commissioning.carrier import Carrier
    from armdrive.setup.finding import Nobody

    found: Survey = Carrier(link, clock, Nobody()).run(ask_round(ids))
    there = tuple(each.node for each in found.drives)
    return Answers(
        "mks",
        found.asked,
        there,
        there,
        tuple(map(_mks_view, found.drives)),
        lambda health, arm: can_findings.of_answers(found, health, arm) if there else [],
    )


PROTOCOLS: Mapping[str, Protocol] = MappingProxyType(
    {
        "canopen": Protocol(
            "canopen",
            "cia402",
            CANOPEN_MAX,
            connects=False,
            next="armdrive config new NAME --template minimover5-cia402 --port '{port}'",
            hint="",
            ask=_ask_canopen,
        ),
        "mks": Protocol(
            "mks",
            "mks",
            MKS_MAX,
            connects=True,
            next="armdrive can setup NAME --port '{port}'",
            hint="`armdrive can setup NAME --port '{port}'` does more: it writes the arm file, and "
            "sets the drives up and tries them one by one",
            ask=_ask_mks,
        ),
    }
)
"""Every protocol, in the order in which a bus is asked where no arm file says what it speaks."""


def ask_bus(
    link: Link,
    clock: Clock,
    ids: Sequence[int],
    heard: Heard = MappingProxyType({}),
    dialect: str = "",
) -> tuple[Answers, ...]:
    """Ask a bus who is on it. That of an arm file is asked in another protocol if nobody answers.

    Raises `LinkLost`.
    """
    rows = sorted(PROTOCOLS.values(), key=lambda row: row.dialect != dialect)
    answers: list[Answers] = []
    for row in rows:
        if dialect and any(each.there for each in answers):
            break
        harmless = ids if row.name == "canopen" else spared(ids, answers, heard)
        chosen = [each for each in harmless if each <= row.most]
        if chosen or heard:
            answers.append(row.ask(link, clock, chosen, heard))
    return tuple(answers)


def spared(ids: Sequence[int], answers: Sequence[Answers], heard: Heard) -> list[int]:
    """Leave out the ids that mean something to CANopen nodes, where there are any."""
    there = heard or any(each.there for each in answers if each.protocol == "canopen")
    return [each for each in ids if not there or each <= CANOPEN_MAX]


def carried(talk: Talk[Any], link: Link, clock: Clock) -> Any:
    """Carry out a talk of frames on a link; return what comes of it. Raises `LinkError`."""
    unpacker = Unpacker()
    try:
        act = next(talk)
        while True:
            act = talk.send(_done(act, link, clock, unpacker))
    except StopIteration as end:
        return end.value


def _done(act: Put, link: Link, clock: Clock, unpacker: Unpacker) -> tuple[Frame, ...]:
    now_s = clock.now_s()
    unpacker.feed(link.read(now_s))  # what came before answers nothing of this
    if act.frame is not None:
        link.write(pack(act.frame), now_s)
    end_s, awaited = now_s + act.wait_s, True
    heard: list[Frame] = []
    while True:
        for frame in unpacker.feed(link.read(clock.now_s())):
            heard.append(frame)
            if awaited and act.enough(frame):
                end_s, awaited = min(end_s, clock.now_s() + act.linger_s), False
        if clock.now_s() >= end_s or not math.isfinite(end_s):
            return tuple(heard)
        clock.sleep(link, end_s)


def _mks_view(drive: Known) -> dict[str, object]:
    return {
        "id": drive.node,
        "protocol": "mks",
        "board": drive.board,
        "firmware": ".".join(map(str, drive.firmware)),
        "firmware_told": drive.told,
        "counts": drive.counts,
        "enabled": drive.enabled,
        "stalled": drive.stalled,
        "mode": None if drive.mode is None else int(drive.mode.mode),
        "state": None if drive.state is None else drive.state.name.lower(),
        "doubled": drive.doubled,
    }
