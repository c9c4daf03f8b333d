"""What every family of calls stands on: an arm from its connection to its close."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive.calls.waiting import Waiting
from armdrive.controllers.requests import Alert, Progress
from armdrive.core import Core
from armdrive.deadlines import call_limit_s
from armdrive.dialects import dialect
from armdrive.engine import Engine
from armdrive.errors import LinkLost
from armdrive.flow import Flow
from armdrive.flows import idling, referencing
from armdrive.flows.alerts import alerted
from armdrive.flows.exchange import Wire
from armdrive.mending import Mender
from armdrive.pace import RealPace
from armdrive.received import Received
from armdrive.recorder.witness import NO_WITNESS, Witness
from armdrive.states import Event
from armdrive.status import State

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.log.reader import LogReader
    from armdrive.mending import Rewiring
    from armdrive.pace import Pace
    from armdrive.posture import Operator
    from armdrive.record import Recorder
    from armdrive.recorder.entries import Entry
    from armdrive.sim.twin import Twin
    from armdrive.transports.link import Link

CLOSING_S = 10.0
"""A disk that takes longer to remember where the arm was left is not waited for."""


class Connected(Waiting):
    """An arm on an open link. Its calls hand flows to the engine and wait for their end."""

    def __init__(
        self,
        config: ArmConfig,
        link: Link,
        pace: Pace,
        *,
        simulated: bool,
        recorder: Recorder | None = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
        witness: Witness = NO_WITNESS,
        rewiring: Rewiring | None = None,
    ) -> None:
        """Connect over an open link. Raises `NoAnswer` where no such arm answers; moves nothing."""
        self.config = config
        self.pace = pace
        self.simulated = simulated
        self.twin: Twin | None = None
        self.operator = operator
        self.witness = witness
        self._on_close: list[Callable[[], None]] = []
        controller = dialect(config.connection.dialect).controller(config)
        # on simulated time a disk takes no time: what has to be written is written at once
        wake = pace.wake if isinstance(pace, RealPace) else None
        self.core = Core(config, controller, recorder, wake)
        self.core.allow_restored = allow_restored
        self.core.witness = witness
        self.core.tempo.others = isinstance(pace, RealPace)
        self.core.geometry_known |= simulated  # a simulated arm is what its numbers say
        self.engine = Engine(
            link,
            controller,
            idle=self._idle,
            stopping=self._stopping,
            lost=self._lost,
            noticed=self._noticed,
            witness=witness,
            received=Received(on_bus=dialect(config.connection.dialect).can),
            call_limit_s=call_limit_s(config.device),
        )
        self.wire = Wire(self.engine, self.core)
        self._idling = idling.Idling(self.wire)
        self.closed = False
        self.mender = None if rewiring is None else Mender(self.wire, rewiring)
        self.engine.mending = self.mender
        witness.begin(self.core, link.description, pace.now_s)
        pace.start(self.engine)
        try:
            self.perform(referencing.connect(self.wire))
            with pace.lock:
                witness.opened()
        except BaseException:
            self._release()
            raise

    def save_recording(self, path: Path | str | None = None) -> Path:
        """Write what the flight recorder holds, and return the file.

        Without a path it goes into the folder of recordings. Raises `StateFileError` where it
        cannot be written, and `WrongState` where nothing is recorded.
        """
        with self.pace.lock:
            write = self.witness.snapshot("asked for")
        return write(None if path is None else Path(path))

    def log(self, *, back: int | None = None) -> LogReader:
        """Return a reader of what passes on the wire and in the driver, in words.

        It begins with the latest `back` entries (2000 where none is named), and each `read()` goes
        on from where the last one ended. Raises `WrongState` where nothing is recorded.
        """
        from armdrive.log.reader import BACK, LogReader

        dialect, began_s = self.config.connection.dialect, self.witness.began_s
        return LogReader(self._since, dialect, began_s, back=BACK if back is None else back)

    def _since(self, number: int, most: int, back: int) -> tuple[int, tuple[Entry, ...]]:
        with self.pace.lock:
            return self.witness.since(number, most, back)

    # -- the end ------------------------------------------------------------------------------

    def close(self) -> None:
        """Stop, remember the position, and give the port back. Closing twice is no error."""
        try:
            if self.core.state is not State.DISCONNECTED:
                self.stop()
                with self.pace.lock:
                    if self.engine.broken is None:  # else the mark of motion has to stay
                        self.core.mark_still()
        finally:
            with self.pace.lock:
                self.closed = True
                if self.mender is not None:
                    self.mender.close()
                self.core.happen(Event.LOST)
                self.engine.close()
            self._release()

    def on_close(self, call: Callable[[], None]) -> None:
        """Have something done once when the arm is closed."""
        self._on_close.append(call)

    def _release(self) -> None:
        self.pace.close()
        self.engine.link.close()
        self.core.memory.finish(CLOSING_S)
        self.witness.close()
        calls, self._on_close = self._on_close, []
        for call in calls:
            call()

    # -- what the engine calls ----------------------------------------------------------------

    def _idle(self, now_s: float) -> tuple[float, Flow[Any] | None]:
        return self._idling.due(now_s)

    def _stopping(self) -> None:
        self.core.tempo.end_pause()
        if self.core.state in (State.MOVING, State.HOMING):
            self.core.happen(Event.STOP)

    def _noticed(self, event: Alert | Progress) -> None:
        if isinstance(event, Progress):
            self.core.progress(event.registers)
        else:
            alerted(self.core, event, self.engine.now_s)

    def _lost(self, lost: LinkLost) -> None:
        self.core.lose(lost)
        self.core.remember()
        if self.mender is not None:
            self.mender.lost(self.engine.now_s)
