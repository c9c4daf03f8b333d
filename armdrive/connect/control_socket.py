"""The requests that other programs of the same user may send to the program that holds an arm.

A request is one JSON object, `{"request": NAME}` and the request's own keys, and gets one object in
reply; `watch` and `wire` get one after another until either side ends. No request moves an arm, and
only a stop acts before the next burst. storage/arm_lock.py decides which caller is served when.
"""

from __future__ import annotations

import _thread
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import TypeGuard

from armdrive.connect.connection import ArmConnection
from armdrive.errors import ArmError, BadRequest
from armdrive.status import status_view
from armdrive.storage.arm_lock import ArmLock, Json
from armdrive.storage.lock_client import WATCH_EVERY_S
from armdrive.trace.entries import TRAFFIC, TraceEntry
from kinematics.errors import KinematicsError

# Carries out a request; yields one answer, or a stream of them until either side ends.
Answers = Callable[[ArmConnection, Json], Iterator[Json]]

WATCH_RANGE_S = (0.02, 3600.0)
PASSING = "trust_for_s"  # changes by itself as time passes, so that its change is no news
PROGRESS = ("percent", "left_s")  # of a running program, which advance all the time

PERCENT_RANGE = (1, 100)


def serve(lock: ArmLock, arm: ArmConnection) -> None:
    """Answer other programs about an arm, over the socket of its lock.

    Raises `StateFileError` if no program could find the socket.
    """
    arm.core.speed_override.others = True  # `armdrive resume` reaches it from now on
    lock.serve(partial(answered, arm))


def serve_stop(lock: ArmLock, doing: str) -> None:
    """Let other programs stop this one, over the socket of its lock, as Ctrl-C does.

    For a program that turns motors without a connected arm; `doing` says what it does. Raises
    `StateFileError`.
    """

    def answers(words: Json) -> Iterator[Json]:
        if words.get("request") != "stop":
            yield {"error": f"the program that holds the arm {doing}: it can only be stopped"}
            return
        _interrupt_main_thread()
        yield {"done": "stop"}

    lock.serve(lambda words: (False, answers(words)))


def _interrupt_main_thread() -> None:
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, signal.SIGINT)  # also ends its wait for a line or for the wire
    else:
        _thread.interrupt_main()


def _status(arm: ArmConnection, _: Json) -> Iterator[Json]:
    yield _view(arm)


def _stop(arm: ArmConnection, _: Json) -> Iterator[Json]:
    runner = arm.runner
    runner.request_stop(elsewhere=True)
    runner.require_reachable()
    yield {"done": "stop"}


def _pause(arm: ArmConnection, _: Json) -> Iterator[Json]:
    runner = arm.runner
    runner.pause()
    runner.require_reachable("pause")
    yield {"done": "pause"}


def _resume(arm: ArmConnection, _: Json) -> Iterator[Json]:
    runner = arm.runner
    runner.resume()
    runner.require_reachable("resume")
    yield {"done": "resume"}


def _slow(arm: ArmConnection, words: Json) -> Iterator[Json]:
    percent, (low, high) = words.get("percent"), PERCENT_RANGE
    if not _is_number(percent) or not low <= percent <= high:
        raise BadRequest(f"percent is a number from {low} to {high}, not {percent!r:.40}")
    arm.core.speed_override.set_override(percent / 100.0)
    yield {"done": "slow", "percent": percent}


def _record(arm: ArmConnection, _: Json) -> Iterator[Json]:
    """Make the flight recorder write into its own folder, which no caller can change."""
    yield {"recording": str(arm.core.tracer.snapshot("on request")(None))}


def _watch(arm: ArmConnection, words: Json) -> Iterator[Json]:
    """Yield the status whenever it has changed, and once more when the arm is closed.

    An empty object says that nothing has changed; sending it shows whether the caller still reads.
    """
    every_s = _every_s(words)
    last: Json = {}
    while True:
        closed = arm.closed
        view = _view(arm)
        now = _news(view)
        yield {} if now == last else view
        last = now
        if closed:
            return
        time.sleep(every_s)


def _wire(arm: ArmConnection, words: Json) -> Iterator[Json]:
    return traffic(arm, _every_s(words))


def _view(arm: ArmConnection) -> Json:
    view = status_view(arm.status)
    return view if arm.program is None else {**view, "program": arm.program()}


def _news(view: Json) -> Json:
    """Return the part of a status whose change is news: progress in whole percent and seconds."""
    news = {key: value for key, value in view.items() if key != PASSING}
    if isinstance(program := view.get("program"), dict):
        news["program"] = {
            key: _whole(each) if key in PROGRESS else each for key, each in program.items()
        }
    return news


def _whole(value: object) -> int | None:
    return round(value) if isinstance(value, int | float) else None


def _every_s(words: Json) -> float:
    """Return how often to look, within `WATCH_RANGE_S`. Raises `BadRequest`."""
    asked = words.get("every_s", WATCH_EVERY_S)
    if not _is_number(asked):
        raise BadRequest(f"every_s is a number of seconds, not {asked!r:.40}")
    low_s, high_s = WATCH_RANGE_S
    return low_s if asked < low_s else high_s if asked > high_s else float(asked)


def _is_number(value: object) -> TypeGuard[float]:
    """Return whether a JSON value is a number; NaN, which Python's JSON knows, is none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and value == value


# The request `wire`: the bytes on the wire, streamed to another program.
#
# Each message is `{"wire": [[time_s, direction, bytes in hexadecimal], ...], "missed": number of
# skipped entries, "now_s": the arm's clock}`, or `{}` if there was no traffic. The direction is
# `"sent"` for bytes to the arm and `"received"` for bytes from it.

TAP_MOST = 200  # entries fetched from the recorder at once
TAP_BACK = 4000  # a reader further behind than this skips the oldest entries
PIECE_BYTES = 1024  # longer entries are split, because messages have a bounded size
MESSAGE_BYTES = 8192  # an eighth of what a caller accepts (`lock_client.LARGEST_BYTES`)

Piece = tuple[float, str, str]


def traffic(arm: ArmConnection, every_s: float) -> Iterator[Json]:
    """Yield an arm's traffic from now on, polled every `every_s`, until the arm is closed."""
    number, _ = arm.core.tracer.since(0, 0, 0)
    missed = 0
    while True:
        ended = arm.closed
        first, entries = arm.core.tracer.since(number, TAP_MOST, TAP_BACK)
        missed, number = missed + first - number, first + len(entries)
        pieces = [piece for entry in entries if entry.kind in TRAFFIC for piece in _pieces(entry)]
        for message in _messages(pieces):
            yield {"wire": message, "missed": missed, "now_s": arm.pace.now_s()}
            missed = 0
        if len(entries) == TAP_MOST:
            continue
        if ended:
            return
        if not pieces:
            yield {}
        time.sleep(every_s)


def _pieces(entry: TraceEntry) -> Iterator[Piece]:
    data = entry.what if isinstance(entry.what, bytes) else b""
    for at in range(0, len(data), PIECE_BYTES):
        yield entry.time_s, entry.kind.value, data[at : at + PIECE_BYTES].hex()


def _messages(pieces: list[Piece]) -> Iterator[list[Piece]]:
    """Group pieces into messages of at most `MESSAGE_BYTES`."""
    message: list[Piece] = []
    size = 0
    for piece in pieces:
        if message and size + len(piece[2]) > MESSAGE_BYTES:
            yield message
            message, size = [], 0
        message.append(piece)
        size += len(piece[2])
    if message:
        yield message


# The table of requests.

# Every request by its name.
REQUESTS: Mapping[str, Answers] = MappingProxyType(
    {
        "status": _status,
        "stop": _stop,
        "pause": _pause,
        "resume": _resume,
        "slow": _slow,
        "record": _record,
        "watch": _watch,
        "wire": _wire,
    }
)
# Those that are answered until either side ends.
WATCHING = (_watch, _wire)


def answered(arm: ArmConnection, words: Json) -> tuple[bool, Iterator[Json]]:
    """Return whether a request watches the arm, and the answers."""
    name = words.get("request")
    if not isinstance(name, str) or name not in REQUESTS:
        unknown = f"unknown request {name!r:.40}; known are {', '.join(REQUESTS)}"
        return False, iter([{"error": unknown}])
    answers = REQUESTS[name]
    return answers in WATCHING, _guarded(answers, arm, words)


def _guarded(answers: Answers, arm: ArmConnection, words: Json) -> Iterator[Json]:
    """Yield the answers. A fault in this code goes to the caller, and the arm drives on."""
    try:
        yield from answers(arm, words)
    except (ArmError, KinematicsError) as error:
        yield {"error": str(error)}
    except Exception as error:
        yield {"error": f"the program that holds the arm failed to answer: {error!r:.200}"}
