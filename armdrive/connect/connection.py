"""The connection of an arm: reconnected when it is lost, and closed once, however its use ends.

An arm in real time has a thread, a port and a lock, which nothing ends by itself. So its connection
is closed by `Arm.close`, at the end of the program, and if the program loses the arm without
closing it: then with a `ResourceWarning`, as for a file. No way of closing moves the arm.
"""

from __future__ import annotations

import atexit
import gc
import threading
import warnings
import weakref
from collections.abc import Callable
from logging import getLogger
from typing import Any

from armdrive.blocking import Wait, run_blocking
from armdrive.connect.port import Reconnector
from armdrive.connect.runner import PATIENCE_S, TaskRunner
from armdrive.errors import ArmError, ArmInUse, NoAnswer, WrongState
from armdrive.runtime.engine import closed_for_good
from armdrive.runtime.states import Event
from armdrive.status import State, Status
from armdrive.storage.arm_lock import ArmLock, hold

# Returns the progress of a running program, as plain data.
ProgramView = Callable[[], dict[str, Any]]

# The log of what no call can report.
LOGGER = "armdrive"

# Closing waits at most this long for the disk to record the arm's position.
CLOSING_S = 10.0


class ArmConnection:
    """The connection of one arm. It does not hold the runner, so that the loss of that shows."""

    def __init__(
        self, runner: TaskRunner, reconnector: Reconnector | None, *, simulated: bool
    ) -> None:
        self.core, self.engine, self.pace = runner.core, runner.engine, runner.pace
        self.closed = False
        self.closers: list[Callable[[], None]] = []
        """Functions to call, in this order, once the arm is closed."""
        self.program: ProgramView | None = None
        """Describes the running program to other processes; None if none is running."""
        self._simulated = simulated
        self.reconnector = reconnector
        self._runner = weakref.ref(runner)
        self._guarded = False
        self._closing: ClosingThread | None = None

    @property
    def runner(self) -> TaskRunner:
        """The arm's runner; a new one if the program has lost it."""
        return self._runner() or TaskRunner(self.core, self.engine, self.pace)

    @property
    def status(self) -> Status:
        """A frozen snapshot of the arm."""
        with self.pace.lock:
            return self.core.status(
                self.engine,
                simulated=self._simulated,
                scheduling_jitter=self.pace.scheduling_jitter,
            )

    @property
    def reconnects(self) -> bool:
        """Whether a lost connection is restored automatically."""
        return self.reconnector is not None and self.reconnector.automatic

    async def reconnect(self) -> None:
        """Try once to restore a lost connection; see `Arm.reconnect`."""
        reconnector = self.reconnector
        with self.pace.lock:
            if self.engine.broken is None:
                raise WrongState("the arm is connected: there is nothing to reconnect")
            if reconnector is None or self.closed:
                raise closed_for_good()
            before = reconnector.ask(self.pace.now_s())
        self.pace.wake()
        if not await Wait(self.pace, lambda: reconnector.tries > before, PATIENCE_S):
            raise NoAnswer("the result of reconnecting is not known yet: reconnect again")
        if self.core.state is State.DISCONNECTED and reconnector.trouble is not None:
            raise reconnector.trouble

    # -- closing ------------------------------------------------------------------------------

    async def close(self) -> None:
        """Stop, save the position, and release the port. Closing twice is no error."""
        if self.engine.forked:  # the port, the record and the lock are the parent's
            self.closed = True
            return
        try:
            if self.core.state is not State.DISCONNECTED:
                await self.runner.stop()
                with self.pace.lock:
                    if self.engine.broken is None:  # after a lost link the motion mark must stay
                        self.core.mark_still()
        finally:
            with self.pace.lock:
                self.closed = True
                if self.reconnector is not None:
                    self.reconnector.close()
                self.core.happen(Event.LOST)
                self.engine.close()
            self.release()

    def release(self) -> None:
        """Stop the engine, close the link, finish pending writes, and call the closers.

        In this order: the engine's thread must not use a closed link, and the lock of the arm, one
        of the closers, keeps other programs off until the port is free and the record is written.
        """
        self.pace.close()
        self.engine.link.close()
        self.core.memory.finish(CLOSING_S)
        self.core.tracer.close()
        if trouble := self.core.tracer.files.take_trouble():  # no notice has shown it
            getLogger(LOGGER).warning("armdrive: %s: %s", self.core.config.name, trouble)
        while self.closers:
            self.closers.pop(0)()

    def guard(self) -> None:
        """Close the connection at the end of the program, or once the program has lost its arm."""
        runner = self._runner()
        if self._guarded or runner is None:
            return
        self._guarded = True
        lost = weakref.finalize(runner, self._lost)
        lost.atexit = False  # at the end of the program there is `_close_at_exit`
        atexit.register(self._close_at_exit)

        def unguard() -> None:
            lost.detach()
            if self._closing is None:  # the end of the program waits for that thread's last word
                atexit.unregister(self._close_at_exit)

        self.closers.append(unguard)

    def _close_at_exit(self) -> None:
        if self._closing is None:
            self._close_uncalled()
        else:
            self._closing.join()

    def _close_uncalled(self) -> None:
        """Close an arm that its program did not close; what goes wrong is a line of the log.

        Without a handler for the log, Python prints such a line on the error output.
        """
        try:
            run_blocking(self.close())
        except ArmError as error:
            getLogger(LOGGER).critical("armdrive: closing %s: %s", self.core.config.name, error)
        finally:
            atexit.unregister(self._close_at_exit)

    def _lost(self) -> None:
        """Close an arm that the program has lost, in a thread.

        The garbage collector may call this in any thread and under any lock, so it waits for none.
        """
        if self.closed or self.engine.forked:
            return
        self._closing = closing = ClosingThread(self._close_uncalled)
        try:
            closing.start()
        except RuntimeError:  # no thread is left: closed at the program's end
            self._closing = None
        warnings.warn(
            f"{self.core.config.name} was not closed, and is stopped and closed now: use the arm "
            "in a `with` statement, or call `close`",
            ResourceWarning,
            stacklevel=2,
        )


class ClosingThread(threading.Thread):
    """Closes a lost arm. As a daemon, it starts without a lock that its starter may hold."""

    def __init__(self, close: Callable[[], None]) -> None:
        super().__init__(target=close, name="armdrive-lost", daemon=True)


def hold_arm(*names: str) -> ArmLock:
    """Lock an arm under all its names, like `hold`, also if this program has just lost it."""
    try:
        return hold(*names)
    except ArmInUse:
        gc.collect()  # an exception keeps the arm of its traceback in a cycle of references
        for each in threading.enumerate():
            if isinstance(each, ClosingThread):
                each.join(PATIENCE_S)
        return hold(*names)
