"""Reads a gamepad in a thread of its own, and looks for one while there is none.

The thread only forwards events: whether anything moves is decided where the keys are. The optional
package evdev reads the gamepads of Linux; this is the only file that knows it.
"""

from __future__ import annotations

import contextlib
import select
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import reason_of
from tui.gamepad.map import BUTTONS, STICKS

LOOK_EVERY_S = 2.0
"""The reader looks for a gamepad at this interval while there is none."""


NONE_THERE = "plug one in; it is looked for (your user has to be in the group `input`)"


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
        raise BadRequest("gamepads are read on Linux alone; jog with the keys or the mouse")
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
