"""The table of what drives on a CAN bus speak: who hears it, and which dialects speak it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.commissioning.frame_words import Ear
from armdrive.commissioning.frame_words_canopen import CanopenEar
from armdrive.commissioning.frame_words_mks import MksEar
from firmware_protocol.frames import Frame


@dataclass(frozen=True, slots=True)
class Language:
    """One row. `silence` says what it means that nothing passes."""

    name: str
    title: str
    dialect: str
    ear: Callable[[], Ear]
    silence: str


LANGUAGES: Mapping[str, Language] = MappingProxyType(
    {
        each.name: each
        for each in (
            Language(
                "mks",
                "MKS drives",
                "mks",
                MksEar,
                "An idle bus of drives is silent: they speak when they are asked",
            ),
            Language(
                "canopen",
                "CANopen",
                "cia402",
                CanopenEar,
                "An idle bus is silent where no drive was told to say heartbeats (object 1017)",
            ),
        )
    }
)
"""Every language by its name."""
USUAL = LANGUAGES["mks"]
"""Taken where nobody says otherwise."""


def language_of(dialect: str) -> Language:
    """Return the language of a dialect that is spoken on a bus, the usual one of any other."""
    return next((each for each in LANGUAGES.values() if each.dialect == dialect), USUAL)


def likely(frames: Iterable[Frame]) -> Language:
    """Return the language in which the most of some frames can be read."""
    heard = tuple(frames)

    def foreign(language: Language) -> int:
        ear = language.ear()
        return sum(ear.hear(frame).foreign for frame in heard)

    return min(LANGUAGES.values(), key=foreign)
