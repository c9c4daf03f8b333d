"""Messages of the wire in words for people: a table of sentences, plain words for the rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.dialects.armdroid import words as armdroid
from armdrive.dialects.cia402 import words as canopen
from armdrive.dialects.grbl import words as grbl
from armdrive.dialects.mks import words as mks
from armdrive.dialects.robko01 import words as robko01
from armdrive.dialects.teachmover import words as teachmover
from armdrive.dialects.words import plain

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
