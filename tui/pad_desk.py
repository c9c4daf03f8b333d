"""The gamepad of a desk: what it tells is taken up by the hand on the jog keys, or is said."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING

from tui.pad_hand import PadEvent, PadHand
from tui.pad_map import HOLD, STOP
from tui.pad_reader import Came, Gone, Pad, PadReader, Told

if TYPE_CHECKING:
    from tui.desk import Desk
    from tui.jogging import Jogging


class PadDesk:
    """Takes what a reader tells into the desk's own thread."""

    def __init__(self, desk: Desk, find: Callable[[], Pad | None]) -> None:
        """`find` opens a gamepad, or returns None."""
        self._desk = desk
        self._reader = PadReader(find, self._tell)
        self.hand = PadHand(
            desk.keys.pad,
            settings=lambda: desk.settings,
            hand=self._keys,
            say=desk.say,
            do=self._do,
        )

    def start(self) -> None:
        """Begin to look for a gamepad."""
        self._reader.start()

    def close(self) -> None:
        """Hear of it no more."""
        self._reader.close()

    def _keys(self) -> Jogging | None:
        """Return the hand on the jog keys, where a link is there and they are shown."""
        desk = self._desk
        return None if desk.lost or not desk.screen_stack else desk.place.hand

    def _tell(self, told: Told) -> None:
        """Hand it to the desk, and wait until it was taken: no more than one is on its way."""
        try:
            self._desk.call_from_thread(self.heard, told)
        except (RuntimeError, CancelledError):  # the desk has just ended
            self._reader.close()

    def heard(self, told: Told) -> None:
        """Take what was told; a desk that was suspended is disarmed before."""
        self._desk.alive()
        if isinstance(told, PadEvent):
            self.hand.heard(told)
        elif isinstance(told, Came):
            self.hand.came(told.sticks)
            button = self._desk.keys.pad.buttons[HOLD]
            self._desk.say(f"{told.name}: once armed, hold its {button} and push a stick")
        elif isinstance(told, Gone):
            self.hand.gone()
            self._desk.say(f"no gamepad: {told.reason}")

    def _do(self, deed: str) -> None:
        """Do what a button is for: the stop anywhere, all else where the jog keys are."""
        desk = self._desk
        if deed == STOP:
            desk.action_stop_arm()
        elif desk.place.hand is not None and len(desk.screen_stack) == 1:
            getattr(desk.place, f"action_{desk.keys.row(deed).action}")()
