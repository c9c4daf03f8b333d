"""Getting a lost wire back: looks for it with longer and longer pauses, and hands it to the engine.

Nothing that was asked of the old wire is asked of the new one: the controller is a fresh one, and
the arm ends in a state in which nothing moves (motion/idle.py).
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.errors import ArmError, LinkLost
from armdrive.motion.context import MotionContext, without_reset
from armdrive.motion.idle import resume
from armdrive.registry import dialect
from armdrive.runtime.engine import Engine
from armdrive.tasks import TaskBody
from armdrive.transports.link import AbsentLink, Link

PAUSES_S = (0.2, 0.3, 0.5, 1.0, 2.0, 5.0)
"""Before each try; the last holds for all further ones. Opening a port can reset a board."""
LET_GO_S = 3.0
"""So long the old wire is waited for, which has the port yet: a bus is still told a stop, say."""


@dataclass(frozen=True, slots=True, eq=False)
class NewLink:
    """How a lost wire is opened again: `open_again` raises `PortUnavailable` until it is there.

    `automatic` begins by itself. With `beside` it is done in a thread of its own, since a network
    can take seconds to say no.
    """

    open_again: Callable[[], Link]
    automatic: bool = False
    beside: bool = False


class Opening:
    """One attempt to open a wire, at once or beside the caller's thread.

    A thread in which the old one is closed comes first: else it would be this program's own hold
    of the port that is found in the way.
    """

    def __init__(
        self,
        rewiring: NewLink,
        wake: Callable[[], None],
        after: threading.Thread | None = None,
    ) -> None:
        self._open = rewiring.open_again
        self._wake = wake
        self._after = after
        self._lock = threading.Lock()
        self._outcome: Link | ArmError | None = None
        self._given_up = False
        if rewiring.beside:
            threading.Thread(target=self._run, name="armdrive-opening", daemon=True).start()
        else:
            self._run()

    @property
    def outcome(self) -> Link | ArmError | None:
        """The wire, or why there is none; None while nobody knows."""
        with self._lock:
            return self._outcome

    def give_up(self) -> None:
        """Close the wire, also where it is only there later."""
        with self._lock:
            self._given_up = True
            outcome = self._outcome
        if outcome is not None and not isinstance(outcome, ArmError):
            outcome.close()

    def _run(self) -> None:
        outcome: Link | ArmError
        if self._after is not None:
            self._after.join(LET_GO_S)
        try:
            outcome = self._open()
        except ArmError as error:
            outcome = error
        except OSError as error:
            outcome = LinkLost(f"the wire cannot be looked for ({error})")
        with self._lock:
            self._outcome = outcome
            unwanted = self._given_up
        if unwanted and not isinstance(outcome, ArmError):
            outcome.close()
        self._wake()


class Reconnector:
    """Looks for the wire of one arm. Called by the engine while it is broken, under its lock."""

    def __init__(self, wire: MotionContext, rewiring: NewLink) -> None:
        self.tries = 0
        """How many attempts have ended, well or not."""
        self.trouble: ArmError | None = None
        """Why the last one failed."""
        self._wire = wire
        self._rewiring = rewiring
        self._opening: Opening | None = None
        self._closing: threading.Thread | None = None
        self._due_s = math.inf
        self._lost_s = 0.0
        self._lost_link = ""
        self._failures = 0

    @property
    def automatic(self) -> bool:
        """Whether a lost wire is looked for without anybody asking."""
        return self._rewiring.automatic

    @property
    def _engine(self) -> Engine:
        return self._wire.engine

    def lost(self, now_s: float) -> None:
        """Give the broken wire back, so that its port is free, and look for it where that is asked.

        Called for a wire that was lost, and for one that was found and has not proved itself.
        """
        self._lost_s = now_s
        old = self._engine.link
        self._lost_link = self._lost_link or old.description
        self._engine.link = AbsentLink(old.description)
        if self._rewiring.beside:  # closing a socket can take a moment
            self._closing = threading.Thread(target=old.close, name="armdrive-closing", daemon=True)
            self._closing.start()
        else:
            old.close()
        if self._rewiring.automatic:
            self._due_s = now_s + self._pause_s()

    def ask(self, now_s: float) -> int:
        """Have the wire looked for now; return how many attempts had ended before."""
        self._due_s = now_s
        return self.tries

    def close(self) -> None:
        """Look no more."""
        self._due_s = math.inf
        opening, self._opening = self._opening, None
        if opening is not None:
            opening.give_up()

    def __call__(self, now_s: float) -> float:
        """Do what is due by now; return when to call again."""
        if self._opening is None:
            if now_s < self._due_s:
                return self._due_s
            self._due_s = math.inf
            self._opening = Opening(self._rewiring, self._engine.link.wake, self._closing)
        outcome = self._opening.outcome
        if outcome is None:
            return math.inf
        self._opening = None
        if isinstance(outcome, ArmError):
            self._failed(outcome, now_s)
        else:
            self._take(outcome)
        return self._due_s

    def _take(self, link: Link) -> None:
        """Go on over a wire, with a controller that knows nothing of the last one's talk."""
        core, absent = self._wire.core, self._engine.link
        core.controller = dialect(core.config.connection.dialect).controller(core.config)
        self._engine.take(link, core.controller)
        absent.close()
        core.diagnostics.notice = f"found {link.description}: asking whether the arm answers"
        # what was sent before the loss may still be running: that is waited for first
        runs_s = max(self._lost_s + core.stop_bound().silent_time_s - self._engine.now_s, 0.0)
        self._engine.start(self._resume(), within_s=runs_s + self._engine.call_limit_s)

    def _resume(self) -> TaskBody[None]:
        """Take up the arm again; whoever does not answer as it did is no wire to it."""
        try:
            yield from resume(self._wire, self._lost_s, self._lost_link)
        except ArmError as error:
            self._failed(error, self._wire.now_s)
            raise LinkLost(
                f"the wire is back, but not the arm: {without_reset(error)}. Nothing moves; look "
                "for it again"
            ) from None
        self.tries += 1
        self._lost_link = ""
        self._failures, self.trouble = 0, None
        self._engine.prove()

    def _failed(self, error: ArmError, now_s: float) -> None:
        self.tries += 1
        self._failures += 1
        self.trouble = error
        self._wire.core.diagnostics.notify(
            f"looked for the wire in vain: {without_reset(error)}", error
        )
        if self._rewiring.automatic:
            self._due_s = now_s + self._pause_s()

    def _pause_s(self) -> float:
        return PAUSES_S[min(self._failures, len(PAUSES_S) - 1)]
