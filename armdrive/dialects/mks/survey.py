"""Asks a CAN bus of MKS drives politely who is on it: it listens, then asks each id its position.

Nothing but readings is ever sent, one at a time and with pauses; nothing at all while another
program is heard to command drives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from armdrive.dialects.bus.tools import IDS, Answers, Heard, numbers, of_lost, of_nobody
from armdrive.dialog.conversation import (
    ANSWER_S,
    LINGER_S,
    Finding,
    Hear,
    Put,
    Talk,
    note,
    ok,
    problem,
)
from armdrive.transports.can_health import BusHealth
from firmware_protocol.errors import ProtocolError
from firmware_protocol.frames import Frame
from firmware_protocol.mks import (
    BOARDS,
    CURRENT_MAX_MA,
    Ability,
    AngleErrorRead,
    Answered,
    Code,
    Done,
    EmergencyStop,
    EnabledRead,
    EncoderRead,
    Event,
    Failed,
    Foreign,
    Garbled,
    Host,
    Mode,
    Motion,
    MotorState,
    Read,
    ReadAngleError,
    ReadEnabled,
    ReadEncoder,
    Reading,
    ReadRawEncoder,
    ReadSetting,
    ReadStall,
    ReadState,
    ReadVersion,
    Request,
    SetMode,
    Setting,
    SettingRead,
    SilenceWatchdog,
    StallRead,
    Started,
    StateRead,
    Stop,
    StoredForStart,
    Stray,
    Version,
    VersionRead,
    abilities_of,
    as_setting,
    decode_answer,
    decode_request,
)

# The host's end for a talk: requests to whichever drive is meant, one at a time.


class MksHost:
    """Speaks to any drive that a talk puts a request to; a question that is over is forgotten."""

    def __init__(self) -> None:
        self._host = Host(())

    def send(self, node: int, request: Request) -> bytes:
        """Return the bytes that put a request to a drive."""
        self._host.add(node)
        for before in self._host.unanswered(node):
            if not isinstance(before, Motion):  # of which the end is still to come
                self._host.forget(node, before)
        return self._host.send(node, request)

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus."""
        self._host.receive_data(data)

    def next_event(self) -> Event | Frame | None:
        """Return what was heard, one at a time; a frame of no drive that was spoken to as it is."""
        event = self._host.next_event()
        return event.frame if isinstance(event, Foreign) else event

    def answers(self, event: Event | Frame, request: Request) -> bool:
        """Tell whether an event is the first word of a drive on a request."""
        kinds = Answered | Done | Failed | Started | StoredForStart
        return isinstance(event, kinds) and event.request == request

    def moves(self, request: Request) -> bool:
        """Tell whether a request turns a motor."""
        return isinstance(request, Motion)

    def stop(self, node: int, request: Request) -> Iterable[bytes]:
        """Return both words that stop a motor: firmware before 1.0.4 knows the second alone."""
        yield self.send(node, EmergencyStop())
        if not isinstance(request, Stop) and hasattr(request, "counts"):
            yield self.send(node, Stop(request.code, 0))

    def settle(self, node: int) -> None:
        """Take note that a drive is known to stand."""
        self._host.settle(node)


# What one drive tells of itself, asked by readings alone: nothing is set, nothing turns.

TRIES = 3
"""How often a question is put: frames can be lost."""
LATE_S = 0.2
"""An answer that has not come by then never will, on however busy a computer."""
SMALL_MAX_MA = 3000
"""Of every board but the SERVO57D."""
_LARGE_BOARDS = (3, 4)
_TELLTALES: tuple[Read, ...] = (ReadEncoder(), ReadRawEncoder(), ReadAngleError())
"""Readings that are hardly ever alike in two drives: an encoder trembles."""
_OLDEST: Version = (1, 0, 4)
"""What is taken for the firmware of a drive that tells neither its version nor a setting."""


@dataclass(frozen=True, slots=True)
class Known:
    """What a drive has told. `told` says whether the firmware is its own word or a conclusion.

    `settings` has what it lets be read (from 1.0.6 on); None and empty are what it does not tell.
    """

    node: int
    firmware: Version = _OLDEST
    told: bool = False
    version: VersionRead | None = None
    counts: int | None = None
    error: int | None = None
    enabled: bool | None = None
    stalled: bool | None = None
    state: MotorState | None = None
    settings: Mapping[Code, Setting] = field(default_factory=dict)
    doubled: bool = False
    """Whether one question had two answers."""
    missed: int = 0
    """How many questions had to be put once more."""

    @property
    def able(self) -> frozenset[Ability]:
        """What its firmware can do."""
        return abilities_of(self.firmware)

    @property
    def firmware_words(self) -> str:
        """The firmware for people."""
        number = ".".join(map(str, self.firmware))
        return f"firmware {number}" if self.told else f"firmware {number} or so, it does not tell"

    @property
    def board(self) -> str:
        """What it is."""
        number = None if self.version is None else self.version.board
        return BOARDS.get(number or 0, "a drive")

    @property
    def most_ma(self) -> int:
        """The highest current that its board takes."""
        large = self.version is not None and self.version.board in _LARGE_BOARDS
        return CURRENT_MAX_MA if large else SMALL_MAX_MA

    @property
    def mode(self) -> SetMode | None:
        """Who commands it, where it tells."""
        found = self.settings.get(Code.MODE)
        return found if isinstance(found, SetMode) else None


def answer_of(heard: tuple[Event, ...]) -> Reading | SettingRead | None:
    """Return the first answer among what was heard."""
    return next((each.answer for each in heard if isinstance(each, Answered)), None)


def reading(node: int, request: Read | ReadSetting) -> Talk[Reading | SettingRead | None]:
    """Ask a drive something, again where it does not answer; None where it never does."""
    for _ in range(TRIES):
        heard: tuple[Event, ...] = yield Put(node, request, ANSWER_S)
        found = answer_of(heard)
        if found is not None:
            return found
    return None


def answers(node: int, wait_s: float = ANSWER_S) -> Talk[bool]:
    """Tell whether anybody answers to an id."""
    for _ in range(TRIES):
        heard = yield Put(node, ReadEncoder(), wait_s)
        if answer_of(heard) is not None:
            return True
    return False


def doubled(node: int) -> Talk[bool]:
    """Tell whether two drives were heard to answer to an id. Those that say the same are not.

    Once is not enough: an answer that came too late looks like that too.
    """
    for request in _TELLTALES:
        twice = 0
        for _ in range(TRIES):
            heard: tuple[Event, ...] = yield Put(node, request, ANSWER_S, LINGER_S)
            if answer_of(heard) is None:
                yield Hear(LATE_S)
            twice += any(
                isinstance(each, Stray) and each.answer.code is request.code for each in heard
            )
        if twice > 1:
            return True
    return False


def known(node: int) -> Talk[Known | None]:
    """Ask a drive for everything that matters; None where nobody has the id."""
    missed = 0
    first = None
    for _ in range(TRIES):
        first = answer_of((yield Put(node, ReadEncoder())))
        if first is not None:
            break
        missed += 1
    if first is None:
        return None
    version = yield from reading(node, ReadVersion())
    mode = yield from reading(node, ReadSetting(Code.MODE))
    told = version if isinstance(version, VersionRead) else None
    watchdog = yield from reading(node, ReadSetting(Code.WATCHDOG)) if told is not None else _none()
    firmware = told.version if told is not None and told.version else None
    concluded = _concluded(told, mode, watchdog)
    settings: dict[Code, Setting] = {}
    if mode is not None:
        for code in (Code.MODE, Code.CURRENT, Code.MICROSTEPS, Code.REPLIES, Code.WATCHDOG):
            found = _setting((yield from reading(node, ReadSetting(code))))
            if found is not None:
                settings[code] = found
    error = yield from reading(node, ReadAngleError())
    enabled = yield from reading(node, ReadEnabled())
    stalled = yield from reading(node, ReadStall())
    state = yield from reading(node, ReadState())
    return Known(
        node,
        firmware or concluded,
        firmware is not None,
        told,
        first.counts if isinstance(first, EncoderRead) else None,
        error.error if isinstance(error, AngleErrorRead) else None,
        enabled.on if isinstance(enabled, EnabledRead) else None,
        stalled.on if isinstance(stalled, StallRead) else None,
        state.state if isinstance(state, StateRead) else None,
        settings,
        (yield from doubled(node)),
        missed,
    )


def _none() -> Talk[None]:
    """Ask nothing."""
    return
    yield


def _concluded(told: VersionRead | None, mode: object, watchdog: object) -> Version:
    """Return a firmware by what a drive answers, where it does not tell it in full."""
    if told is not None:
        return (1, 0, 9) if _setting(watchdog) is not None else (1, 0, 8)
    return (1, 0, 6) if mode is not None else _OLDEST


def _setting(read: object) -> Setting | None:
    if not isinstance(read, SettingRead):
        return None
    try:
        return as_setting(read)
    except ProtocolError:  # a value that no table has
        return None


def setting_of(node: int, code: Code) -> Talk[Setting | None]:
    """Read one setting of a drive; None where it does not tell it."""
    return _setting((yield from reading(node, ReadSetting(code))))


ASK_S = 0.02
"""A drive's answer takes a millisecond."""
PAUSE_S = 0.005
ROUNDS = 2


@dataclass(frozen=True, slots=True)
class Survey:
    """Who was asked, who is there, and how many answers could not be read."""

    asked: tuple[int, ...] = ()
    drives: tuple[Known, ...] = ()
    garbled: int = 0


def ask_round(ids: Sequence[int] = IDS) -> Talk[Survey]:
    """Ask each id once or twice whether it is there, then those that are for all that they tell."""
    there: set[int] = set()
    garbled = 0
    for _ in range(ROUNDS):
        for node in [each for each in ids if each not in there]:
            heard: tuple[Event, ...] = yield Put(node, ReadEncoder(), ASK_S)
            garbled += sum(isinstance(each, Garbled) for each in heard)
            if answer_of(heard) is not None:
                there.add(node)
            yield Hear(PAUSE_S)
    found = []
    for node in sorted(there):
        told = yield from known(node)
        if told is not None:
            found.append(told)
    return Survey(asked=tuple(ids), drives=tuple(found), garbled=garbled)


def survey_drives(ids: Sequence[int], _heard: Heard) -> Talk[Answers]:
    """Ask each id, and return who is there in words and as plain data."""
    found = yield from ask_round(ids)
    there = tuple(each.node for each in found.drives)
    return Answers(
        "mks",
        found.asked,
        there,
        there,
        tuple(map(view, found.drives)),
        lambda health, arm: of_answers(found, health, arm) if there else [],
    )


def is_answer(frame: Frame) -> bool:
    """Tell whether a frame can be read as a drive's answer."""
    return _reads(decode_answer, frame)


def is_request(frame: Frame, _master: int | None = None) -> bool:
    """Tell whether a frame can be read as a request to a drive."""
    return _reads(decode_request, frame)


def _reads(decode: Callable[[Frame], object], frame: Frame) -> bool:
    try:
        decode(frame)
    except (ProtocolError, ValueError):
        return False
    return True


# What a survey has found, as findings and as plain data.


def of_answers(found: Survey, health: BusHealth, arm: str = "NAME") -> list[Finding]:
    """Say who answered, or why perhaps nobody did."""
    if not found.drives:
        return [of_nobody(found.asked, health)]
    names = ", ".join(str(each.node) for each in found.drives)
    findings = [ok(f"of the ids {numbers(found.asked)} there answer: {names}")]
    missed = sum(each.missed for each in found.drives)
    findings += of_lost(missed, found.garbled, health)
    for each in found.drives:
        findings += of_drive(each, arm)
    return findings


def of_drive(drive: Known, arm: str = "NAME") -> list[Finding]:
    """Say what one drive tells of itself, and what is wrong with it."""
    mode = drive.mode
    words = [drive.board, drive.firmware_words, f"at {drive.counts} counts"]
    words += [f"mode {int(mode.mode)}"] if mode else []
    words += ["holds" if drive.enabled else "has let its motor go"]
    words += [drive.state.name.lower().replace("_", " ")] if drive.state is not None else []
    name = f"drive {drive.node}"
    found = [ok(f"{name}: {', '.join(words)}")]
    if drive.doubled:
        found.append(
            problem(
                f"{name}: two drives have this id",
                f"plug in one at a time: `armdrive can setup {arm}`",
            )
        )
    if mode is not None and mode.mode is not Mode.BUS_FOC:
        found.append(
            problem(
                f"{name}: mode {int(mode.mode)} ({mode.mode.name}) obeys no motion of the bus",
                f"`armdrive doctor --arm {arm} --mend`, or `armdrive can setup {arm}`, sets mode 5",
            )
        )
    if drive.stalled:
        found.append(
            problem(
                f"{name}: its protection has let the shaft go",
                "see what blocks it, then call `reset()`, or its supply off and on",
            )
        )
    if drive.version is not None and not drive.version.calibrated:
        found.append(
            problem(
                f"{name}: its encoder is not calibrated", f"`armdrive can setup {arm}` does that"
            )
        )
    if Ability.SILENCE_WATCHDOG not in drive.able:
        found.append(
            note(f"{name}: no watchdog before firmware 1.0.9; ends at its last target", "")
        )
    elif drive.settings.get(Code.WATCHDOG) == SilenceWatchdog(0):
        found.append(note(f"{name}: its watchdog is off; `enable()` switches it on", ""))
    return found


def view(drive: Known) -> dict[str, object]:
    """Return a drive as plain data."""
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
