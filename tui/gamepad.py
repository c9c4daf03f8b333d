"""A gamepad that jogs: by its sticks, while one button is held and the keys are armed.

A stick that is held still sends no events, and neither does a gamepad with an empty battery. So a
held jog ends some time after the last event, as with the mouse (jog/jogging.py). The other buttons
are keys: each does what its row of the table does on the current screen, or says why it does not.

A thread reads the gamepad and only forwards events: whether anything moves is decided where the
keys are. The optional package evdev reads the gamepads of Linux; only this file knows it.
"""

from __future__ import annotations

import contextlib
import select
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from typing import Any

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import reason_of
from armdrive.moves import BASE_FRAME, Jog
from tui.app import KeyApp
from tui.jog.jogging import DeskJogging
from tui.keys.gamepad_map import BUTTONS, GRIPPER_ROWS, HOLD, STICKS, STOP
from tui.keys.table import AXIS_KEYS
from tui.settings import JogSettings

LOOK_EVERY_S = 2.0
"""The reader looks for a gamepad at this interval while there is none."""


NONE_THERE = "plug one in (your user has to be in the group `input`)"


@dataclass(frozen=True, slots=True)
class PadEvent:
    """An event of a button (1: pressed), or of a stick (from -1 to 1)."""

    code: int
    value: float
    button: bool = False


class Uncounted(Exception):
    """The system lost events, so the positions of the sticks are unknown."""


@dataclass(frozen=True, slots=True)
class Came:
    """A gamepad is there."""

    name: str
    sticks: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Gone:
    """The gamepad was unplugged, or none can be opened, for this reason."""

    reason: str


PadNews = PadEvent | Came | Gone
"""An event of a gamepad, or that it was plugged in or unplugged."""


class PadReader:
    """Forwards the events of a gamepad until it is closed."""

    def __init__(
        self, find: Callable[[], EvdevPad | None], tell: Callable[[PadNews], None]
    ) -> None:
        """`find` opens a gamepad, or returns None; `tell` is called in the reader's own thread."""
        self._find = find
        self._tell = tell
        self._closed = threading.Event()
        self._reported = ""

    def start(self) -> None:
        """Begin to look for one."""
        threading.Thread(target=self._run, name="armdrive-gamepad", daemon=True).start()

    def close(self) -> None:
        """Forward no more events."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.is_set():
            try:
                pad = self._find()
            except (ArmError, OSError) as error:
                self._say_once(reason_of(error))
                pad = None
            else:
                if pad is None:
                    self._say_once(NONE_THERE)
            if pad is not None:
                self._reported = ""
                self._read(pad)
            self._closed.wait(LOOK_EVERY_S)

    def _say_once(self, reason: str) -> None:
        if reason != self._reported:
            self._reported = reason
            self._tell(Gone(reason))

    def _read(self, pad: EvdevPad) -> None:
        reason = "unplugged"
        try:
            self._tell(Came(pad.name, pad.sticks()))
            for event in pad.events():
                if self._closed.is_set():
                    return
                if event is not None:
                    self._tell(event)
        except Uncounted:
            reason = "some of its events were lost"
        except OSError as error:
            reason = error.strerror or reason
        finally:
            self._tell(Gone(f"{pad.name}: {reason}"))
            pad.close()


EV_SYN, EV_KEY, EV_ABS = 0, 1, 3
SYN_DROPPED = 3
"""Numbers of Linux's input-event-codes.h."""

WAKE_S = 0.5
"""Timeout of a read."""


def check_gamepads() -> Any:
    """Return the package that reads gamepads. Raises `BadRequest` where that cannot be done."""
    if sys.platform != "linux":
        raise BadRequest("gamepads work on Linux only: jog with the keys or the mouse")
    try:
        import evdev
    except ModuleNotFoundError:
        raise BadRequest("gamepads need evdev: pip install 'armdrive[gamepad]'") from None
    return evdev


class EvdevPad:
    """One gamepad that is open."""

    def __init__(self, device: Any) -> None:
        """`device` is an `evdev.InputDevice`, or has its `name`, `fd`, `read` and so on."""
        self._device = device
        self.name = str(device.name)
        self._ranges = {
            code: (info.min, info.max)
            for code, info in device.capabilities(absinfo=True).get(EV_ABS, [])
            if code in STICKS.values() and info.max > info.min
        }

    def sticks(self) -> Mapping[int, float]:
        """Return where the sticks stand, from -1 to 1."""
        return {code: self._share(code, self._device.absinfo(code).value) for code in self._ranges}

    def _share(self, code: int, value: int) -> float:
        low, high = self._ranges[code]
        share: float = (2 * value - low - high) / (high - low)
        return min(max(share, -1.0), 1.0)

    def events(self) -> Iterator[PadEvent | None]:
        """Yield its events, None now and then. Raises `Uncounted`, and `OSError` at its end."""
        while True:
            if not select.select([self._device.fd], [], [], WAKE_S)[0]:
                yield None
                continue
            for event in self._ready():
                if event.type == EV_SYN and event.code == SYN_DROPPED:
                    raise Uncounted
                if event.type == EV_KEY and event.value in (0, 1):  # 2 is a repeat
                    yield PadEvent(event.code, float(event.value), button=True)
                elif event.type == EV_ABS and event.code in self._ranges:
                    yield PadEvent(event.code, self._share(event.code, event.value))

    def _ready(self) -> Iterator[Any]:
        """Yield the events that are there; there may be none."""
        with contextlib.suppress(BlockingIOError):
            yield from self._device.read()

    def close(self) -> None:
        """Close it."""
        self._device.close()


def is_gamepad(device: Any) -> bool:
    """Return whether a device has two axes of a stick and a button of a gamepad."""
    able = device.capabilities(absinfo=False)
    sticks = {STICKS["left-x"], STICKS["left-y"]} <= set(able.get(EV_ABS, []))
    return sticks and bool(set(BUTTONS.values()) & set(able.get(EV_KEY, [])))


def open_gamepad(wanted: str, evdev: Any) -> EvdevPad | None:
    """Open the gamepad whose name has these letters, or the only one; None where there is none.

    Raises `BadRequest` where there are several: the first one is as likely the wrong one.
    """
    found = []
    for path in evdev.list_devices():
        try:
            device = evdev.InputDevice(path)
        except OSError:
            continue  # unplugged meanwhile, or readable by another user only
        if is_gamepad(device) and wanted.lower() in str(device.name).lower():
            found.append(device)
        else:
            device.close()
    if len(found) == 1:
        return EvdevPad(found[0])
    names = ", ".join(str(device.name) for device in found)
    for device in found:
        device.close()
    if found:
        raise BadRequest(f"there are {names}: name one, --gamepad NAME")
    return None


PAD = "gamepad"
"""The name of a jog that the gamepad holds."""


class Gamepad:
    """The sticks and buttons, by their latest events, which a thread of their own brings."""

    def __init__(
        self,
        app: KeyApp,
        find: Callable[[], EvdevPad | None],
        *,
        hand: Callable[[], DeskJogging | None],
        do_row: Callable[[str], None],
        require_motion: Callable[[], None],
    ) -> None:
        """`find` opens a gamepad, or returns None.

        `hand` returns the hand on the jog keys where they are shown, `do_row` acts as a row's key,
        and `require_motion` raises `BadRequest` where no key can move the arm.
        """
        self._app = app
        self._map = app.keys.pad
        self._hand = hand
        self._do_row = do_row
        self._require_motion = require_motion
        self._reader = PadReader(find, self._tell)
        self._sticks: dict[int, float] = {}

    @property
    def held(self) -> bool:
        """Whether its sticks move the arm now."""
        hand = self._hand()
        return hand is not None and hand.held_button == PAD

    # -- events -------------------------------------------------------------------------------

    def start(self) -> None:
        """Begin to look for a gamepad."""
        self._reader.start()

    def close(self) -> None:
        """Stop reading the gamepad."""
        self._reader.close()

    def _tell(self, event: PadNews) -> None:
        """Hand an event to the app's own thread, and wait until it was taken: one at a time."""
        try:
            self._app.call_from_thread(self.take_event, event)
        except (RuntimeError, CancelledError):  # the desk has just ended
            self._reader.close()

    def take_event(self, event: PadNews) -> None:
        """Take an event; a desk that was suspended is disarmed first."""
        self._app.input.alive()
        if isinstance(event, Came):
            self._let_go()
            self._sticks = {}  # of another one, or from before it was unplugged
            for code, value in event.sticks.items():
                self._stick(code, value)
            button = self._map.buttons[HOLD]
            self._app.say(f"{event.name}: once armed, hold its {button} and push a stick")
        elif isinstance(event, Gone):
            self._let_go()
            self._sticks = {}
            self._app.say(f"no gamepad: {event.reason}")
        elif event.button:
            self._button(self._map.action(event.code), pressed=bool(event.value))
        else:
            self._stick(event.code, event.value)

    # -- sticks and buttons -------------------------------------------------------------------

    def _stick(self, code: int, value: float) -> None:
        """Note where a stick is; only the button begins a motion."""
        if self._map.rows(code) is None:
            return
        self._sticks[code] = self._beyond(value)
        hand = self._hand()
        if hand is not None and self.held:
            hand.steer()

    def _beyond(self, value: float) -> float:
        """Return how far a stick is pushed beyond its dead zone, from -1 to 1."""
        dead = self._map.dead_zone
        pushed = min(max(abs(value) - dead, 0.0) / (1.0 - dead), 1.0)
        return pushed if value > 0.0 else -pushed

    def _button(self, action: str, *, pressed: bool) -> None:
        """Stop on any screen, take or release the hold, or act as the key of a row."""
        if action == HOLD and not pressed:
            self._let_go()
        elif action == HOLD:
            with self._app.calls.acting():
                self._take_hold()
        elif action == STOP and pressed:
            self._app.action_stop_arm()
        elif action and pressed:
            self._do_row(action)

    def _take_hold(self) -> None:
        """Begin to move with the sticks: from rest, and only where the keys are armed."""
        self._require_motion()
        hand = self._hand()
        if hand is None or not hand.armed:
            raise BadRequest("the gamepad moves nothing until the keys are armed")
        if any(self._sticks.values()):
            raise BadRequest("let go of the sticks first, then hold the button and push one")
        hand.take(PAD, lambda: self._aim(hand.settings))

    def _let_go(self) -> None:
        hand = self._hand()
        if hand is not None and self.held:
            hand.lift()

    def _aim(self, settings: JogSettings) -> Jog | None:
        """Return where the sticks point, with how far they are pushed; None while they rest."""
        amounts: dict[str, float] = {}
        for code, pushed in self._sticks.items():
            rows = self._map.rows(code)
            axis, sign = _axis(settings, rows[settings.cartesian]) if rows and pushed else ("", 0.0)
            if axis:
                amounts[axis] = min(max(amounts.get(axis, 0.0) + sign * pushed, -1.0), 1.0)
        axes = tuple((axis, amount) for axis, amount in amounts.items() if amount)
        frame = settings.frame if settings.cartesian else BASE_FRAME
        return Jog(settings.space, axes, frame) if axes else None


_KEYS = {row.id: row.jogs for row in AXIS_KEYS}


def _axis(settings: JogSettings, row: str) -> tuple[str, float]:
    """Return the axis that a row of jog keys moves on this arm, and which way; "" where none is."""
    if row in GRIPPER_ROWS:
        last = settings.rows[-1]
        key = last.plus if row == GRIPPER_ROWS[0] else last.minus
    else:
        key = _KEYS[row]
    pair = settings.pair_of(key)
    if pair is None:
        return "", 0.0
    return pair.axis(cartesian=settings.cartesian), 1.0 if key == pair.plus else -1.0
