"""Survey the MKS drives on a CAN bus: ask each id for its position, then each drive for its data.

Only questions are sent, one at a time and with pauses. The caller listens first, and sends nothing
while another program commands drives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from armdrive.dialects.bus.drives import ANSWER_S, LAST_REPLY_S, LINGER_S
from armdrive.dialects.bus.tools import Answers, SeenNodes, Survey
from armdrive.dialects.exchange import ScriptLoop
from armdrive.dialects.mks.contact import Firmware, firmware_of, series_words
from armdrive.dialects.mks.exchange import MksExchange, MksScript
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialog import Finding, note, ok, problem
from armdrive.errors.printable import command_line
from armdrive.transports.can_health import BusHealth
from firmware_protocol.fields import in_words
from firmware_protocol.mks import (
    BOARDS,
    CURRENT_MAX_MA,
    NODE_DEFAULT,
    Ability,
    AngleErrorRead,
    Code,
    EnabledRead,
    EncoderRead,
    Event,
    Mode,
    MotorState,
    Read,
    ReadAngleError,
    ReadEnabled,
    ReadEncoder,
    ReadRawEncoder,
    ReadStall,
    ReadState,
    SetMode,
    Setting,
    SilenceWatchdog,
    StallRead,
    StateRead,
    abilities_of,
)
from kinematics.text import counted


def scripts(ids: Sequence[int]) -> ScriptLoop[Event]:
    """Return a loop for scripts on the wire to these ids, whether or not drives have them."""
    settings = MksSettings(ids=tuple(ids) or (NODE_DEFAULT,), answer_s=ANSWER_S)
    io = MksExchange(settings, map(str, settings.ids))
    return ScriptLoop(io.host, io)


# The data of one drive. Nothing is set and nothing turns.

# The current limit of every board except the SERVO57D.
SMALL_MAX_MA = 3000
_LARGE_BOARDS = (3, 4)


@dataclass(frozen=True, slots=True)
class KnownDrive:
    """A drive's answers; None and empty for what it does not report.

    `settings` are readable from firmware 1.0.6 on.
    """

    node: int
    firmware: Firmware = field(default_factory=Firmware)
    counts: int | None = None
    error: int | None = None
    enabled: bool | None = None
    stalled: bool | None = None
    state: MotorState | None = None
    settings: Mapping[Code, Setting] = field(default_factory=dict)
    doubled: bool = False
    """Whether two drives answer to its id."""
    missed: int = 0
    """How many questions were never answered, and had to be repeated."""

    @property
    def able(self) -> frozenset[Ability]:
        """The abilities of its firmware."""
        return abilities_of(self.firmware.version)

    @property
    def firmware_words(self) -> str:
        """Its firmware as text."""
        words = f"firmware {self.firmware}"
        return words if self.firmware.reported else f"probably {words}, which it does not report"

    @property
    def board(self) -> str:
        """The name of its board."""
        number = 0 if self.firmware.e_series else self.firmware.board or 0
        return BOARDS.get(number, "a drive")

    @property
    def most_ma(self) -> int:
        """The current limit of its board."""
        return CURRENT_MAX_MA if self.firmware.board in _LARGE_BOARDS else SMALL_MAX_MA

    @property
    def mode(self) -> SetMode | None:
        """The mode that decides what commands it, if it reports that."""
        found = self.settings.get(Code.MODE)
        return found if isinstance(found, SetMode) else None


def answers(io: MksExchange, node: int) -> MksScript[bool]:
    """Return whether a drive answers to an id."""
    return (yield from io.reading(io.drive(node), ReadEncoder())) is not None


def known(io: MksExchange, node: int) -> MksScript[KnownDrive | None]:
    """Ask a drive for all its data; None if no drive has the id."""
    drive = io.drive(node)
    io.surplus.clear()
    counts = yield from io.reading(drive, ReadEncoder())
    if counts is None:
        return None
    if io.surplus.owed:  # unless the answers are only late
        yield from io.pause(io.now_s + LAST_REPLY_S)
    missed = io.surplus.owed_by(node, Code.ENCODER)
    firmware = (yield from firmware_of(io, (drive,)))[drive]
    settings: dict[Code, Setting] = {}
    for code in _SETTINGS if Ability.READ_SETTINGS in abilities_of(firmware.version) else ():
        found = yield from io.setting(drive, code)
        if found is not None:
            settings[code] = found
    error = yield from io.reading(drive, ReadAngleError())
    enabled = yield from io.reading(drive, ReadEnabled())
    stalled = yield from io.reading(drive, ReadStall())
    state = yield from io.reading(drive, ReadState())
    return KnownDrive(
        node,
        firmware,
        counts.counts if isinstance(counts, EncoderRead) else None,
        error.error if isinstance(error, AngleErrorRead) else None,
        enabled.on if isinstance(enabled, EnabledRead) else None,
        stalled.on if isinstance(stalled, StallRead) else None,
        state.state if isinstance(state, StateRead) else None,
        settings,
        (yield from is_shared(io, node)),
        missed,
    )


_SETTINGS = (Code.MODE, Code.CURRENT, Code.MICROSTEPS, Code.REPLIES, Code.WATCHDOG)


# Whether drives share an id. Then each question has more than one answer, unless equal answers
# begin in the same bit: those look like one on the bus.

# Readings that hardly ever agree in two drives, because encoders tremble.
TELLTALES: tuple[Read, ...] = (ReadEncoder(), ReadRawEncoder(), ReadAngleError())
# How often each of them is read.
TELLTALE_READS = 3


def is_shared(io: MksExchange, node: int) -> MksScript[bool]:
    """Find out whether several drives answer to an id, as far as the bus shows it."""
    for message in TELLTALES:
        io.surplus.clear()
        for _ in range(TELLTALE_READS):
            yield from io.reading(io.drive(node), message, tries=1)
            yield from io.pause(io.now_s + LINGER_S)
        if io.surplus.owed:
            yield from io.pause(io.now_s + LAST_REPLY_S)
        if node in io.surplus.shared:
            return True
    return False


# The ids of a bus, one after the other.

# Pause between questions; an answer takes a millisecond.
ASK_S = 0.02
# How often an id is asked at most: one lost frame must not hide a drive.
ROUNDS = 2


def ask_round(io: MksExchange) -> MksScript[Survey[KnownDrive]]:
    """Ask each id for its position, up to twice; then ask the drives that answer for their data."""
    for _ in range(ROUNDS):
        for drive in io.drives:
            if not drive.is_located:
                io.put(drive, ReadEncoder())
                yield from io.pause(io.now_s + ASK_S)
    yield from io.pause(io.now_s + LAST_REPLY_S)
    garbled = io.garbled
    found = []
    for drive in io.drives:
        data = (yield from known(io, drive.node)) if drive.is_located else None
        if data is not None:
            found.append(data)
    return Survey(io.settings.ids, tuple(found), garbled)


def survey_drives(io: MksExchange, ids: Sequence[int], _heard: SeenNodes) -> MksScript[Answers]:
    """Survey the ids; return the drives in words and as plain data."""
    found = (yield from ask_round(io)) if ids else Survey[KnownDrive]()
    there = tuple(each.node for each in found.nodes)
    return Answers(
        "mks",
        found.asked,
        there,
        there,
        tuple(map(view, found.nodes)),
        lambda health, arm: of_answers(found, health, arm),
    )


# The result of a survey, as findings and as plain data.


def of_answers(found: Survey[KnownDrive], health: BusHealth, arm: str = "NAME") -> list[Finding]:
    """Report the drives that answered, and each one's data."""
    findings = found.answering("ids", ", ".join(str(each.node) for each in found.nodes), health)
    for each in found.nodes:
        findings += of_drive(each, arm)
    return findings


def of_drive(drive: KnownDrive, arm: str = "NAME") -> list[Finding]:
    """Report one drive's data, and what is wrong with it."""
    mode = drive.mode
    words = [drive.board, drive.firmware_words]
    words += [] if drive.counts is None else [f"at {counted(drive.counts, 'count')}"]
    words += [f"mode {mode.mode.title}"] if mode else []
    words += ["holds" if drive.enabled else "has let its motor go"]
    words += [in_words(drive.state)] if drive.state is not None else []
    name = f"drive {drive.node}"
    setup, fix = command_line("can", "setup", arm), command_line("doctor", "--arm", arm, "--fix")
    found = [ok(f"{name}: {', '.join(words)}")]
    if drive.firmware.e_series:
        return [*found, problem(series_words(name), "use a SERVO42D or SERVO57D")]
    if drive.doubled:
        found.append(
            problem(
                f"{name}: more than one drive has this id",
                f"plug in one at a time: `{setup}`",
            )
        )
    if mode is not None and mode.mode is not Mode.BUS_FOC:
        found.append(
            problem(
                f"{name}: mode {mode.mode.title} obeys no motion from the bus",
                f"`{fix}`, or `{setup}`, sets mode {Mode.BUS_FOC.title}",
            )
        )
    if drive.stalled:
        found.append(
            problem(
                f"{name}: its protection has let the shaft go",
                "find out what blocks it, then call `reset()` or switch its supply off and on",
            )
        )
    if drive.firmware.calibrated is False:
        found.append(problem(f"{name}: its encoder is not calibrated", f"`{setup}` does that"))
    if Ability.SILENCE_WATCHDOG not in drive.able:
        found.append(
            note(f"{name}: no watchdog before firmware 1.0.9; ends at its last target", "")
        )
    elif drive.settings.get(Code.WATCHDOG) == SilenceWatchdog(0):
        found.append(note(f"{name}: its watchdog is off; `enable()` switches it on", ""))
    return found


def view(drive: KnownDrive) -> dict[str, object]:
    """Return a drive as plain data."""
    return {
        "id": drive.node,
        "protocol": "mks",
        "board": drive.board,
        "firmware": str(drive.firmware),
        "firmware_told": drive.firmware.reported,
        "counts": drive.counts,
        "enabled": drive.enabled,
        "stalled": drive.stalled,
        "mode": None if drive.mode is None else int(drive.mode.mode),
        "state": None if drive.state is None else drive.state.name.lower(),
        "doubled": drive.doubled,
    }
