"""The modes in force, and what a block does to them, as GRBL's parser checks in its step 3.

Not checked here, for it needs positions: whether an arc is possible (errors 33 and 34), whether
a probe's target is where it stands (33), and whether a target lies outside the travel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from firmware_protocol.grbl.gcode import Block, GcodeError
from firmware_protocol.grbl.gtable import JOG_GROUPS, Group
from firmware_protocol.grbl.info import ParserState
from firmware_protocol.grbl.words import write_number

MM_PER_INCH = 25.4
_PLANES = {"G17": ("XY", "IJ"), "G18": ("ZX", "KI"), "G19": ("YZ", "JK")}
_FIELDS = {
    Group.MOTION: "motion",
    Group.COORDINATES: "coordinates",
    Group.PLANE: "plane",
    Group.UNITS: "units",
    Group.DISTANCE: "distance",
    Group.FEED_MODE: "feed_mode",
    Group.SPINDLE: "spindle",
    Group.COOLANT: "coolant",
}
_NEEDED = {"G4": "P", "G10": "PL", "M62": "P", "M63": "P", "M64": "P", "M65": "P"}
_NEEDED |= {"M67": "EQ", "M68": "EQ"}
_USED = {**_NEEDED, "G2": "IJKR", "G3": "IJKR"}
_ALWAYS_USED = {False: frozenset("NFST"), True: frozenset("NF")}
_COORDINATE_SYSTEMS = 6


@dataclass(frozen=True, slots=True)
class Modal:
    """GRBL's parser state at a start. `feed` is in millimetres a minute, 0 where none is set."""

    motion: str = "G0"
    coordinates: str = "G54"
    plane: str = "G17"
    units: str = "G21"
    distance: str = "G90"
    feed_mode: str = "G94"
    spindle: str = "M5"
    coolant: str = "M9"
    tool: int = 0
    feed: float = 0.0
    speed: float = 0.0

    @property
    def report(self) -> ParserState:
        """The answer to `$G`."""
        modes = (self.motion, self.coordinates, self.plane, self.units, self.distance)
        numbers = (f"T{self.tool}", f"F{write_number(self.feed)}", f"S{write_number(self.speed)}")
        return ParserState((*modes, self.feed_mode, self.spindle, self.coolant, *numbers))

    def during(self, block: Block) -> Modal:
        """Return the modes that hold while a block is executed; raises `GcodeError`.

        Of a jog too, which changes nothing once it is over: keep the modes from before it.
        """
        words = {_FIELDS[group]: name for group, name in block.commands.items() if group in _FIELDS}
        modes = replace(self, **words)  # type: ignore[arg-type]
        if block.jog:
            modes = replace(modes, motion="G1", feed_mode="G94")
        modes = replace(
            modes,
            feed=self._feed(block, modes),
            speed=block.values.get("S", self.speed),
            tool=int(block.values.get("T", self.tool)),
        )
        _check_non_modal(block, modes)
        _check_motion(block, modes)
        _check_leftovers(block, modes)
        if block.jog:
            _check_jog(block)
        return modes

    def after(self, block: Block) -> Modal:
        """Return the modes that hold when a block is over; raises `GcodeError`."""
        modes = self.during(block)
        if block.jog:
            return self
        if block.commands.get(Group.FLOW) in ("M2", "M30"):
            return Modal(
                "G1", units=modes.units, tool=modes.tool, feed=modes.feed, speed=modes.speed
            )
        return modes

    def _feed(self, block: Block, modes: Modal) -> float:
        """Find the feed that holds; in inverse time (G93) a motion names its own."""
        given = block.values.get("F")
        if block.jog and given is None:
            raise GcodeError(22)
        if modes.feed_mode == "G93":
            if given is None and block.motion_use and modes.motion not in ("G0", "G80"):
                raise GcodeError(22)
            return given or 0.0
        if given is None:
            return self.feed if self.feed_mode == "G94" else 0.0
        return given * modes.unit_mm

    @property
    def unit_mm(self) -> float:
        """How many millimetres one unit of length is."""
        return MM_PER_INCH if self.units == "G20" else 1.0


def lengths_mm(block: Block, modes: Modal) -> dict[str, float]:
    """Return the axis words in millimetres, under the modes that hold during the block."""
    return {letter: value * modes.unit_mm for letter, value in block.axes.items()}


def _check_non_modal(block: Block, modes: Modal) -> None:
    name = block.commands.get(Group.NON_MODAL)
    if name in ("G10", "G92") and not block.axes:
        raise GcodeError(26, name)
    for command in (name, block.commands.get(Group.OUTPUT)):
        if command and not set(_NEEDED.get(command, "")) <= block.values.keys():
            raise GcodeError(28, command)
    if name == "G10":
        _check_g10(block)
    if name == "G53" and modes.motion not in ("G0", "G1"):
        raise GcodeError(30)
    tool_length = block.commands.get(Group.TOOL_LENGTH)
    if tool_length == "G43.1" and set(block.axes) != {"Z"}:
        raise GcodeError(37)


def _check_g10(block: Block) -> None:
    if int(block.values["P"]) > _COORDINATE_SYSTEMS:
        raise GcodeError(29)
    how = int(block.values["L"])
    if how not in (2, 20) or (how == 2 and "R" in block.values):
        raise GcodeError(20, f"G10 L{how}")


def _check_motion(block: Block, modes: Modal) -> None:
    if modes.motion == "G80" and block.axes:
        raise GcodeError(31)
    if not block.motion_use or modes.motion in ("G0", "G80"):
        return
    if modes.feed == 0:
        raise GcodeError(22)
    if modes.motion != "G1" and not block.axes:
        raise GcodeError(26, modes.motion)
    if modes.motion in ("G2", "G3"):
        in_plane, offsets = _PLANES[modes.plane]
        if not set(in_plane) & block.axes.keys():
            raise GcodeError(32)
        if "R" not in block.values and not set(offsets) & block.values.keys():
            raise GcodeError(35)


def _check_leftovers(block: Block, modes: Modal) -> None:
    """Refuse value words that nothing uses; axis words always have a use, or were refused."""
    names = list(block.commands.values())
    if block.motion_use:
        names.append(modes.motion)
    used = set().union(*(_USED.get(name, "") for name in names))
    if "R" in block.values:  # a radius leaves the offsets without a use
        used -= set("IJK")
    if block.values.keys() - used - _ALWAYS_USED[block.jog]:
        raise GcodeError(36)


def _check_jog(block: Block) -> None:
    """Admit distance, units and G53 in a jog, and ask for an axis.

    That a jog without an axis word is refused follows doc/markdown/jogging.md; the sources of
    GRBL do not check it.
    """
    if block.commands.keys() - JOG_GROUPS or block.commands.get(Group.NON_MODAL, "G53") != "G53":
        raise GcodeError(16)
    if not block.axes:
        raise GcodeError(26)
