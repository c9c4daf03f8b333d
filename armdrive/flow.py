"""Work in progress: a generator that yields what it waits for, and what has become of it.

A flow yields what it waits for (`Ask` an answer, or `Until` a time) and is resumed with the reply.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from armdrive.controllers.requests import Reply, Request
from armdrive.errors import ArmError, LinkLost

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Ask:
    """Wait for the answer to a request."""

    request: Request


@dataclass(frozen=True, slots=True)
class Until:
    """Wait until a time, or until somebody asks for a stop."""

    time_s: float


Flow = Generator[Ask | Until, Any, T]
"""Work in progress; an `Ask` is answered with a `Reply`, an `Until` with the time."""


class Task(Generic[T]):
    """A flow that was handed to the engine, and what became of it."""

    def __init__(self, flow: Flow[T], *, routine: bool = False, within_s: float = math.inf) -> None:
        """`routine` marks what the engine does by itself in quiet times.

        `within_s` is how long the flow may take. The engine ends it then, whatever the wire says.
        """
        self.flow = flow
        self.routine = routine
        self.within_s = within_s
        self.since_s = math.nan
        """When its time began to count; the engine sets it."""
        self.started = False
        self.over = False
        """Whether the flow has ended."""
        self.done = False
        """Whether the engine has let go of it: whoever waits for it may go on."""
        self.value: T | None = None
        self.error: BaseException | None = None

    @property
    def until_s(self) -> float:
        """When its time is over; infinity while it has not begun to count."""
        return math.inf if math.isnan(self.since_s) else self.since_s + self.within_s

    def result(self) -> T:
        """Return what the flow returned, or raise what it raised."""
        if self.error is not None:
            raise self.error
        return self.value  # type: ignore[return-value]

    def step(self, outcome: Reply | float | ArmError) -> Ask | Until | None:
        """Resume the flow; return what it waits for next, None where it is over.

        A loss of the wire is raised, and leaves the task as it is. What else ends the flow is
        for its waiter; what no program handles, as Ctrl-C, is raised as well.
        """
        try:
            if isinstance(outcome, ArmError):
                return self.flow.throw(outcome)
            value = outcome if self.started else None
            self.started = True
            return self.flow.send(value)
        except StopIteration as end:
            self.over, self.value = True, end.value
        except LinkLost:
            raise
        except Exception as error:  # the flow's own end: its waiter hears of it
            self.over, self.error = True, error
        except BaseException as error:
            self.over, self.error = True, error
            raise
        return None

    def fail(self, error: ArmError) -> None:
        """End a flow that has not begun."""
        self.flow.close()
        self.error, self.done = error, True

    def give_up(self, error: ArmError) -> None:
        """End a flow that answers the end of its time by waiting for something else."""
        self.flow.close()
        self.over, self.error = True, error

    def abandon(self, lost: LinkLost) -> None:
        """Let the flow hear of the loss of the wire where it waits, and end it."""
        self.error = lost
        try:
            self.flow.throw(lost)
        except Exception as error:  # the flow's own words, where it has some
            self.error = error if isinstance(error, ArmError) else lost
        else:  # it wants to wait for something: there is nothing left to wait for
            self.flow.close()
