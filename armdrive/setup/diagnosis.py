"""What an examination of a port has to tell: its findings as they come, and what all come to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from armdrive.dialog.conversation import Finding, any_problem


class Diagnosis(Enum):
    """What an examination came to."""

    FINE = auto()
    MENDING = auto()
    """Something has to be mended."""
    CLOSED = auto()
    """The port cannot be opened."""
    NOBODY = auto()
    """No arm was recognised."""


@dataclass(slots=True)
class Report:
    """What is found at a port: each finding is told as it comes, and all are kept."""

    port: str
    told: Callable[[Finding], None]
    arm: str = ""
    """The arm file that the person named, as a next command would name it."""
    findings: list[Finding] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)
    """What else there is to know, as plain data; `next` and `arm_file` are lines for people."""

    def add(self, found: Sequence[Finding]) -> None:
        """Take findings."""
        self.findings += found
        for each in found:
            self.told(each)

    @property
    def diagnosis(self) -> Diagnosis:
        """What the findings come to, where somebody answered."""
        return Diagnosis.MENDING if any_problem(self.findings) else Diagnosis.FINE

    def view(self) -> dict[str, Any]:
        """Return everything as plain data."""
        findings = [each.view() for each in self.findings]
        return {"port": self.port, **self.more, "findings": findings}
