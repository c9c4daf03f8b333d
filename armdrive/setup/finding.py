"""The ports and CAN interfaces of this computer, and what is behind one of them.

Listing opens nothing. `probe` opens a port, which can restart the board behind it; what it says
moves no arm of the table of dialects (docs/finding-the-arm.md). On a CAN bus it only reads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from armdrive.connect.target import simulation_forced
from armdrive.dialects.cia402.objects import DRIVES
from armdrive.dialects.cia402.survey import CanopenSurvey, Put, Talk, ask_nodes
from armdrive.dialects.mks.survey import Survey, ask_round
from armdrive.dialog import Finding, Grade, note
from armdrive.errors import PortUnavailable
from armdrive.setup import canopen_findings
from armdrive.setup import findings as can_findings
from armdrive.setup.prober import Clock
from armdrive.transports.address import CanAddress, is_can
from armdrive.transports.can_health import BusHealth
from armdrive.transports.link import Link
from firmware_protocol.canopen.cob import NODE_MAX as CANOPEN_MAX
from firmware_protocol.canopen.nmt import NodeState
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import NODE_MAX as MKS_MAX

if TYPE_CHECKING:
    from armdrive.dialects.mks.survey import Known
    from armdrive.dialog import Ask
    from armdrive.setup.draft import LinkFile, Surroundings


@dataclass(frozen=True, slots=True)
class Candidate:
    """A port or an interface, what is known of it while it is closed, and whether it can open."""

    port: str
    lines: tuple[str, ...] = ()
    openable: bool = True


@dataclass(frozen=True, slots=True)
class Found:
    """What a probe has found, in words; `dialect` is empty where nobody was recognised."""

    port: str
    lines: tuple[str, ...]
    dialect: str = ""
    baud: int | None = None

    @property
    def answers(self) -> dict[str, str]:
        """What it answers of the questions that make an arm file."""
        known = {"connection.port": self.port, "dialect": self.dialect}
        if self.dialect and self.baud:
            known["connection.baud"] = str(self.baud)
        return {key: word for key, word in known.items() if word}


def candidates() -> tuple[Candidate, ...]:
    """Return what an arm may be behind. Opens nothing."""
    from armdrive.transports.ports import list_can_ports, list_ports

    ports = list_ports()
    serial = tuple(looked_at(each.stable_name or each.device) for each in ports)
    buses = list_can_ports(ports)
    return (*serial, *(_bus(each.port, each.description, each.todo) for each in buses))


def looked_at(port: str) -> Candidate:
    """Return what is known of a port that somebody names. Opens nothing."""
    from armdrive.setup.ports import arm_files, look_at

    if is_can(port):
        return _bus(port, "a CAN bus", "")
    before = look_at(port, arm_files())
    return Candidate(port, lines_of(before.findings), before.openable)


def _bus(port: str, description: str, todo: str) -> Candidate:
    return Candidate(port, tuple(each for each in (description, todo) if each), not todo)


def probe(port: str) -> Found:
    """Open a port and find out what it leads to; moves nothing. Raises `LinkError`."""
    if simulation_forced():
        raise PortUnavailable("ARMDRIVE_FORCE_SIM is set, so that no real port is opened")
    if is_can(port):
        return _asked(CanAddress.parse(port))
    from armdrive.setup.findings import Expected, findings
    from armdrive.setup.prober import examine_port

    found = examine_port(port, None)
    dialect = found.identity.dialect if found.identity is not None else ""
    return Found(port, lines_of(findings(found, Expected())), dialect, found.baud)


def _asked(address: CanAddress) -> Found:
    """Listen on a bus, then ask every id who it is, unless somebody else commands its drives."""
    from armdrive.dialects.cia402.survey import heard_nodes
    from armdrive.dialects.mks.survey import IDS, LISTEN_S, listen
    from armdrive.setup.dialog_runner import Carrier
    from armdrive.setup.findings import of_listening, of_nobody
    from armdrive.setup.prober import RealClock
    from armdrive.transports.can_link import open_can_link

    rate = address.option("bitrate")
    with closing(open_can_link(str(address.listening()))) as link:
        heard = Carrier(link, RealClock(), Nobody()).run(listen())
    told = of_listening(heard, LISTEN_S, int(rate) if rate.isdecimal() else 0)
    if heard.commands:
        return Found(str(address), lines_of(told))
    with closing(open_can_link(str(address))) as link:
        answers = ask_bus(link, RealClock(), IDS, heard_nodes(heard.passing))
        told += [finding for each in answers for finding in each.findings(link.health, "NAME")]
        if not any(each.there for each in answers):
            told.append(of_nobody(IDS, link.health))
    found = next((PROTOCOLS[each.protocol] for each in answers if each.drives), None)
    if found is not None and found.hint:
        told.append(note(found.hint.format(port=address)))
    return Found(str(address), lines_of(told), found.dialect if found is not None else "")


class Nobody:
    """A survey asks no person anything."""

    def tell(self, text: str) -> None:
        """Say nothing."""

    def watch(self, motor: int) -> None:
        """See nothing."""

    def answer(self, asked: Ask) -> object:
        """Refuse: there is no question in a survey."""
        raise NotImplementedError(asked.question.words)


def lines_of(findings: tuple[Finding, ...] | list[Finding]) -> tuple[str, ...]:
    """Return findings as people read them, what mends each behind it."""
    return tuple(
        f"{'' if each.grade is Grade.OK else each.grade.value + ': '}{each.what}"
        + (f" - {each.mend}" if each.mend else "")
        for each in findings
    )


def surroundings(given: dict[str, str]) -> Surroundings:
    """Return what the interview may know of this computer. Opens nothing."""
    from armdrive.setup.draft import Surroundings
    from armdrive.storage import files as places
    from armdrive.transports.ports import list_can_ports, list_ports

    found = list_ports()
    ports = tuple(each.stable_name or each.device for each in found)
    buses = tuple(each.port for each in list_can_ports(found))
    arms = tuple(path.stem for path in sorted(places.arm_files().glob("*.toml")))
    return Surroundings(arms, ports, read_links, frozenset(given), buses)


def read_links(path: str) -> LinkFile:
    """Read a model file that somebody names. Raises `WrongAnswer`."""
    from pathlib import Path

    from armdrive.config.link_model import read_model
    from armdrive.dialog import WrongAnswer
    from armdrive.errors import ArmError, ArmFileError
    from armdrive.setup.draft import LinkFile
    from armdrive.text.reading import read_text

    place = Path(path).expanduser()
    try:
        return LinkFile(
            path, read_text(place, "the model file", ArmFileError), read_model(place).chain
        )
    except (ArmError, RuntimeError) as error:
        raise WrongAnswer(str(error)) from None


# Which protocols a CAN bus is asked in, in which order, and which ids without harm.
#
# CANopen is asked first: reading objects by SDO does nothing to MKS drives, whatever their ids
# (canopen_survey tells why). MKS drives are asked by ids of one frame, and from 128 on those are
# CANopen's: SYNC, process data, orders to drives. So where a CANopen node was heard or has
# answered,
# no MKS drive is asked for beyond 127, which CANopen leaves free.

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
    from armdrive.setup.dialog_runner import Carrier

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
