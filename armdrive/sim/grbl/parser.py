"""What a line of g-code requests of a simulated GRBL board: modes, offsets, and the target.

Positions are in the machine's own unit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import add, sub

from armdrive.sim.grbl.firmware import MINUTE_S
from firmware_protocol.grbl import Block, GcodeError, Group, Modal, lengths_mm

Place = tuple[float, ...]
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59")
STORED = (*SYSTEMS, "G28", "G30")
"""What the EEPROM stores."""


@dataclass(frozen=True, slots=True)
class RequestedMove:
    """A motion to a target; `rate` is in units per second."""

    target: Place
    rate: float = 0.0
    rapid: bool = False


@dataclass(slots=True)
class Work:
    """What a line requests, in the order of execution."""

    jog: bool
    after: Modal
    spindle: bool = False
    coolant: bool = False
    output: tuple[str, int, float] | None = None
    dwell_s: float | None = None
    stores: dict[str, Place] = field(default_factory=dict)
    g92: Place | None = None
    new_system: bool = False
    moves: list[RequestedMove] = field(default_factory=list)
    pause: bool = False
    end: bool = False

    @property
    def writes_eeprom(self) -> bool:
        """Whether the line changes the EEPROM."""
        return bool(self.stores)

    @property
    def waits(self) -> bool:
        """Whether the line waits for the previous motion to end."""
        synced = self.output is not None and self.output[0] not in ("M64", "M65", "M68")
        return (
            synced or self.spindle or self.coolant or self.pause or self.end
            or self.dwell_s is not None or self.writes_eeprom
        )  # fmt: skip


class GcodeParser:
    """Modes, work offsets, and the position up to which lines have been parsed."""

    def __init__(self, axes: str, unknown: frozenset[str]) -> None:
        self.axes = axes
        self._unknown = unknown
        self.zero: Place = (0.0,) * len(axes)
        self.stored: dict[str, Place] = dict.fromkeys(STORED, self.zero)
        self.restart(self.zero)

    def restart(self, position: Place) -> None:
        """Start as after a reset, from a position."""
        self.modal = Modal()
        self.g92 = self.zero
        self.position = position

    @property
    def offset(self) -> Place:
        """The work zero in machine coordinates."""
        return _with(add, self.stored[self.modal.coordinates], self.g92)

    def work(self, block: Block) -> Work:
        """Return what a line requests. Raises `GcodeError`."""
        names = set(block.commands.values())
        if names & self._unknown:
            raise GcodeError(20)
        modes = self.modal.during(block)
        flow = block.commands.get(Group.FLOW)
        ends = flow in ("M2", "M30")
        after = self.modal.after(block) if ends else self.modal if block.jog else modes
        work = Work(block.jog, after, pause=flow == "M0", end=ends)
        if not block.jog:
            self._outputs(block, modes, work)
            work.new_system = modes.coordinates != self.modal.coordinates
        self._places(block, modes, work)
        return work

    def take(self, work: Work) -> None:
        """Apply a line's modes, offsets and target from now on."""
        self.modal = work.after
        self.stored.update(work.stores)
        self.g92 = self.g92 if work.g92 is None else work.g92
        if work.moves:
            self.position = work.moves[-1].target

    def _outputs(self, block: Block, modes: Modal, work: Work) -> None:
        turned = modes.spindle != "M5" and modes.speed != self.modal.speed
        work.spindle = modes.spindle != self.modal.spindle or turned
        work.coolant = Group.COOLANT in block.commands
        output = block.commands.get(Group.OUTPUT)
        values = block.values
        if output in ("M67", "M68"):
            work.output = (output, int(values["E"]), values["Q"])
        elif output is not None:
            work.output = (output, int(values["P"]), float(output in ("M62", "M64")))
        if block.commands.get(Group.NON_MODAL) == "G4":
            work.dwell_s = values["P"]

    def _places(self, block: Block, modes: Modal, work: Work) -> None:
        """Determine the offsets that change, and the targets of the motion."""
        words = lengths_mm(block, modes)
        shift = _with(add, self.stored[modes.coordinates], self.g92)
        name = block.commands.get(Group.NON_MODAL)
        match name:
            case "G10":
                self._store_system(block, modes, words, work)
            case "G92":
                place = self.stored[modes.coordinates]
                at = _with(sub, self.position, place)
                work.g92 = self._changed(self.g92, words, lambda i, v: at[i] - v)
            case "G92.1":
                work.g92 = self.zero
            case "G28.1" | "G30.1":
                work.stores[name[:3]] = self.position
            case "G28" | "G30":
                if words:
                    work.moves.append(RequestedMove(self._target(words, modes, shift), rapid=True))
                start = work.moves[-1].target if work.moves else self.position
                kept = self.stored[name]
                picked = {a: kept[i] for i, a in enumerate(self.axes) if a in (words or self.axes)}
                work.moves.append(
                    RequestedMove(self._changed(start, picked, lambda _, v: v), rapid=True)
                )
            case _ if words and block.motion_use:
                target = self._target(words, modes, self.zero if name == "G53" else shift, name)
                work.moves.append(self._move_to(target, modes))

    def _move_to(self, target: Place, modes: Modal) -> RequestedMove:
        if modes.motion == "G0":
            return RequestedMove(target, rapid=True)
        return RequestedMove(target, modes.feed / MINUTE_S)

    def _target(
        self, words: dict[str, float], modes: Modal, shift: Place, name: str | None = None
    ) -> Place:
        if modes.distance == "G91" and name != "G53":
            return self._changed(self.position, words, lambda i, v: self.position[i] + v)
        return self._changed(self.position, words, lambda i, v: shift[i] + v)

    def _store_system(
        self, block: Block, modes: Modal, words: dict[str, float], work: Work
    ) -> None:
        which = int(block.values["P"])
        system = SYSTEMS[which - 1] if which else modes.coordinates
        at = _with(sub, self.position, self.g92)
        here = int(block.values["L"]) == 20
        work.stores[system] = self._changed(
            self.stored[system], words, lambda i, v: at[i] - v if here else v
        )

    def _changed(
        self, place: Place, words: Mapping[str, float], how: Callable[[int, float], float]
    ) -> Place:
        """Return a position with the named axes changed; `how` receives axis and number."""
        return tuple(
            how(index, words[letter]) if letter in words else place[index]
            for index, letter in enumerate(self.axes)
        )


def _with(how: Callable[[float, float], float], a: Place, b: Place) -> Place:
    return tuple(how(one, other) for one, other in zip(a, b, strict=True))
