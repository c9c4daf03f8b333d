"""A hand on a gamepad: it jogs by sticks while it holds one button, and the keys are armed.

A stick that is held still sends no events, and neither does a gamepad with an empty battery. So a
held jog ends some time after the last event, as with the mouse (jog/jogging.py). The other buttons
are keys: each does what its row of the table does on the current screen, or says why it does not.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError

from armdrive.errors import BadRequest
from armdrive.motion.frames import BASE
from armdrive.moves import Jog
from tui.app import KeyApp
from tui.gamepad.map import GRIPPER_ROWS, HOLD, STOP
from tui.gamepad.reader import Came, EvdevPad, Gone, PadNews, PadReader
from tui.jog.jogging import DeskJogging
from tui.keys.table import AXIS_KEYS
from tui.settings import JogSettings

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
            self._sticks = {}
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
