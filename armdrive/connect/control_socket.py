"""The requests that other programs of the same user may send to the program that holds an arm.

A request is one JSON object: `{"request": NAME}` and the request's own keys. Its answer is one
object; `watch`, `follow` and `wire` get a stream of objects until either side ends it. No request
moves an arm, and only a stop acts before the next burst. storage/arm_lock.py decides when a caller
is served.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from armdrive.errors import ArmError, StateFileError
from armdrive.runtime.arm_state import Core
from armdrive.runtime.clock import Pace
from armdrive.status import Status, status_view
from armdrive.storage.arm_lock import Answering, ArmLock, Json
from armdrive.storage.lock_client import WATCH_EVERY_S
from armdrive.trace import wire_tap
from armdrive.trace.calls import Tracer
from armdrive.trace.entries import TraceEntry
from kinematics.errors import KinematicsError


class ControlledArm(Protocol):
    """The part of a held arm that other programs may see and use."""

    core: Core
    pace: Pace
    tracer: Tracer

    @property
    def closed(self) -> bool:
        """Whether the connection is closed."""

    program: Callable[[], Json] | None
    """Returns the progress of the program that the arm runs; None if it runs none."""
    speed_override: float

    @property
    def status(self) -> Status:
        """A frozen snapshot of the arm."""

    def request_stop(self) -> None:
        """Request a stop, and return at once."""

    def pause(self) -> None:
        """Pause the arm after its next burst or segment."""

    def resume(self) -> None:
        """Resume a paused arm."""

    def save_recording(self) -> Path:
        """Write the flight recorder's contents to a file, and return its path."""

    def close(self) -> None:
        """Stop, and close the port."""


Stream = Callable[[ControlledArm, float], Iterator[Json]]

WATCH_RANGE_S = (0.02, 3600.0)
PASSING = ("trust_for_s", "percent", "left_s")
"""Keys that change by themselves as time passes: their changes are not reported."""

PERCENT_RANGE = (1, 100)


def serve(lock: ArmLock, arm: ControlledArm) -> None:
    """Answer other programs' requests about an arm, over the socket of its lock.

    If other programs could not find the socket, closes the arm and raises `StateFileError`.
    """
    arm.core.speed_override.others = True  # from now on, `armdrive resume` can resume the arm
    try:
        lock.serve(partial(answered, arm))
    except StateFileError:
        arm.close()
        lock.release()
        raise


def _watched(
    arm: ControlledArm, every_s: float, seen: Callable[[Json], Json] | None = None
) -> Iterator[Json]:
    """Yield the status whenever it has changed, and once more when the arm is closed.

    An empty object means that nothing has changed; sending it shows whether the caller still reads.
    `seen` returns the part of a status that is compared.
    """
    last: Json = {}
    while True:
        closed = arm.closed
        view = _status(arm, {})
        lasting = (seen or _lasting)(view)
        yield {} if lasting == last else view
        last = lasting
        if closed:
            return
        time.sleep(every_s)


def _lasting(view: Json) -> Json:
    """Return a status without the keys in `PASSING`."""
    program = view.get("program")
    lasting = {key: value for key, value in view.items() if key not in PASSING}
    if isinstance(program, dict):
        lasting["program"] = {key: each for key, each in program.items() if key not in PASSING}
    return lasting


def _followed(arm: ControlledArm, every_s: float) -> Iterator[Json]:
    """Yield the status like `_watched`, and also whenever a program has advanced."""
    return _watched(arm, every_s, _shown)


def _shown(view: Json) -> Json:
    """Return the part of a status that a person sees, with progress in percent and seconds."""
    program = view.get("program")
    further = program if isinstance(program, dict) else {}
    return {**_lasting(view), "further": [_whole(further.get(word)) for word in PASSING]}


def _whole(value: object) -> int | None:
    return round(value) if isinstance(value, int | float) else None


def _every_s(words: Mapping[str, Any]) -> float | None:
    """Return the requested interval, limited to `WATCH_RANGE_S`; None if it is not a number."""
    asked = words.get("every_s", WATCH_EVERY_S)
    if isinstance(asked, bool) or not isinstance(asked, int | float) or asked != asked:
        return None
    low_s, high_s = WATCH_RANGE_S
    return low_s if asked < low_s else high_s if asked > high_s else float(asked)


def _wire(arm: ControlledArm, every_s: float) -> Iterator[Json]:
    """Yield the bytes on the arm's wire, in the form of wire_tap.py."""

    def since(number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:
        with arm.pace.lock:
            return arm.tracer.since(number, most, back)

    return wire_tap.tap_messages(since, arm.pace.now_s, lambda: arm.closed, every_s)


def _status(arm: ControlledArm, _: Json) -> Json:
    view = status_view(arm.status)
    return view if arm.program is None else {**view, "program": arm.program()}


def _stop(arm: ControlledArm, _: Json) -> Json:
    arm.request_stop()
    return {"done": "stop"}


def _pause(arm: ControlledArm, _: Json) -> Json:
    arm.pause()
    return {"done": "pause"}


def _resume(arm: ControlledArm, _: Json) -> Json:
    arm.resume()
    return {"done": "resume"}


def _slow(arm: ControlledArm, words: Json) -> Json:
    percent = words.get("percent")
    low, high = PERCENT_RANGE
    if (
        isinstance(percent, bool)
        or not isinstance(percent, int | float)
        or not low <= percent <= high  # also refuses NaN
    ):
        return {"error": f"percent is a number from {low} to {high}, not {percent!r:.40}"}
    arm.speed_override = percent / 100.0
    return {"done": "slow", "percent": percent}


def _record(arm: ControlledArm, _: Json) -> Json:
    """Save a recording in the recorder's own folder; the caller cannot choose another."""
    return {"recording": str(arm.save_recording())}


# The table of requests.


@dataclass(frozen=True, slots=True)
class ControlRequest:
    """A request and its reply: one object, or a stream of them until either side ends."""

    one: Callable[[ControlledArm, Json], Json] | None = None
    stream: Stream | None = None
    way: Answering = Answering.IN_TURN

    def answers(self, arm: ControlledArm, words: Json) -> Iterator[Json]:
        """Yield the answers. An error in this code goes to the caller; the arm is not affected."""
        if self.stream is not None:
            every_s = _every_s(words)
            if every_s is None:
                asked = words["every_s"]
                yield {"error": f"every_s is a number of seconds, not {asked!r:.40}"}
                return
            yield from self.stream(arm, every_s)
        if self.one is not None:
            try:
                yield self.one(arm, words)
            except (ArmError, KinematicsError) as error:
                yield {"error": str(error)}
            except Exception as error:
                yield {"error": f"the program that holds the arm failed to answer: {error!r:.200}"}


WIRE = "wire"

REQUESTS: Mapping[str, ControlRequest] = MappingProxyType(
    {
        "status": ControlRequest(_status),
        "stop": ControlRequest(_stop, way=Answering.AT_ONCE),  # before any other request
        "pause": ControlRequest(_pause),
        "resume": ControlRequest(_resume),
        "slow": ControlRequest(_slow),
        "record": ControlRequest(_record),
        "watch": ControlRequest(stream=_watched, way=Answering.WATCHING),
        "follow": ControlRequest(stream=_followed, way=Answering.WATCHING),
        WIRE: ControlRequest(stream=_wire, way=Answering.WATCHING),
    }
)
"""Every request by its name."""


def answered(arm: ControlledArm, words: Json) -> tuple[Answering, Iterator[Json]]:
    """Return how a request is answered, and the answers."""
    name = words.get("request")
    request = REQUESTS.get(name) if isinstance(name, str) else None
    if request is None:
        known = ", ".join(REQUESTS)
        unknown = {"error": f"unknown request {name!r:.40}; known are {known}"}
        return Answering.IN_TURN, iter([unknown])
    return request.way, request.answers(arm, words)
