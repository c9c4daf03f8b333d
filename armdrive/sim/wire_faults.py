"""What may go wrong on a wire: bytes lost, changed, said twice, late; each direction by itself.

A message is what is put on the wire at once. Chance is drawn from a seeded generator, so that the
same faults come again in the same run.
"""

from __future__ import annotations

import heapq
import itertools
import math
import random
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass


class Amount(ABC):
    """How much of what passes is struck, and which bytes of it."""

    spent = False

    @abstractmethod
    def strike(self, length: int) -> tuple[int, ...]:
        """Return the indices of the bytes of the next message that are struck."""

    def strikes(self, length: int) -> bool:
        """Tell whether the next message is struck, for what befalls messages only as a whole."""
        return bool(self.strike(length))


class Share(Amount):
    """Each byte (or message) with a probability."""

    def __init__(self, share: float, draw: random.Random) -> None:
        self._share = share
        self._draw = draw

    def strike(self, length: int) -> tuple[int, ...]:
        """Draw for each byte."""
        return tuple(index for index in range(length) if self._draw.random() < self._share)

    def strikes(self, length: int) -> bool:  # noqa: ARG002 - one draw, however long it is
        """Draw once."""
        return self._draw.random() < self._share


class Nth(Amount):
    """One byte alone: the n-th from now, counted from 1."""

    def __init__(self, number: int) -> None:
        self._left = number

    def strike(self, length: int) -> tuple[int, ...]:
        """Count on."""
        self._left -= length
        if self.spent or self._left > 0:
            return ()
        self.spent = True
        return (self._left + length - 1,)


class Next(Amount):
    """The whole of the next message."""

    def strike(self, length: int) -> tuple[int, ...]:
        """Strike all of it, once."""
        if self.spent:
            return ()
        self.spent = True
        return tuple(range(length))


Effect = Callable[[bytes, Amount], tuple[bytes, float]]
"""Turns a message into what passes, and how many seconds late."""


@dataclass(slots=True, eq=False)
class Rule:
    """One fault on one lane, until its amount is spent."""

    effect: Effect
    amount: Amount


class Lane:
    """One direction of the wire, with its faults; what is late stays in its order."""

    def __init__(self) -> None:
        self.rules: list[Rule] = []
        self._late: list[tuple[float, int, bytes]] = []
        self._number = itertools.count()
        self._last_s = -math.inf

    @property
    def next_s(self) -> float:
        """When the next late message is due; infinity while there is none."""
        return self._late[0][0] if self._late else math.inf

    @property
    def clear(self) -> bool:
        """Whether all passes at once as it is."""
        return not (self.rules or self._late)

    def passed(self, data: bytes, now_s: float) -> list[bytes]:
        """Return what of a message passes at once; the rest is lost, or comes by `due`."""
        late_s = 0.0
        for rule in self.rules:
            data, more_s = rule.effect(data, rule.amount)
            late_s += more_s
        self.rules = [rule for rule in self.rules if not rule.amount.spent]
        if not late_s and not self._late:
            return [data] if data else []
        self._last_s = max(now_s + late_s, self._last_s)
        heapq.heappush(self._late, (self._last_s, next(self._number), data))
        return []

    def due(self, now_s: float) -> list[bytes]:
        """Take the late messages whose time has come."""
        taken = []
        while self._late and self._late[0][0] <= now_s:
            taken.append(heapq.heappop(self._late)[2])
        return taken

    def lose_late(self) -> None:
        """Lose what is late."""
        self._late.clear()


class WireFaults:
    """The two lanes: what the host says, and what the device says."""

    def __init__(self) -> None:
        self.host = Lane()
        self.device = Lane()

    @property
    def next_s(self) -> float:
        """When a late message is due on either lane."""
        return min(self.host.next_s, self.device.next_s)

    def lose_late(self) -> None:
        """Lose what is late in both directions."""
        self.host.lose_late()
        self.device.lose_late()


def lost(message: bytes, amount: Amount) -> tuple[bytes, float]:
    """Lose the bytes that are struck."""
    struck = amount.strike(len(message))
    return bytes(byte for index, byte in enumerate(message) if index not in struck), 0.0


def repeated(message: bytes, amount: Amount) -> tuple[bytes, float]:
    """Say the bytes that are struck twice; a whole message, one time after the other."""
    struck = amount.strike(len(message))
    if len(struck) == len(message):
        return message * 2, 0.0
    pieces = (bytes([byte]) * (1 + (index in struck)) for index, byte in enumerate(message))
    return b"".join(pieces), 0.0


def changed(draw: random.Random) -> Effect:
    """Flip a bit in each byte that is struck; in one byte of a message that is struck whole."""

    def effect(message: bytes, amount: Amount) -> tuple[bytes, float]:
        struck = amount.strike(len(message))
        if isinstance(amount, Next) and struck:
            struck = (draw.choice(struck),)
        garbled = bytearray(message)
        for index in struck:
            garbled[index] ^= 1 << draw.randrange(8)
        return bytes(garbled), 0.0

    return effect


def late(delay_s: float) -> Effect:
    """Delay messages; those behind a late one wait for it."""

    def effect(message: bytes, amount: Amount) -> tuple[bytes, float]:
        return message, delay_s if amount.strikes(len(message)) else 0.0

    return effect
