"""What other programs of the same user may ask of the holder of an arm: one table of requests.

Each is one JSON object, `{"request": NAME}` with the request's own words beside it, and is answered
by one; `watch` and `wire` by one a moment, until either side ends. Only a stop reaches further than
the next burst: nobody moves an arm from outside.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError
from armdrive.overhearing import overheard
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from armdrive.arm import Arm

Json = dict[str, Any]
Stream = Callable[["Arm", float], Iterator[Json]]

WATCH_EVERY_S = 0.2
WATCH_RANGE_S = (0.02, 3600.0)
PASSING = ("trust_for_s", "percent", "left_s")
"""What changes by itself as time passes is nothing that has happened."""

MOST_WATCHERS = 16
"""Each is a thread of the holder's."""


class Neighbours:
    """Answers the other programs about one arm, from as many threads as they are."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self._places = threading.BoundedSemaphore(MOST_WATCHERS)

    def answer(self, data: bytes, send: Callable[[bytes], None]) -> None:
        """Answer a message. Raises what `send` raises, and `ValueError` for what is no JSON."""
        for reply in self._replies(json.loads(data)):
            send(json.dumps(reply).encode())

    def _replies(self, message: object) -> Iterator[Json]:
        words = message if isinstance(message, dict) else {}
        request = words.get("request")
        stream = _STREAMS.get(request) if isinstance(request, str) else None
        if stream is not None:
            return self._streamed(stream, _every_s(words))
        answer = _ANSWERS.get(request) if isinstance(request, str) else None
        if answer is None:
            known = ", ".join(REQUESTS)
            return iter([{"error": f"unknown request {request!r}; known are {known}"}])
        return iter([_answered(answer, self._arm, words)])

    def _streamed(self, stream: Stream, every_s: float) -> Iterator[Json]:
        """Give one thing after the other, where there is a place for one more watcher."""
        if not self._places.acquire(blocking=False):
            yield {"error": f"{MOST_WATCHERS} programs watch this arm already"}
            return
        try:
            yield from stream(self._arm, every_s)
        finally:
            self._places.release()


def _watched(
    arm: Arm, every_s: float, seen: Callable[[Json], Json] | None = None
) -> Iterator[Json]:
    """Give the status whenever it has changed, and at last when the arm has been closed.

    What has not changed is said with nothing, which shows whether anybody still listens. `seen`
    returns what of a status is compared.
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
    """Return what of a status does not change by itself as time passes."""
    program = view.get("program")
    lasting = {key: value for key, value in view.items() if key not in PASSING}
    if isinstance(program, dict):
        lasting["program"] = {key: each for key, each in program.items() if key not in PASSING}
    return lasting


def _followed(arm: Arm, every_s: float) -> Iterator[Json]:
    """Give the status as `_watched` does, and whenever a program has come further as well."""
    return _watched(arm, every_s, _shown)


def _shown(view: Json) -> Json:
    """Return what of a status a person sees change: of a program, whole percents and seconds."""
    program = view.get("program")
    further = program if isinstance(program, dict) else {}
    return {**_lasting(view), "further": [_whole(further.get(word)) for word in PASSING]}


def _whole(value: object) -> int | None:
    return round(value) if isinstance(value, int | float) else None


def _every_s(words: Json) -> float:
    asked = words.get("every_s")
    if isinstance(asked, bool) or not isinstance(asked, int | float):
        return WATCH_EVERY_S
    low_s, high_s = WATCH_RANGE_S
    return min(max(float(asked), low_s), high_s)


def _answered(answer: Callable[[Arm, Json], Json], arm: Arm, words: Json) -> Json:
    try:
        return answer(arm, words)
    except (ArmError, KinematicsError) as error:
        return {"error": str(error)}


def _status(arm: Arm, _: Json) -> Json:
    from armdrive.view import status_view

    view = status_view(arm.status)
    return view if arm.program is None else {**view, "program": arm.program()}


def _stop(arm: Arm, _: Json) -> Json:
    arm.request_stop()
    return {"done": "stop"}


def _pause(arm: Arm, _: Json) -> Json:
    arm.pause()
    return {"done": "pause"}


def _resume(arm: Arm, _: Json) -> Json:
    arm.resume()
    return {"done": "resume"}


def _slow(arm: Arm, words: Json) -> Json:
    percent = words.get("percent")
    if isinstance(percent, bool) or not isinstance(percent, int | float):
        return {"error": f"percent is a number from 1 to 100, not {percent!r}"}
    arm.speed_override = percent / 100.0
    return {"done": "slow", "percent": percent}


def _record(arm: Arm, _: Json) -> Json:
    """Have the flight recorder write into its own folder: no caller says where."""
    return {"recording": str(arm.save_recording())}


WATCH = "watch"
FOLLOW = "follow"
WIRE = "wire"
_STREAMS: Mapping[str, Stream] = MappingProxyType(
    {WATCH: _watched, FOLLOW: _followed, WIRE: overheard}
)
_ANSWERS: Mapping[str, Callable[[Arm, Json], Json]] = MappingProxyType(
    {
        "status": _status,
        "stop": _stop,
        "pause": _pause,
        "resume": _resume,
        "slow": _slow,
        "record": _record,
    }
)

REQUESTS = (*_ANSWERS, *_STREAMS)
"""Every request by its name."""
