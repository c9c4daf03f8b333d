"""A small host on a simulated bus of MKS drives: it asks, and lets simulated time pass."""

from functools import partial
from typing import Any

from bus_sim import IDS, LONG_S, BusSim, bus_arm

from armdrive.config.arm import ArmConfig
from firmware_protocol import mks
from firmware_protocol.frames import pack

TURN = 0x4000
STARTED, DONE, FAILED, LIMIT_STOP, STORED = (
    mks.Outcome.STARTED,
    mks.Outcome.DONE,
    mks.Outcome.FAILED,
    mks.Outcome.LIMIT_STOP,
    mks.Outcome.STORED,
)
arm_config = partial(bus_arm, "mks")


class Bench(BusSim[mks.Event]):
    """The twin of an arm, and a host at the other end of its bus."""

    def __init__(
        self,
        ids: tuple[int, ...] = IDS,
        *,
        config: ArmConfig | None = None,
        saved: object = None,
        **settings: Any,
    ) -> None:
        super().__init__(config or arm_config(), saved, **settings)
        self.ids = ids
        self.host = mks.Host(ids)

    def send(self, node: int, request: mks.Request) -> None:
        """Put a request on the bus; to a group or to all, as another program could."""
        if node in self.ids:
            self.link.write(self.host.send(node, request), self.now_s)
        else:
            self.link.write(pack(mks.encode(node, request)), self.now_s)

    def ask(self, node: int, request: mks.Request, seconds: float = LONG_S) -> list[mks.Event]:
        """Put a request on the bus and return what is heard soon after."""
        self.send(node, request)
        return self.run(seconds)

    def counts(self, node: int) -> int:
        """Ask a drive where it is."""
        (event,) = self.ask(node, mks.ReadEncoder())
        assert isinstance(event, mks.Answered)
        assert isinstance(event.answer, mks.EncoderRead)
        return event.answer.counts

    def state(self, node: int) -> Any:
        """Ask a drive what it does."""
        (event,) = self.ask(node, mks.ReadState())
        assert isinstance(event, mks.Answered)
        assert isinstance(event.answer, mks.StateRead)
        return event.answer.state

    def time_of(self, outcome: mks.Outcome) -> float:
        """Return when an outcome was reported last."""
        return next(at for at, event in reversed(self.heard) if outcomes([event]) == [outcome])

    def _read(self) -> None:
        self.host.receive_data(self.link.read(self.now_s))
        while (event := self.host.next_event()) is not None:
            self.heard.append((self.now_s, event))


def outcomes(events: list[mks.Event]) -> list[object]:
    """Return the outcome that each event reports; of others, what kind they are."""
    answers = [getattr(event, "answer", event) for event in events]
    return [each.outcome if isinstance(each, mks.Status) else type(each) for each in answers]
