"""The faults of the wire: bytes lost, changed, repeated, late, made up; the cable pulled."""

from __future__ import annotations

import random
from collections.abc import Callable

from armdrive.errors import BadRequest
from armdrive.sim.fault_kind import Begin, Bench, Prepare, Running
from armdrive.sim.fault_request import FaultRequest, number, whole
from armdrive.sim.wire_faults import Amount, Effect, Lane, Next, Nth, Rule, Share, late, lost

NOISE_BYTES = 8
NOISE_MOST = 4096


def on_wire(effect: Callable[[FaultRequest], Effect], first: int = 0, default: str = "") -> Prepare:
    """Return a row's `prepare` that puts an effect on the lanes of the sides that speak."""
    return ruling(lambda request, amount: Rule(effect(request), amount), first, default)


def ruling(
    make: Callable[[FaultRequest, Amount], Rule], first: int = 0, default: str = ""
) -> Prepare:
    """Return a row's `prepare` that puts a rule on the lanes of the sides that speak."""

    def prepare(bench: Bench, request: FaultRequest) -> Begin:
        words = request.words[first:] or ((default,) if default else ())
        rules = [
            (lane, make(request, _amount(words[0] if words else "", request, lane_number)))
            for lane_number, lane in enumerate(_lanes(bench, request.side))
        ]

        def begin() -> Running:
            for lane, rule in rules:
                lane.rules.append(rule)
            return Running(
                lambda: _withdraw(rules), lambda: any(rule in lane.rules for lane, rule in rules)
            )

        return begin

    return prepare


def _withdraw(rules: list[tuple[Lane, Rule]]) -> None:
    for lane, rule in rules:
        lane.rules = [one for one in lane.rules if one is not rule]


def _lanes(bench: Bench, side: str) -> list[Lane]:
    lanes = {"host": bench.line.faults.host, "device": bench.line.faults.device}
    return [lane for name, lane in lanes.items() if side in (name, "both")]


def _amount(word: str, request: FaultRequest, salt: int) -> Amount:
    if word == "next":
        return Next()
    if word.startswith("#"):
        count = whole(word[1:])
        if count < 1:
            raise BadRequest("bytes are counted from #1")
        return Nth(count)
    share = number(word)
    if not 0.0 <= share <= 1.0:
        raise BadRequest(f"a probability is from 0 to 1, not {word}; the n-th byte is #n")
    return Share(share, draw(request, salt))


def draw(request: FaultRequest, salt: int = 0) -> random.Random:
    """Return the generator of a fault's chances, the same for the same seed."""
    return random.Random(f"{request.name} {request.seed} {salt}")  # noqa: S311 - to be repeatable


def delaying(request: FaultRequest) -> Effect:
    """Return the effect of the delay that the first word gives."""
    seconds = number(request.words[0])
    if not 0.0 < seconds < float("inf"):
        raise BadRequest(f"a delay must be above 0 seconds, not {request.words[0]}")
    return late(seconds)


def mute(bench: Bench, _: FaultRequest) -> Begin:
    """Have the device say nothing."""
    return silencing(bench, "device")


def silencing(bench: Bench, side: str) -> Callable[[], Running]:
    """Return what has nothing pass that a side says, or both."""
    every = Share(1.1, random.Random(0))  # noqa: S311 - every byte, nothing is drawn
    rules = [(lane, Rule(lost, every)) for lane in _lanes(bench, side)]

    def begin() -> Running:
        for lane, rule in rules:
            lane.rules.append(rule)
        return Running(lambda: _withdraw(rules))

    return begin


def garbage(bench: Bench, request: FaultRequest) -> Begin:
    """Have noise come from the device's end of the wire."""
    count = whole(request.words[0]) if request.words else NOISE_BYTES
    if not 1 <= count <= NOISE_MOST:
        raise BadRequest(f"noise has 1 to {NOISE_MOST} bytes, not {count}")
    noise = draw(request).randbytes(count)
    return lambda: bench.line.say(noise, bench.device.now_s)


def unplug(bench: Bench, _: FaultRequest) -> Begin:
    """Pull the cable."""

    def begin() -> Running:
        bench.cable.unplug()
        return Running(bench.cable.replug)

    return begin


def replug(bench: Bench, request: FaultRequest) -> Begin:
    """Put the cable back, under another name perhaps."""
    words = [word for word in request.words if word != "as"]
    return lambda: bench.cable.replug(words[0] if words else None)
