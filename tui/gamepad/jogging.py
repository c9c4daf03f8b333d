"""A hand on a gamepad: it jogs by sticks while it holds one button, and the keys are armed.

A stick that is held still sends no events, and neither does a gamepad with an empty battery. So a
held jog ends some time after the last event, as with the mouse (jog/jogging.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from typing import Any, Protocol

from armdrive.motion.frames import BASE
from armdrive.moves import Jog
from tui.app import InputFilter
from tui.gamepad.map import GRIPPER_ROWS, HOLD, STOP, PadMap
from tui.gamepad.reader import Came, EvdevPad, Gone, PadEvent, PadNews, PadReader
from tui.jog.jogging import DeskJogging
from tui.keys.keyboard import Keyboard
from tui.keys.table import AXIS_KEYS
from tui.settings import JogSettings

PAD = "gamepad"
"""The name of a jog that the gamepad holds."""


class PadHand:
    """The sticks and buttons, by their latest events. Knows no screen and no device."""

    def __init__(
        self,
        pad: PadMap,
        *,
        settings: Callable[[], JogSettings],
        hand: Callable[[], DeskJogging | None],
        say: Callable[[str], None],
        do: Callable[[str], None],
    ) -> None:
        """`hand` returns the hand on the jog keys, if they are shown; `do` acts as a row's key."""
        self._pad = pad
        self._settings = settings
        self._hand = hand
        self._say = say
        self._do = do
        self._sticks: dict[int, float] = {}

    @property
    def held(self) -> bool:
        """Whether its sticks move the arm now."""
        hand = self._hand()
        return hand is not None and hand.held_button == PAD

    def take_event(self, event: PadEvent) -> None:
        """Take an event."""
        if event.button:
            self._button(event)
        elif self._pad.rows(event.code) is not None:
            self._sticks[event.code] = self._beyond(event.value)
            hand = self._hand()
            if hand is not None and self.held:
                hand.steer()

    def came(self, sticks: Mapping[int, float]) -> None:
        """Take a new gamepad, with its sticks where they are; only its button begins a motion."""
        self.gone()
        for code, value in sticks.items():
            self.take_event(PadEvent(code, value))

    def gone(self) -> None:
        """Let go: the gamepad was unplugged, or events were lost."""
        self._sticks = {}
        self._let_go()

    def _beyond(self, value: float) -> float:
        """Return how far a stick is pushed beyond its dead zone, from -1 to 1."""
        dead = self._pad.dead_zone
        pushed = min(max(abs(value) - dead, 0.0) / (1.0 - dead), 1.0)
        return pushed if value > 0.0 else -pushed

    def _button(self, event: PadEvent) -> None:
        action = self._pad.action(event.code)
        if action == HOLD:
            (self._take_hold if event.value else self._let_go)()
        elif action and event.value:
            self._do(action)

    def _take_hold(self) -> None:
        """Begin to move with the sticks: from rest, and only where the keys are armed."""
        hand = self._hand()
        if hand is None or not hand.armed:
            self._say("the gamepad is dead, as the keys are, until they are armed")
        elif any(self._sticks.values()):
            self._say("let go of the sticks first, then hold the button and push one")
        else:
            hand.take(PAD, self.aim)

    def _let_go(self) -> None:
        hand = self._hand()
        if hand is not None and self.held:
            hand.lift()

    def aim(self) -> Jog | None:
        """Return where the sticks point, with how far they are pushed; None while they rest."""
        settings = self._settings()
        amounts: dict[str, float] = {}
        for code, pushed in self._sticks.items():
            rows = self._pad.rows(code)
            axis, sign = _axis(settings, rows[settings.cartesian]) if rows and pushed else ("", 0.0)
            if axis:
                amounts[axis] = min(max(amounts.get(axis, 0.0) + sign * pushed, -1.0), 1.0)
        axes = tuple((axis, amount) for axis, amount in amounts.items() if amount)
        frame = settings.frame if settings.cartesian else BASE
        return Jog(settings.space, axes, frame) if axes else None


_KEYS = {row.id: row.action.removeprefix("jog('").removesuffix("')") for row in AXIS_KEYS}


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


class PadScreens(Protocol):
    """What a gamepad uses of the screens of its desk."""

    @property
    def pad_hand(self) -> DeskJogging | None:
        """The hand on the jog keys, where they are shown and the arm can be reached."""

    def do_row(self, name: str) -> None:
        """Do what a row of the table of keys does on the current screen."""


class PadHost(Protocol):
    """What a gamepad uses of the desk that it is plugged into."""

    keys: Keyboard
    settings: JogSettings
    input: InputFilter

    @property
    def screens(self) -> PadScreens:
        """The screens of the desk."""

    def say(self, message: str) -> None:
        """Say something on whatever screen is shown."""

    def action_stop_arm(self) -> None:
        """Stop the arm."""

    def call_from_thread(self, callback: Callable[..., Any], *args: Any) -> Any:
        """Call in the desk's own thread, and wait until that is done."""


class PadDesk:
    """Brings the events of a gamepad into the desk's own thread."""

    def __init__(self, desk: PadHost, find: Callable[[], EvdevPad | None]) -> None:
        """`find` opens a gamepad, or returns None."""
        self._desk = desk
        self._reader = PadReader(find, self._tell)
        self.hand = PadHand(
            desk.keys.pad,
            settings=lambda: desk.settings,
            hand=lambda: desk.screens.pad_hand,
            say=desk.say,
            do=self._do,
        )

    def start(self) -> None:
        """Begin to look for a gamepad."""
        self._reader.start()

    def close(self) -> None:
        """Stop reading the gamepad."""
        self._reader.close()

    def _tell(self, event: PadNews) -> None:
        """Hand an event to the desk, and wait until it was taken: one at a time."""
        try:
            self._desk.call_from_thread(self.take_event, event)
        except (RuntimeError, CancelledError):  # the desk has just ended
            self._reader.close()

    def take_event(self, event: PadNews) -> None:
        """Take an event; a desk that was suspended is disarmed first."""
        self._desk.input.alive()
        if isinstance(event, PadEvent):
            self.hand.take_event(event)
        elif isinstance(event, Came):
            self.hand.came(event.sticks)
            button = self._desk.keys.pad.buttons[HOLD]
            self._desk.say(f"{event.name}: once armed, hold its {button} and push a stick")
        elif isinstance(event, Gone):
            self.hand.gone()
            self._desk.say(f"no gamepad: {event.reason}")

    def _do(self, row: str) -> None:
        """Do what a row of the table of keys does: the stop anywhere, others where keys jog."""
        if row == STOP:
            self._desk.action_stop_arm()
        elif self._desk.screens.pad_hand is not None:
            self._desk.screens.do_row(row)
