"""A simulated arm on a GRBL board: power, inputs, gripper, actions of a person, saved state.

The board itself is in `board`. A new device has just been switched on, or was reset because its
port was opened: its counts are zero whatever the posture, and it first sends its banner.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.device import Board, Option, Options, SwitchState
from armdrive.sim.grbl.board import GrblBoard, Makers
from armdrive.sim.grbl.firmware import FIRMWARES, BoardSettings
from armdrive.sim.grbl.hardware import BoardBuild, BoardDrive, Switches
from armdrive.sim.grbl.orders import (
    fail,
    hold,
    obey,
    raise_critical,
    resume,
    run_line,
    soft_reset,
    switched_on,
)
from armdrive.sim.grbl.parser import STORED
from armdrive.sim.grbl.wiring import (
    board_axes,
    gripper_wiring,
    motor_letters,
    switches,
    well_set_up,
)
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import MEND, Json, Saved
from firmware_protocol.grbl import State
from kinematics.spaces import Motors

# --- What the board knows, as plain numbers and texts --------------------------------------------


def known_json(board: GrblBoard) -> dict[str, Json]:
    """Return the EEPROM contents, the outputs, and whether the board is locked."""
    locked = board.state in (State.ALARM, State.SLEEP)
    settings: dict[str, Json] = {str(key): value for key, value in board.settings.values.items()}
    offsets: dict[str, Json] = {name: list(board.parser.stored[name]) for name in STORED}
    return {
        "axes": board.axes,
        "state": str(State.ALARM if locked else State.IDLE),
        "settings": settings,
        "offsets": offsets,
        "startup": list(board.startup),
        "note": board.note,
        "outputs": board.outputs.to_json(),
    }


def recall_known(board: GrblBoard, saved: Saved) -> None:
    """Restore what `known_json` wrote. Raises `StateFileError`."""
    if saved.text("axes") != board.axes:
        raise StateFileError(f"the saved board has other axes than {board.axes}; {MEND}")
    state = saved.text("state")
    if state not in (State.ALARM, State.IDLE):
        raise StateFileError(f"no board is saved in the state {state!r}; {MEND}")
    settings = saved.table("settings")
    values = {key: settings.number(str(key)) for key in board.settings.values}
    settings.end()
    offsets = saved.table("offsets")
    stored = {name: _place(offsets, name, len(board.axes)) for name in STORED}
    offsets.end()
    startup = [_line(item) for item in saved.items("startup")]
    if len(startup) != len(board.startup):
        raise StateFileError(f"a board has {len(board.startup)} startup lines; {MEND}")
    note = saved.text("note")
    board.outputs.recall(saved.table("outputs"))
    board.settings.values.update(values)
    board.drive.rack.limits = board.settings.limits()
    board.parser.stored = stored
    board.parser.restart(board.drive.units_of(board.drive.rack.goal))
    board.startup[:] = startup
    board.note = note
    board.state = State(state)


def _place(saved: Saved, name: str, axes: int) -> tuple[float, ...]:
    items = saved.items(name)
    wanted = [Saved({"at": item}, "offset").number("at") for item in items]
    if len(wanted) != axes:
        raise StateFileError(f"the saved {name} needs {axes} numbers; {MEND}")
    return tuple(wanted)


def _line(item: object) -> str:
    return Saved({"line": item}, "startup").text("line")


COUNT_MOST = (1 << 31) - 1
PINS = "PDHSR"
"""The input bits: probe, door, feed hold, cycle start, reset."""
_MAKERS = Makers(run_line, obey, raise_critical, fail)


class WiredGrblBoard(Board):
    """The board with its firmware, the fingers on one of its outputs, and the arm."""

    title: ClassVar[str] = "GRBL board"
    input_bits: ClassVar[int] = len(PINS)
    register_range: ClassVar[tuple[int, int]] = (-COUNT_MOST, COUNT_MOST)
    drive: BoardDrive

    def __init__(
        self,
        world: World,
        build: BoardBuild,
        settings: BoardSettings,
        switches: Switches,
        baud: int | None,
    ) -> None:
        drive = BoardDrive(world, build, settings.limits())
        super().__init__(world, drive, baud)
        self.build = build
        self.grbl = GrblBoard(
            self.shared,
            build,
            settings,
            drive,
            switches,
            _MAKERS,
            baud=baud,
            outputs_changed=self._outputs_changed,
        )
        self._fingers: tuple[float, float] | None = None
        """When the fingers arrive, and at which opening."""
        world.energised = settings.motors_stay_on
        self.start(0.0)

    @property
    def busy(self) -> bool:
        """Whether a line is being executed or waits."""
        return self.grbl.at_work

    @property
    def registers(self) -> Motors:
        """The step counts of the axes."""
        return self.drive.registers

    def boot(self) -> None:
        """Start the firmware."""
        self.start(self.build.firmware.boot_s)

    def start(self, wait_s: float) -> None:
        """Restart the firmware after a delay, with its banner."""
        self.grbl.forget()
        self.shared.outgoing.clear()
        self.grbl.boot.begin(switched_on(self.grbl, wait_s), self.now_s)
        while self.grbl.boot.until_s <= self.now_s:
            self.grbl.happen()

    def hear(self, data: bytes) -> None:
        """Receive bytes."""
        self.grbl.hear(data)

    def happen(self) -> None:
        """Let the fingers arrive, and the board do what is due."""
        if self._fingers is not None and self._fingers[0] <= self.now_s:
            opening_mm = self._fingers[1]
            self._fingers = None
            self.world.move_fingers(opening_mm, self.now_s)
        self.grbl.happen()

    def due_s(self) -> float:
        """Return when the board acts next or the fingers arrive."""
        return min(self.grbl.due_s(), math.inf if self._fingers is None else self._fingers[0])

    def forget(self) -> None:
        """Clear the board's volatile memory and the goal of the fingers."""
        self.grbl.forget()
        self._fingers = None

    def known(self) -> dict[str, Json]:
        """Return the saved state of the board."""
        return known_json(self.grbl)

    def recall_known(self, saved: Saved) -> None:
        """Restore what `known` wrote. Raises `StateFileError`."""
        recall_known(self.grbl, saved)
        if self.build.resets_on_open:
            self.world.cut_current(self.now_s)
            self.start(0.0)
        else:
            self.shared.outgoing.clear()
            self.grbl.limits.forget(self.grbl)

    def _outputs_changed(self) -> None:
        """Move the fingers as their output commands; they arrive once the motion is over."""
        value = self.grbl.outputs.value(self.build.fingers)
        if value is None or self.world.body.transmission.has_gripper:
            return
        low, high = self.build.opening_mm
        opening_mm = low + (high - low) * self.build.fingers.share(value)
        way_mm = abs(opening_mm - self.world.opening_mm)
        self._fingers = self.now_s + way_mm / self.build.finger_mm_s, opening_mm

    # Observable state.

    def details(self) -> dict[str, Json]:
        """Return the firmware, its state, its outputs, and how many bytes were lost."""
        return {
            "firmware": self.build.firmware.name,
            "state": str(self.grbl.state),
            "outputs": self.grbl.outputs.to_json(),
            "lost_bytes": self.grbl.ring.lost,
        }

    # Actions of a person.

    def set_input(self, bit: int, on: bool) -> None:
        """Set a control pin. Hold, start and reset act like the corresponding commands."""
        pressed = on and not self.shared.inputs_set >> bit & 1
        super().set_input(bit, on)
        self.grbl.inputs = "".join(
            letter for number, letter in enumerate(PINS) if self.shared.inputs_set >> number & 1
        )
        act = {"H": hold, "S": resume, "R": soft_reset}.get(PINS[bit])
        if act is not None and pressed and self.shared.powered and not self.grbl.boot.active:
            act(self.grbl)

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Make the limit switch of a motor (counted from 0) stick, or free it."""
        if not 0 <= axis < len(self.build.order):
            raise BadRequest(f"motors are numbered 0 to {len(self.build.order) - 1}, not {axis}")
        self.grbl.switches.stuck[axis] = state
        self._look()

    def moved_by_hand(self, *, counted: bool) -> None:
        """Count steps made at the controls; check the switches after motion by force."""
        if counted:
            self.grbl.parser.position = self.drive.units_of(self.drive.rack.goal)
            self.grbl.limits.forget(self.grbl)
        else:
            self._look()

    def reset(self) -> None:
        """Reset the board, as opening its port does: it loses its position, and the arm sags."""
        if self.shared.powered:
            self.drive.stop(self.now_s)
            self.world.cut_current(self.now_s)
            self.start(self.build.firmware.boot_s)

    def _look(self) -> None:
        if self.shared.powered:
            self.grbl.limits.look(self.grbl)


MOST_COAST = 10.0


def _make(config: ArmConfig, world: World, options: Options) -> WiredGrblBoard:
    firmware = FIRMWARES[options.text("firmware")]
    if options.number("plan_ms") >= 0.0:
        firmware = replace(firmware, plan_s=options.number("plan_ms") / 1000)
    if options.flag("limit_interrupts"):
        firmware = replace(firmware, hard_limits=True)
    coast = options.number("coast")
    if not 0.0 <= coast <= MOST_COAST:
        raise BadRequest(f"coast must be from 0 to {MOST_COAST:g}, not {coast:g}")
    letters = motor_letters(config, len(world.motors))
    axes = board_axes(letters, options.text("axes"))
    values = well_set_up(config, letters, axes)
    wired = switches(config, world, letters, axes, values)
    if options.flag("homing"):
        values[22] = 1.0
    build = BoardBuild(
        firmware,
        axes,
        tuple(axes.index(letter) for letter in letters),
        gripper_wiring(config),
        config.model.gripper_range_mm,
        config.model.gripper_speed_mm_s,
        coast,
        options.flag("resets_on_open"),
    )
    settings = BoardSettings(len(axes), {} if options.flag("factory") else values, firmware.factory)
    return WiredGrblBoard(world, build, settings, wired, config.connection.baud)


KIND = SimDeviceKind(
    title="GRBL board",
    board=WiredGrblBoard,
    make=_make,
    options=(
        Option("firmware", "mega5x", "which one it runs", tuple(FIRMWARES)),
        Option("axes", "", "the axes of its build, XYZABC say; those that are used if left out"),
        Option("factory", False, "settings as it leaves the factory, not as the arm needs them"),
        Option("homing", False, "homing is on ($22=1), whatever the arm file says"),
        Option(
            "limit_interrupts", False, "a build that acts on $21=1 where the usual one does not"
        ),
        Option("resets_on_open", False, "a saved arm is found with its board freshly reset"),
        Option("coast", 1.0, "the arm runs on by this share of the ramp where motors stop dead"),
        Option("plan_ms", -1.0, "milliseconds for each motion; below 0: those of the firmware"),
    ),
)
