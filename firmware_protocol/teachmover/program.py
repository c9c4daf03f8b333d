"""One row of the program in a TeachMover's memory, and its packing into eight words.

The packing is that of the public programs which write such rows: with the six positions as
16-bit two's complement, L and H their low and high bytes, the words are: the step number;
(255 - speed) * 256 + 1; L2 L1; L4 L3; L6 L5; H2 H1; H4 H3; H6 H5, each pair high byte first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firmware_protocol.errors import BadField, RemoteProtocolError, whole

MOTORS = 6
ROW_WORDS = 8
SPEED_MAX = 245
"""The fastest speed a motion may name; 0 is the slowest."""
MOVE_KIND = 1
STEPS_MIN, STEPS_MAX = -(1 << 15), (1 << 15) - 1
WORD_MAX = (1 << 16) - 1
_BYTE_MAX = 255


def six_steps(field: str, steps: object) -> tuple[int, ...]:
    """Return six counts of half-steps in signed 16 bit, or raise `BadField` naming the one."""
    if not isinstance(steps, tuple | list) or len(steps) != MOTORS:
        raise BadField(field, steps, f"{MOTORS} counts of half-steps, one a motor")
    return tuple(
        whole(f"{field}[{index}]", count, STEPS_MIN, STEPS_MAX) for index, count in enumerate(steps)
    )


@dataclass(frozen=True, slots=True)
class ProgramRow:
    """One row of the arm's own program: absolute positions, in half-steps, and how to get there.

    `kind` is the low byte of the second word: 1 in every row that public programs write, which
    is a move. What other kinds mean is unverified; they are kept as they are, as are speeds over
    245, so that whatever a dump holds can be written back word for word. To make a row of one's
    own use `move`, which admits only the speeds of a motion. Raises `BadField`.
    """

    number: int
    speed: int
    positions: tuple[int, ...]
    kind: int = MOVE_KIND

    def __post_init__(self) -> None:
        whole("number", self.number, 0, WORD_MAX)
        whole("speed", self.speed, 0, _BYTE_MAX)
        object.__setattr__(self, "positions", six_steps("positions", self.positions))
        whole("kind", self.kind, 0, _BYTE_MAX)

    @classmethod
    def move(cls, number: int, speed: int, positions: tuple[int, ...]) -> ProgramRow:
        """Make a row that moves to absolute positions in half-steps, at a speed of 0 to 245."""
        return cls(number, whole("speed", speed, 0, SPEED_MAX), positions)

    @classmethod
    def from_words(cls, words: Sequence[int]) -> ProgramRow:
        """Read a row from its eight words; raises `RemoteProtocolError`.

        A word may come as unsigned or as signed 16 bit: which of them the arm prints in a dump
        is unverified, and both name the same two bytes.
        """
        if len(words) != ROW_WORDS:
            raise RemoteProtocolError(f"a program row has {ROW_WORDS} words, not {len(words)}")
        for word in words:
            if not STEPS_MIN <= word <= WORD_MAX:
                raise RemoteProtocolError(f"{word} is no 16-bit word of a program row")
        number, second, *packed = (word & WORD_MAX for word in words)
        pairs = [(word & 0xFF, word >> 8) for word in packed]
        low = [byte for pair in pairs[:3] for byte in pair]
        high = [byte for pair in pairs[3:] for byte in pair]
        positions = tuple(_signed(h << 8 | b) for b, h in zip(low, high, strict=True))
        return cls(number, _BYTE_MAX - (second >> 8), positions, second & 0xFF)

    @property
    def words(self) -> tuple[int, ...]:
        """The eight words of this row, unsigned 16 bit."""
        raw = [position & WORD_MAX for position in self.positions]
        pairs = list(zip(raw[::2], raw[1::2], strict=True))
        return (
            self.number,
            (_BYTE_MAX - self.speed) << 8 | self.kind,
            *((second & 0xFF) << 8 | first & 0xFF for first, second in pairs),
            *((second >> 8) << 8 | first >> 8 for first, second in pairs),
        )


def _signed(word: int) -> int:
    """Read an unsigned 16-bit word as two's complement."""
    return word - (1 << 16) if word > STEPS_MAX else word
