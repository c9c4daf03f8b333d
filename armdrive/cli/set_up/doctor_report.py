"""What the doctor has to tell, printed as it is found or all at once as JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from armdrive.cli.presenter import emit, say
from armdrive.dialog.conversation import Finding


@dataclass(slots=True)
class Report:
    """What is found, printed as it comes, or all at once as JSON."""

    port: str
    json: bool
    findings: list[Finding] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)

    def add(self, found: list[Finding]) -> None:
        """Take findings."""
        self.findings += found
        for each in () if self.json else found:
            say(f"{each.grade.value:<8} {each.what}")
            if each.mend:
                say(f"{'':<8}   {each.mend}")

    def end(self, code: int) -> int:
        """Print what is left to be printed, and return the exit code."""
        if self.json:
            emit(
                {
                    "port": self.port,
                    **self.more,
                    "findings": [each.view() for each in self.findings],
                }
            )
            return code
        for title, key in (("Next:", "next"), ("Or as an arm file:", "arm_file")):
            if self.more.get(key):
                say(title)
                for line in self.more[key]:
                    say(f"  {line}".rstrip())
        return code
