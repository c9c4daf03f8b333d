"""A simulated arm, a mortal program in a process of its own, and what a third then believes.

Used by a test for a handful of kills, and by benchmarks/kill_everywhere.py for a hundred.
"""

import json
import signal
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from forking import host
from served import Served

from armdrive import Arm
from armdrive.status import Trust
from kinematics import Motors


@dataclass(frozen=True, slots=True)
class Found:
    """What the next program believed of an arm after a kill, and where it physically stood."""

    order: dict[str, Any]
    killed: bool
    trust: Trust
    reason: str
    believed: Motors
    truth: Motors

    @property
    def wrong(self) -> bool:
        """Whether something was believed that is not so."""
        if self.trust is Trust.RESTORED:
            return self.believed != self.truth
        return self.trust is Trust.REFERENCED

    def __str__(self) -> str:
        return f"{self.order}: {self.trust.value}, {self.reason}; {self.believed} is {self.truth}"


class KillingGround:
    """One simulated arm on a pty; needs ARMDRIVE_HOME in the environment."""

    def __init__(self, folder: Path, dialect: str = "teachmover") -> None:
        self._dialect = dialect
        self._sim = Served(dialect, pty=folder / "arm")
        self._host = host("mortal_host.py", self._sim.port, dialect)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._host.communicate()
        self._sim.end()

    def kill(self, **order: Any) -> Found:
        """Have a program live until it is killed, and another one connect."""
        assert self._host.stdin is not None
        assert self._host.stdout is not None
        motors = list(self._motors())
        self._host.stdin.write(json.dumps({"motors": motors, **order}) + "\n")
        ended = json.loads(self._host.stdout.readline())["ended"]
        killed = ended == -signal.SIGKILL
        if ended and not killed:
            raise RuntimeError(f"the program failed before it was killed: {order}")
        self._sim.watch.rest()
        with Arm.connect(self._sim.port, dialect=self._dialect) as arm:
            status = arm.status
            truth = self._motors()
        return Found(order, killed, status.trust, status.trust_reason, status.acknowledged, truth)

    def _motors(self) -> Motors:
        return Motors(self._sim.watch.motors)
