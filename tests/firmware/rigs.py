"""The devices under test: how to make their benches, and those of the simulated board."""

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from armdrive.connect.target import find
from armdrive.sim.device import Value
from tests.conformance.bench import Bench
from tests.conformance.memory_bench import MemoryBench, Variant
from tests.conformance.real_time_bench import PortBench

from .avr_bench import ControlledBench, ImageRunner
from .boards import AvrBoard, Board, NativeBoard
from .control import ControlPort, Pace
from .native import NativeRunner

NOWHERE = "/dev/null"
"""A port that is never opened: it only gives the configuration of an arm without an arm file."""


class TwinBench(MemoryBench):
    """The simulated board in simulated time, sampled often enough to time its steps."""

    look_s: ClassVar[float] = 0.002

    def __init__(self, dialect: str, options: Mapping[str, Value]) -> None:
        super().__init__(dialect, Variant(dialect, dialect, board=options))
        # as for a real arm, whose bursts are shorter than those of `sim:`
        self._config = find(NOWHERE, dialect_name=dialect).config
        self.start_afresh()


@contextlib.contextmanager
def own_home() -> Iterator[None]:
    """Use an empty ARMDRIVE_HOME."""
    before = os.environ.get("ARMDRIVE_HOME")
    with tempfile.TemporaryDirectory(prefix="armdrive-") as home:
        os.environ["ARMDRIVE_HOME"] = home
        try:
            yield
        finally:
            if before is None:
                del os.environ["ARMDRIVE_HOME"]
            else:
                os.environ["ARMDRIVE_HOME"] = before


@dataclass(frozen=True, slots=True)
class Rig:
    """One device under test."""

    name: str
    dialect: str
    transport: str
    make: Callable[[], Bench]
    twin: Callable[[], Bench]
    close: Callable[[], None] = lambda: None
    pace: Pace = field(default_factory=Pace)

    def home(self) -> contextlib.AbstractContextManager[None]:
        """Isolate the records of one measurement from the next, unless the arm is real."""
        return contextlib.nullcontext() if self.real else own_home()

    @property
    def real(self) -> bool:
        """Whether it is a real arm, without a control port."""
        return self.transport == PortBench.transport


def simulated(dialect: str) -> Rig:
    """Return the simulated board itself as a rig."""
    twin = twin_maker(dialect, {})
    return Rig(f"simulated {dialect}", dialect, "memory", twin, twin)


def of_image(board: Board, image: Path, simavr: Path | None = None) -> Rig:
    """Return the rig of a firmware: an image in the processor simulator, or a native program."""
    runner: ImageRunner | NativeRunner
    if isinstance(board, NativeBoard):
        runner = NativeRunner(board, image)
    else:
        assert isinstance(board, AvrBoard)
        runner = ImageRunner(board, image, simavr)
    return Rig(
        board.name,
        board.dialect,
        "pty",
        runner.bench,
        twin_maker(board.dialect, board.twin),
        runner.close,
        runner.pace,
    )


def of_port(dialect: str, port: str, control: str, axes: str) -> Rig:
    """Return the rig of a device on a port: with a control port, or with a person next to it."""
    pace = Pace()

    def make() -> Bench:
        if control:
            return ControlledBench(dialect, port, ControlPort.at(control), axes, pace)
        return PortBench(dialect, port)

    transport = "pty" if control else "port"
    return Rig(port, dialect, transport, make, twin_maker(dialect, {}), pace=pace)


def twin_maker(dialect: str, options: Mapping[str, Value]) -> Callable[[], Bench]:
    """Return a maker of benches for the simulated board."""
    return lambda: TwinBench(dialect, options)
