"""Asks a CAN bus of MKS drives politely who is on it: it listens, then asks each id its position.

Nothing but readings is ever sent, one at a time and with pauses; nothing at all while another
program is heard to command drives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from armdrive.dialects.cia402 import survey as canopen_survey
from armdrive.dialog import ANSWER_S, LINGER_S, Hear, Put, Talk
from firmware_protocol.errors import ProtocolError
from firmware_protocol.frames import Frame
from firmware_protocol.mks import (
    BOARDS,
    CURRENT_MAX_MA,
    Ability,
    AngleErrorRead,
    Answered,
    Code,
    EnabledRead,
    EncoderRead,
    Event,
    Foreign,
    Garbled,
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
    SetMode,
    Setting,
    SettingRead,
    StallRead,
    StateRead,
    Stray,
    Version,
    VersionRead,
    abilities_of,
    as_setting,
    decode_answer,
    decode_request,
)

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


LISTEN_S = 1.0
"""An arm that is driven is commanded far oftener than that."""
ASK_S = 0.02
"""A drive's answer takes a millisecond."""
PAUSE_S = 0.005
ROUNDS = 2
IDS = tuple(range(1, 17))
"""Asked where nobody says otherwise."""


@dataclass(frozen=True, slots=True)
class Survey:
    """What was heard and found.

    `passing` are the frames that passed while nothing was sent, and `commands` those of them that
    somebody else has put to drives. `asked` is empty where nothing was sent.
    """

    passing: tuple[Frame, ...] = ()
    commands: tuple[Frame, ...] = ()
    asked: tuple[int, ...] = ()
    drives: tuple[Known, ...] = ()
    garbled: int = 0


def listen(seconds: float = LISTEN_S, master: int | None = None) -> Talk[Survey]:
    """Hear what passes by itself, whatever is spoken; `master` is a CANopen master's node."""
    heard: tuple[Event, ...] = yield Hear(seconds)
    frames = tuple(each.frame for each in heard if isinstance(each, Foreign))
    return Survey(frames, tuple(each for each in frames if _is_command(each, master)))


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


def _is_command(frame: Frame, master: int | None) -> bool:
    """Tell whether a frame can be nothing but a request to a drive, in either protocol."""
    if _reads(decode_answer, frame):
        return False
    return _reads(decode_request, frame) or canopen_survey.is_command(frame, master)


def _reads(decode: Callable[[Frame], object], frame: Frame) -> bool:
    try:
        decode(frame)
    except (ProtocolError, ValueError):
        return False
    return True
