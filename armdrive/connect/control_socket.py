"""What other programs of the same user may ask of the holder of an arm: one table of requests.

Each is one JSON object, `{"request": NAME}` with the request's own words beside it, and is answered
by one; `watch` and `wire` by one a moment, until either side ends. Only a stop reaches further than
the next burst: nobody moves an arm from outside. Who is served when stands in control_server.py.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError
from armdrive.trace.wire_tap import overheard
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from armdrive.arm import Arm

Json = dict[str, Any]
Stream = Callable[["Arm", float], Iterator[Json]]

WATCH_EVERY_S = 0.2
WATCH_RANGE_S = (0.02, 3600.0)
PASSING = ("trust_for_s", "percent", "left_s")
"""What changes by itself as time passes is nothing that has happened."""

MOST_REQUEST_BYTES = 4096
"""Every request fits into a tenth of that."""
PERCENT_RANGE = (1, 100)


class Neighbours:
    """Answers the other programs about one arm, from as many threads as they are."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm

    def answer(self, message: Mapping[str, Any], send: Callable[[bytes], None]) -> None:
        """Answer a message. Raises what `send` raises."""
        for reply in self._replies(message):
            send(json.dumps(reply).encode())

    def _replies(self, words: Mapping[str, Any]) -> Iterator[Json]:
        request = words.get("request")
        stream = _STREAMS.get(request) if isinstance(request, str) else None
        if stream is not None:
            every_s = _every_s(words)
            if every_s is None:
                asked = words["every_s"]
                return iter([{"error": f"every_s is a number of seconds, not {asked!r:.40}"}])
            return stream(self._arm, every_s)
        answer = _ANSWERS.get(request) if isinstance(request, str) else None
        if answer is None:
            known = ", ".join(REQUESTS)
            return iter([{"error": f"unknown request {request!r:.40}; known are {known}"}])
        return iter([_answered(answer, self._arm, words)])


def parsed(data: bytes) -> Json:
    """Return a request's words. Raises `ValueError` with a sentence for what is no JSON object."""
    try:
        message = json.loads(data.decode("utf-8"))
    except (ValueError, RecursionError):
        message = None
    if isinstance(message, dict):
        return message
    raise ValueError('a request is a JSON object in UTF-8, like {"request": "status"}')


def is_stop(message: Mapping[str, Any]) -> bool:
    """Tell whether a request is a stop, which waits for nobody."""
    return message.get("request") == STOP


def is_stream(message: Mapping[str, Any]) -> bool:
    """Tell whether a request is answered until either side ends."""
    request = message.get("request")
    return isinstance(request, str) and request in _STREAMS


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


def _every_s(words: Mapping[str, Any]) -> float | None:
    """Return how often to look, within `WATCH_RANGE_S`; None for what is no number."""
    asked = words.get("every_s", WATCH_EVERY_S)
    if isinstance(asked, bool) or not isinstance(asked, int | float) or asked != asked:
        return None
    low_s, high_s = WATCH_RANGE_S
    return low_s if asked < low_s else high_s if asked > high_s else float(asked)


def _answered(
    answer: Callable[[Arm, Mapping[str, Any]], Json], arm: Arm, words: Mapping[str, Any]
) -> Json:
    try:
        return answer(arm, words)
    except (ArmError, KinematicsError) as error:
        return {"error": str(error)}
    except Exception as error:  # a flaw of ours: the caller hears of it, and the arm drives on
        return {"error": f"the program that holds the arm failed to answer: {error!r:.200}"}


def _status(arm: Arm, _: Mapping[str, Any]) -> Json:
    from armdrive.status import status_view

    view = status_view(arm.status)
    return view if arm.program is None else {**view, "program": arm.program()}


def _stop(arm: Arm, _: Mapping[str, Any]) -> Json:
    arm.request_stop()
    return {"done": "stop"}


def _pause(arm: Arm, _: Mapping[str, Any]) -> Json:
    arm.pause()
    return {"done": "pause"}


def _resume(arm: Arm, _: Mapping[str, Any]) -> Json:
    arm.resume()
    return {"done": "resume"}


def _slow(arm: Arm, words: Mapping[str, Any]) -> Json:
    percent = words.get("percent")
    low, high = PERCENT_RANGE
    if (
        isinstance(percent, bool)
        or not isinstance(percent, int | float)
        or not low <= percent <= high  # NaN is not between them either
    ):
        return {"error": f"percent is a number from {low} to {high}, not {percent!r:.40}"}
    arm.speed_override = percent / 100.0
    return {"done": "slow", "percent": percent}


def _record(arm: Arm, _: Mapping[str, Any]) -> Json:
    """Have the flight recorder write into its own folder: no caller says where."""
    return {"recording": str(arm.save_recording())}


STOP = "stop"
WATCH = "watch"
FOLLOW = "follow"
WIRE = "wire"
_STREAMS: Mapping[str, Stream] = MappingProxyType(
    {WATCH: _watched, FOLLOW: _followed, WIRE: overheard}
)
_ANSWERS: Mapping[str, Callable[[Arm, Mapping[str, Any]], Json]] = MappingProxyType(
    {
        "status": _status,
        STOP: _stop,
        "pause": _pause,
        "resume": _resume,
        "slow": _slow,
        "record": _record,
    }
)

REQUESTS = (*_ANSWERS, *_STREAMS)
"""Every request by its name."""
