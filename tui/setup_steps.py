"""The first stage of setting up: the steps, which of them can be taken here, and why not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.setup.filing import file_of
from tui.setup_motors import Motors
from tui.setup_new import Asking, Ports
from tui.setup_stage import Go, Stage, listed

if TYPE_CHECKING:
    from pathlib import Path

    from tui.desk import Desk

STEPS = (
    ("find", "find the arm", "its port or CAN interface; none is opened before you ask"),
    ("describe", "describe it", "questions that make its file; nothing is sent"),
    ("reference", "reference it", "tell armdrive where it stands, with the posture drawn"),
    ("motors", "check its motors", "each turns a little, by a key; you say what you saw"),
)
"""In the order in which a new arm is set up."""


class Steps(Stage):
    """The steps. Those that need another arm than the desk's say how to come to it."""

    def __init__(self, desk: Desk, go: Go, path: Path | None) -> None:
        super().__init__(desk, go)
        self.path = path
        self._motors: Motors | None = None
        self.marked = 0 if self.free else 2

    @property
    def free(self) -> bool:
        """Whether this desk has no arm of somebody's own: it is simulated, and has no file."""
        return self.desk.status.simulated and self.path is None

    def text(self) -> str:
        """List the steps, and whose arm they are for."""
        width = max(len(title) for _, title, _ in STEPS)
        rows = [f"{n} {title:<{width}}  {why}" for n, (_, title, why) in enumerate(STEPS, 1)]
        enter = self.desk.keys.label("setup-enter")
        return "\n".join(
            (
                self._whose(),
                "",
                *listed(rows, self.marked),
                "",
                f"{enter} begins the marked step; a stop leaves it.",
            )
        )

    def _whose(self) -> str:
        status = self.desk.status
        if self.path is not None:
            twin = ", its simulated twin" if status.simulated else ""
            return f"This desk has the arm {status.arm}{twin}: {self.path}"
        if self.free:
            return (
                "No arm of yours is on this desk: it is simulated. The first two steps make a file "
                "of yours; the others are tried on the simulated arm."
            )
        return f"This desk has an arm without a file, on {status.link}: describe it first."

    def rows(self) -> int:
        """Return the number of steps."""
        return len(STEPS)

    def enter(self) -> None:
        """Begin the marked step."""
        step = STEPS[self.marked][0]
        if step in ("find", "describe") and not self.free:
            self._other(step)
        elif step == "find":
            self.go(Ports(self.desk, self.go, self))
        elif step == "describe":
            self.go(Asking(self.desk, self.go, self, {}))
        elif step == "reference":
            self.desk.action_reference()
        elif self.path is not None and file_of(self.desk.arm.config) != self.path:
            raise BadRequest(f"{self.path} was changed: leave this desk and come back first")
        else:
            self.go(self._begun())

    def _begun(self) -> Motors:
        """Return the check that was left half-way, or a new one."""
        if self._motors is None or self._motors.check.trial is None:
            self._motors = Motors(self.desk, self.go, self)
        return self._motors

    def _other(self, step: str) -> None:
        """Describe the arm of a port that has no file; else say that this needs leaving."""
        wire = self.desk.arm.config.connection
        if step == "describe" and self.path is None:
            known = {"connection.port": wire.port, "dialect": wire.dialect,
                     "connection.baud": str(wire.baud)}  # fmt: skip
            self.go(Asking(self.desk, self.go, self, known))
            return
        leave = self.desk.keys.label("quit")
        raise BadRequest(
            f"this desk holds {self.desk.status.arm}: leave it ({leave}), then `armdrive jog "
            "--sim teachmover --setup` sets up another one"
        )
