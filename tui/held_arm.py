"""An arm that another program holds, by its name: what watching asks of that program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

EVERY_S = 0.05


class HeldArm:
    """Speaks with the program that holds an arm."""

    def __init__(self, name: str) -> None:
        self._name = name

    def views(self) -> Iterator[Mapping[str, Any]]:
        """Yield its status whenever it has changed, or its program has come further."""
        from armdrive.storage.lock_client import follow_holder

        return follow_holder(self._name, EVERY_S)

    def ask(self, request: str, **words: object) -> Mapping[str, Any]:
        """Ask for something; raises `ArmError` where nobody answers."""
        from armdrive.storage.lock_client import ask_holder

        return ask_holder(self._name, request, **words)
