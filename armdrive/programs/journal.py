"""What is written down before every act of a program, so that it can be taken up again.

One small file an arm, beside its record: which program, what it knows, and where the arm stood when
the act began. It outlives a power cut, and is gone when the program has ended well.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive import places
from armdrive.durable import DISK, remove_durably, replace_file
from armdrive.errors import Refused, StateFileError

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.programs.acts import Answer, Machine
    from armdrive.programs.performing import Performer
    from armdrive.programs.running import Step

FORMAT = 1
LONGEST = 8_000_000
"""Bytes. What is longer is not even read."""

_CHECK = "check"


@dataclass(frozen=True, slots=True)
class Standing:
    """Where an arm stood: joint angles by name in degrees, and the opening of the fingers in mm."""

    joints_deg: dict[str, float]
    opening_mm: float


@dataclass(frozen=True, slots=True)
class Entry:
    """A program that was interrupted, or is under way.

    `snapshot` is its machine's, and gives the act that was under way once more; `began` is where
    the arm stood when that act began, None where nobody knew. `loop` counts from 1, `loops` is how
    many were asked for. `why` says what ended it, if anybody could still write that down.
    """

    arm: str
    program: str
    sha256: str
    line: int
    snapshot: dict[str, Any]
    began: Standing | None
    loop: int = 1
    loops: int = 1
    outputs: int = 0
    why: str = ""


class Journal:
    """Writes the journal of one run, as one of those who look on."""

    def __init__(
        self, arm: Arm, performer: Performer, program: Path, sha256: str, loops: int
    ) -> None:
        self.path = journal_file(arm.config.name)
        self._arm = arm
        self._performer = performer
        self._program = str(program)
        self._sha256 = sha256
        self._loops = loops
        self._entry: Entry | None = None

    def begins(self, step: Step, machine: Machine) -> None:
        """Write down where the program is. Raises `StateFileError`: then the act does not begin."""
        self._write(
            Entry(
                self._arm.config.name,
                self._program,
                self._sha256,
                step.stage.mark.line,
                machine.snapshot(),
                standing(self._arm),
                step.loop,
                self._loops,
                self._performer.outputs,
            )
        )

    def ended(self, step: Step, answer: Answer, took_s: float) -> None:
        """Wait for the next act: until then, this one would be done once more."""

    def broke_off(self, error: BaseException) -> None:
        """Write down why the program ended early, if anything had begun."""
        if self._entry is not None:
            self._write(replace(self._entry, why=str(error) or type(error).__name__))

    def finish(self) -> None:
        """Forget the program, which has ended well."""
        self._entry = None
        _removed(self.path)

    def _write(self, entry: Entry) -> None:
        self._entry = entry
        try:
            replace_file(self.path, to_text(entry))
        except OSError as error:
            raise StateFileError(
                f"nothing moves that could not be taken up again: {self.path} cannot be written "
                f"({error.strerror or error})"
            ) from None


def journal_file(arm: str) -> Path:
    """Return the file of the program that an arm was last at work on."""
    return places.states() / f"{places.file_name(arm)}.program.json"


def standing(arm: Arm) -> Standing | None:
    """Return where an arm stands, None where nobody knows."""
    with arm.pace.lock:
        there, known = arm.core.coordinates, arm.core.position_known
    return Standing(dict(there.joints.deg), there.opening_mm) if known else None


def interrupted(arm: str) -> Entry:
    """Return the program that an arm was interrupted in.

    Raises `Refused` where there is none, and `StateFileError` for a file that cannot be used.
    """
    path = journal_file(arm)
    try:
        return from_text(DISK.read_own(path, LONGEST + 1))
    except FileNotFoundError:
        raise Refused(f"no program of {arm} was interrupted: there is nothing to resume") from None
    except OSError as error:
        raise StateFileError(
            f"the journal {path} cannot be read: {error.strerror or error}"
        ) from None
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise StateFileError(
            f"the journal {path} is damaged ({error}): delete it, and begin the program anew"
        ) from None


def to_text(entry: Entry) -> str:
    """Return the text of an entry."""
    entries = {"format": FORMAT, **asdict(entry)}
    return json.dumps({**entries, _CHECK: _check(entries)})


def from_text(text: bytes) -> Entry:
    """Return the entry of a text; raises `ValueError`, `TypeError` or `KeyError`."""
    if len(text) > LONGEST:
        raise ValueError("it is too long")
    entries = json.loads(text.decode("utf-8"))
    if not isinstance(entries, dict) or entries.pop(_CHECK, None) != _check(entries):
        raise ValueError("its checksum is another one")
    if entries.pop("format") != FORMAT:
        raise ValueError("another armdrive wrote it")
    began = entries.pop("began")
    return Entry(**entries, began=None if began is None else Standing(**began))


def _check(entries: dict[str, Any]) -> str:
    plain = json.dumps(entries, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(plain.encode()).hexdigest()


def _removed(path: Path) -> None:
    try:
        remove_durably(DISK, path)
    except OSError as error:
        raise StateFileError(
            f"the program has ended, but {path} cannot be removed ({error.strerror or error}): "
            "remove it, or it could be taken up once more"
        ) from None
