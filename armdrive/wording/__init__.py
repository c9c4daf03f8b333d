"""Messages of the wire in words for people: a table of sentences, plain words for the rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.wording import armdroid, canopen, grbl, mks, robko01, teachmover
from armdrive.wording.plain import plain

_SENTENCES: Mapping[type, Callable[[Any], str]] = MappingProxyType(
    {
        **teachmover.SENTENCES,
        **robko01.SENTENCES,
        **armdroid.SENTENCES,
        **grbl.SENTENCES,
        **mks.SENTENCES,
        **canopen.SENTENCES,
    }
)
"""Messages whose plain words would not say what they do."""


def wording(message: object) -> str:
    """Return one message of any dialect in words; text is returned as it is."""
    sentence = _SENTENCES.get(type(message))
    return plain(message) if sentence is None else sentence(message)
