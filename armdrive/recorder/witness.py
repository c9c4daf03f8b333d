"""Who looks over the driver's shoulder: the few calls by which it tells what happens."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from pathlib import Path

    from armdrive.controllers.requests import Event, Request
    from armdrive.core import Core
    from armdrive.recorder.entries import Entry


class Witness(Protocol):
    """Hears of everything, and changes nothing.

    Called under the lock of the arm's pace, but for `called` and `raised`: those come from any
    thread, a signal handler too, and never wait.
    """

    def begin(self, core: Core, link: str, clock: Callable[[], float]) -> None:
        """Hear which arm it is, on which wire, and by which clock."""

    def opened(self) -> None:
        """Hear that the connection stands."""

    def tick(self, now_s: float, stop_asked: bool, stop_hard: bool) -> None:
        """Hear the time, and whether a stop is asked for."""

    def sent(self, data: bytes) -> None:
        """Hear what is about to be written."""

    def heard(self, data: bytes) -> None:
        """Hear what came in."""

    def asked(self, request: Request) -> None:
        """Hear of a request that begins."""

    def told(self, event: Event) -> None:
        """Hear of an answer, or of what the device said unasked."""

    def changed(self) -> None:
        """Look at the core: state, trust or position may have changed."""

    def called(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Hear of a call, with its arguments."""

    def raised(self, error: BaseException) -> None:
        """Hear of what a call ended with."""

    def ended(self, error: BaseException | None) -> None:
        """Hear of what a task ended with, if not well."""

    def lost(self, error: BaseException) -> None:
        """Hear that the wire is lost."""

    def failed(self, error: BaseException) -> None:
        """Hear that the engine itself has failed."""

    def snapshot(self, why: str) -> Callable[[Path | None], Path]:
        """Return what writes all that is remembered now, to a named file or one of its own."""

    @property
    def began_s(self) -> float:
        """The arm's clock when this began to look."""

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[Entry, ...]]:
        """Return entries from a number on, and the number of the first; see `Ring.since`."""

    def close(self) -> None:
        """Finish what is being written."""


class NoWitness:
    """Nobody looks."""

    def begin(self, core: Core, link: str, clock: Callable[[], float]) -> None:
        """Forget it."""

    def opened(self) -> None:
        """Forget it."""

    def tick(self, now_s: float, stop_asked: bool, stop_hard: bool) -> None:
        """Forget it."""

    def sent(self, data: bytes) -> None:
        """Forget it."""

    def heard(self, data: bytes) -> None:
        """Forget it."""

    def asked(self, request: Request) -> None:
        """Forget it."""

    def told(self, event: Event) -> None:
        """Forget it."""

    def changed(self) -> None:
        """Forget it."""

    def called(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Forget it."""

    def raised(self, error: BaseException) -> None:
        """Forget it."""

    def ended(self, error: BaseException | None) -> None:
        """Forget it."""

    def lost(self, error: BaseException) -> None:
        """Forget it."""

    def failed(self, error: BaseException) -> None:
        """Forget it."""

    def snapshot(self, why: str) -> Callable[[Path | None], Path]:  # noqa: ARG002 - no reason helps
        """Raise `WrongState`: nothing was recorded."""
        raise _nothing()

    @property
    def began_s(self) -> float:
        """Never."""
        return 0.0

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[Entry, ...]]:  # noqa: ARG002
        """Raise `WrongState`: nothing is recorded."""
        raise _nothing()

    def close(self) -> None:
        """Nothing is being written."""


def _nothing() -> Exception:
    from armdrive.errors import WrongState

    return WrongState("this arm was connected without a flight recorder: nothing was recorded")


NO_WITNESS = NoWitness()
