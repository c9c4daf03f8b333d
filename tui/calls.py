"""Calls that the keys of the desk ask for, and the message about how each one went."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

from armdrive import Arm
from armdrive.errors import ArmError
from armdrive.status import Status
from kinematics.errors import KinematicsError
from tui.app import KeyApp

Done = str | Callable[[Status], str] | None
"""The message after a successful call: a sentence, or one made from the status."""


class DeskCalls:
    """Makes calls for the screens of a desk, and reports how each one went.

    A call that takes a moment is made in a thread, so that the stop key never waits for it.
    """

    def __init__(self, app: KeyApp, arm: Arm) -> None:
        self._app = app
        self._arm = arm

    @contextlib.contextmanager
    def reporting_refusals(self) -> Iterator[None]:
        """Have the next picture say why what is asked for here is refused."""
        try:
            yield
        except (ArmError, KinematicsError, OSError) as error:
            self._app.message = str(error)

    @contextlib.contextmanager
    def acting(self) -> Iterator[None]:
        """Show what came of a key or a click, or say why what it asked for is refused."""
        with self.reporting_refusals():
            yield
        self._app.show()

    def in_thread(self, work: Callable[[], object]) -> None:
        """Do work that takes a moment, without keeping the stop key waiting."""
        self._app.run_worker(work, thread=True, exit_on_error=False)

    def make(self, call: Callable[[], object], done: Done) -> None:
        """Make a call in a thread, and show how it went.

        `done` is the message after success, or makes one of the status; None shows no message.
        """

        def work() -> None:
            if (message := self._outcome(call, done)) is not None:
                self._app.call_from_thread(self._app.say, message)

        self.in_thread(work)

    def _outcome(self, call: Callable[[], object], done: Done) -> str | None:
        """Make a call; return the message about it, None if the status shows enough."""
        try:
            call()
            return done(self._arm.status) if callable(done) else done
        except (ArmError, KinematicsError) as error:
            return str(error)
        except Exception as flaw:  # the desk and its stop key must live on
            return f"a flaw of armdrive, please report it: {type(flaw).__name__}: {flaw}"
