"""Damaged frames for every registered codec, and the three things that must hold of them.

Nothing raises. Memory stays bounded. After bad bytes the first good frame may be lost, to a line
end that is missing; but one is heard by the time that good frames as long as the longest of the
dialect have followed the first: so much a spoilt length can hide.
"""

from __future__ import annotations

import functools
import gc
import random
import sys
import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from fuzzing import FuzzCase, Machine

CODECS = tuple(
    sorted(path.stem.partition("_")[2] for path in Path(__file__).parent.glob("cases_*.py"))
)
"""Whatever has a module cases_NAME, with a HOST, a DEVICE or both, is registered by that."""

_Cache = functools._lru_cache_wrapper

FRAMES_KEPT = 6
"""So far up the stack an allocation is looked for in a codec."""

MOST_GROWN_BYTES = 1 << 14
RESYNC_EVERY = 10


class Violation(Exception):
    """What did not hold, and after how many frames."""

    def __init__(self, frames: int, what: str) -> None:
        self.frames = frames
        self.what = what
        super().__init__(f"frame {frames}: {what}")


@dataclass(slots=True)
class Tally:
    """What a run has done and seen: totals, and the worst of each."""

    frames: int = 0
    fed_bytes: int = 0
    resyncs: int = 0
    most_good_frames: int = 0

    def add(self, other: Tally) -> None:
        """Take in another run."""
        self.frames += other.frames
        self.fed_bytes += other.fed_bytes
        self.resyncs += other.resyncs
        self.most_good_frames = max(self.most_good_frames, other.most_good_frames)


def registered(codecs: Sequence[str] = CODECS) -> list[FuzzCase]:
    """Return both ends of every codec, or the one that takes bytes."""
    modules = [import_module(f"cases_{codec}") for codec in codecs]
    ends = (vars(module).get(end) for module in modules for end in ("HOST", "DEVICE"))
    return [end for end in ends if end is not None]


def _flipped(rng: random.Random, frame: bytearray, _: bytes) -> None:
    for _flip in range(rng.randint(1, 4)):
        frame[rng.randrange(len(frame))] ^= 1 << rng.randrange(8)


def _truncated(rng: random.Random, frame: bytearray, _: bytes) -> None:
    del frame[rng.randrange(len(frame)) :]


def _beheaded(rng: random.Random, frame: bytearray, _: bytes) -> None:
    del frame[: rng.randint(1, len(frame))]


def _dropped(rng: random.Random, frame: bytearray, _: bytes) -> None:
    del frame[rng.randrange(len(frame))]


def _doubled(rng: random.Random, frame: bytearray, _: bytes) -> None:
    at = rng.randrange(len(frame))
    frame[at:at] = frame[at : at + rng.randint(1, len(frame))]


def _spliced(rng: random.Random, frame: bytearray, other: bytes) -> None:
    frame[rng.randrange(len(frame)) :] = other[rng.randrange(len(other)) :]


def _sprinkled(rng: random.Random, frame: bytearray, _: bytes) -> None:
    at = rng.randrange(len(frame) + 1)
    frame[at:at] = rng.randbytes(rng.randint(1, 6))


def _noise(rng: random.Random, frame: bytearray, _: bytes) -> None:
    frame[:] = rng.randbytes(rng.choice((1, 3, 10, 40, 40, 600)))


def _untouched(_: random.Random, __: bytearray, ___: bytes) -> None:
    """Leave the frame good."""


DAMAGES: tuple[Callable[[random.Random, bytearray, bytes], None], ...] = (
    *(_flipped, _truncated, _beheaded, _dropped, _doubled, _spliced, _sprinkled, _noise),
    _untouched,
)


def damaged(rng: random.Random, good: Callable[[random.Random], bytes]) -> bytes:
    """Return a good frame after one or two misfortunes, or none."""
    frame = bytearray(good(rng))
    for _ in range(rng.randint(1, 2)):
        if frame:
            rng.choice(DAMAGES)(rng, frame, good(rng))
    return bytes(frame)


def feed(machine: Machine, rng: random.Random, data: bytes) -> None:
    """Give a machine bytes whole, one by one, or in random portions."""
    how = rng.randrange(8)
    at = 0
    while at < len(data):
        size = len(data) if how < 4 else 1 if how == 4 else rng.randint(1, 12)
        machine.receive_data(data[at : at + size])
        at += size


def run(case: FuzzCase, seed: int, frames: int) -> Tally:
    """Feed damaged frames to one machine; raises `Violation`. The seed repeats it exactly."""
    rng = random.Random(f"{case.name} {seed}")
    longest = max(len(case.good(rng)) for _ in range(1000))
    machine, tally = case.make(), Tally()
    for number in range(1, frames + 1):
        tally.frames = number
        try:
            data = damaged(rng, case.good)
            tally.fed_bytes += len(data)
            feed(machine, rng, data)
            if rng.random() < 0.5:
                case.sign_of_good(machine)
            if number % RESYNC_EVERY == 0:
                _resync(case, machine, rng, tally, longest)
        except Violation:
            raise
        except Exception as error:
            raise Violation(number, f"raised {type(error).__name__}: {error}") from error
    return tally


def _resync(
    case: FuzzCase, machine: Machine, rng: random.Random, tally: Tally, longest: int
) -> None:
    case.sign_of_good(machine)
    passed, sent, heard = 0, 0, False
    while not heard:
        if passed >= longest or sent >= case.most_good:
            raise Violation(tally.frames, f"{sent} good frames were not heard after bad bytes")
        frame = case.good(rng)
        feed(machine, rng, frame)
        heard = case.sign_of_good(machine)
        sent += 1
        passed = passed + len(frame) if sent > 1 else 0
    tally.resyncs += 1
    tally.most_good_frames = max(tally.most_good_frames, sent)


def grown_bytes(case: FuzzCase, seed: int, frames: int) -> int:
    """Return how much more memory is in use after twice as many frames, all events fetched."""
    rng = random.Random(f"{case.name} {seed} growth")
    machine = case.make()
    case.good(rng)  # draws the frames now, since that takes memory

    def used_bytes() -> int:
        for _ in range(frames):
            feed(machine, rng, damaged(rng, case.good))
            case.sign_of_good(machine)
        return _held_bytes()

    gc.collect()
    gc.freeze()  # what other tests have left is not searched for garbage twice more
    tracemalloc.start(FRAMES_KEPT)
    try:
        before = used_bytes()
        grown = used_bytes() - before
    finally:
        tracemalloc.stop()
    if grown > MOST_GROWN_BYTES:
        raise Violation(2 * frames, f"{grown} bytes more in use than after half of the frames")
    return grown


def _held_bytes() -> int:
    """Return the memory that codecs have allocated and not freed, whatever other threads hold.

    What they keep for reuse is bounded, and does not count; nor do snapshots taken earlier.
    """
    for name, module in list(sys.modules.items()):  # the collector does not list frozen objects
        if name.startswith("firmware_protocol"):
            for each in vars(module).values():
                if isinstance(each, _Cache):
                    each.cache_clear()
    gc.collect()
    return sum(each.size for each in tracemalloc.take_snapshot().traces if _is_a_codecs(each))


def _is_a_codecs(trace: tracemalloc.Trace) -> bool:
    """Return whether a codec or its test has allocated something; faster than a `Filter`."""
    files = [frame.filename for frame in trace.traceback]
    return any("firmware_protocol" in file for file in files) and tracemalloc.__file__ not in files
