"""Python scripts as programs: run as `python SCRIPT` runs them, on the arms that the run gives.

`Arm.connect()` without a target takes the arm that the run names; an arm that the script names
itself stays. In a rehearsal each is its simulated twin, whatever it says, and no port is opened.
"""

from __future__ import annotations

import ast
import contextlib
import math
import os
import runpy
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, cast

from armdrive.arm import Arm, standing_in
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import ConnectOptions, connect, connect_simulated
from armdrive.connect.target import SIM, find
from armdrive.errors import BadRequest
from armdrive.errors.printable import printable_lines
from armdrive.programs.problems import SourceMark
from armdrive.programs.rehearsal import (
    WORDS,
    Assumptions,
    Patience,
    Rehearsal,
    RehearsedPlan,
    Things,
    TooLong,
    knows_its_world,
    rehearsing_arm,
)
from armdrive.programs.running import Took
from armdrive.runtime.drive import PaceChoice
from armdrive.sim.world.scene import GripScene
from armdrive.sim.world.table import Incident
from armdrive.text.reading import read_bytes
from armdrive.trace import calls as recorded
from armdrive.trace.calls import Tracer
from kinematics.geometry import Point

# The calls that a script makes of its arms, and the line of the script that made each.
#
# They are heard where the flight recorder hears them. A call that another call makes, as `park`
# makes
# `move_to`, is not the script's own.

DEEPEST = 1000
"""So many frames are looked through for a line of the script."""


@dataclass(frozen=True, slots=True)
class ScriptCall:
    """A call of a script. `line` is 0 where another file or another thread made it."""

    arm: str
    name: str
    line: int
    at_s: float


Told = Callable[["Arm", ScriptCall], object]


class CallTracer:
    """Tells of an arm's calls on their way to the tracer that it had before."""

    def __init__(self, arm: Arm, script: str, told: Told) -> None:
        self._arm = arm
        self._script = script
        self._told = told
        self._inner = arm.tracer

    def called(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Hear of a call, and tell of it if it is the script's own."""
        line = script_line(sys._getframe(1), self._script)  # noqa: SLF001 - the noted call's own
        if line is not None:
            now_s = self._arm.pace.now_s()
            self._told(self._arm, ScriptCall(self._arm.config.name, name, line, now_s))
        self._inner.called(name, words, named)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


def watch_calls(arm: Arm, script: str, told: Told) -> None:
    """Have the calls of an arm told that a script makes; `told` may raise to refuse one."""
    arm.tracer = cast("Tracer", CallTracer(arm, script, told))


def script_line(frame: FrameType | None, script: str) -> int | None:
    """Return the line of the script from which a call comes, 0 where none is on its way.

    None of a call within another one. `frame` is the noted call's own.
    """
    line = 0
    frame = None if frame is None else frame.f_back
    for _ in range(DEEPEST):
        if frame is None:
            break
        if frame.f_code.co_filename == recorded.__file__:
            return None
        if not line and frame.f_code.co_filename == script:
            line = frame.f_lineno
        frame = frame.f_back
    return line


LARGEST_SCRIPT = 4_000_000
"""Bytes. A script may hold a table of its own."""

FORCE_SIM = "ARMDRIVE_FORCE_SIM"

Own = Callable[[ConnectOptions], "Arm"]
"""Connects to the arm that the run names, with the options of the script's own call."""


class Connections:
    """Every arm that a script connects to while it runs; `own` is the run's arm."""

    def __init__(
        self,
        script: Path,
        own: Own,
        told: Callable[[Arm, ScriptCall], object],
        made: Callable[[Arm], object],
        given: Callable[[str, ConnectOptions], Arm],
    ) -> None:
        """`given` connects to an arm that the script names; `made` hears of each that is there."""
        self.arms: list[Arm] = []
        self._script = str(script)
        self._own = own
        self._told = told
        self._made = made
        self._given = given

    def __call__(self, target: str | None, options: ConnectOptions) -> Arm:
        """Connect as `armdrive.arm.Standin` says."""
        arm = self._own(options) if target is None else self._given(target, options)
        self.arms.append(arm)
        self._made(arm)
        watch_calls(arm, self._script, self._told)
        return arm

    def close(self) -> None:
        """Stop and give back what the script has left open."""
        with contextlib.ExitStack() as stack:  # each is closed, whatever another one says
            for arm in self.arms:
                if not arm.closed:
                    stack.callback(arm.close)


def as_it_says(target: str, options: ConnectOptions) -> Arm:
    """Connect to an arm that a script names, outside of any standing in."""
    return Arm(connect(target, options))


def read_script(path: Path) -> bytes:
    """Return a script's bytes, read once to see that it is Python. Raises `BadRequest`."""
    source = read_bytes(path, "the script", BadRequest, most_bytes=LARGEST_SCRIPT)
    try:
        ast.parse(source, str(path))
    except (RecursionError, MemoryError):  # MemoryError: how Python's parser says the same
        raise BadRequest(f"{path} is nested too deeply") from None
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        where = f"{path}: line {line}" if line else str(path)
        raise BadRequest(f"{where}: {getattr(error, 'msg', error)}") from None
    return source


def carry_out(path: Path, words: Sequence[str], connections: Connections) -> int:
    """Run a script to its end, with `words` as its arguments; return its exit code.

    Raises what the script raises, but for `SystemExit`; whatever it leaves open is closed.
    """
    with _as_main(path, words), standing_in(connections):
        try:
            runpy.run_path(str(path), run_name="__main__")
        except SystemExit as end:
            return _exit_code(end.code)
        finally:
            connections.close()
    return 0


@contextlib.contextmanager
def simulation_only() -> Iterator[None]:
    """Have every connection simulated meanwhile, those of other programs that it starts as well.

    A second wall behind the standing in: no port opens.
    """
    before = os.environ.get(FORCE_SIM)
    os.environ[FORCE_SIM] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[FORCE_SIM]
        else:
            os.environ[FORCE_SIM] = before


def line_of(error: BaseException, script: Path) -> int | None:
    """Return the script's line in which an error came up, None of one that came from elsewhere."""
    lines = [
        number
        for frame, number in traceback.walk_tb(error.__traceback__)
        if frame.f_code.co_filename == str(script)
    ]
    return lines[-1] if lines else None


def own_traceback(error: BaseException, script: Path) -> str:
    """Return the traceback of a script's own error, from the script's first line on."""
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename != str(script):
        trace = trace.tb_next
    return "".join(traceback.format_exception(type(error), error, trace or error.__traceback__))


@contextlib.contextmanager
def _as_main(path: Path, words: Sequence[str]) -> Iterator[None]:
    """Give the script its arguments, and its own folder to import from."""
    arguments, folders = sys.argv, list(sys.path)
    sys.argv = [str(path), *words]
    sys.path.insert(0, str(path.resolve().parent))
    try:
        yield
    finally:
        sys.argv = arguments
        sys.path[:] = folders


def _exit_code(code: object) -> int:
    if code is None or isinstance(code, int):
        return code or 0
    sys.stderr.write(f"{printable_lines(str(code))}\n")
    return 1


# Keeps the way of a simulated arm's tip, for the picture of a rehearsed script.
#
# It is the physical way, whichever call makes the arm move: lines, arcs, routes and jogs alike.

NEAREST_MM = 1.0
"""Points of the path are no nearer to one another."""


class TracedScene:
    """The scene of an arm's world, which is told every motion of the tip; all else is its own."""

    def __init__(self, arm: Arm, scene: GripScene, path: list[Point]) -> None:
        self._arm = arm
        self._scene = scene
        self._path = path

    def follow(
        self, before: Point, after: Point, opening_mm: float, time_s: float
    ) -> list[Incident]:
        """Keep where the tip goes, once the arm knows where it stands."""
        if self._arm.core.position_known:
            for point in (before, after):
                if not self._path or math.dist(self._path[-1], point) >= NEAREST_MM:
                    self._path.append(point)
        return self._scene.follow(before, after, opening_mm, time_s)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)


def trace(arm: Arm, path: list[Point]) -> None:
    """Have a twin's tip leave its points in a path, in mm in the arm's base frame."""
    if arm.twin is not None:
        world = arm.twin.world
        world.scene = cast("GripScene", TracedScene(arm, world.scene, path))


# A Python script rehearsed: it runs, and each of its arms is the simulated twin of that arm.
#
# Only what it does to arms is rehearsed. Whatever else it does, it does.

GRASPS = ("grasp", "feel")


class _Stage:
    """Gives a script its twins, and notes what it does with them."""

    def __init__(
        self, config: ArmConfig, arm: Arm | None, plan: RehearsedPlan, script: Path
    ) -> None:
        self.assumptions = Assumptions()
        self.path: list[Point] = []
        self.calls: list[tuple[SourceMark, str, float]] = []
        self.twins: list[Arm] = []
        self._config = config
        self._arm = arm
        self._plan = plan
        self._script = str(script)
        self._patience = Patience()
        self._things: dict[int, Things] = {}

    def own(self, options: ConnectOptions) -> Arm:
        """Return the twin of the arm that the run names."""
        return self._twin_of(self._config, self._arm, options)

    def given(self, target: str, options: ConnectOptions) -> Arm:
        """Return the twin of an arm that the script names; a simulated one it is itself."""
        config = find(target, dialect_name=options.dialect, baud=options.baud).config
        own_world = target.startswith(SIM) or options.twin is not None
        if not own_world:
            same = _plain(config.name) == _plain(self._config.name)
            return self._twin_of(config, self._arm if same else None, options)
        made = Arm(
            connect_simulated(
                config,
                twin=options.twin,
                pace=_clock(options),
                operator=options.operator,
            )
        )
        self._things[id(made)] = self._known(True)
        return made

    def made(self, arm: Arm) -> None:
        """Give a twin its inputs."""
        self.twins.append(arm)
        if self._plan.traced:
            trace(arm, self.path)
        for number, on in self._plan.inputs.items():
            if arm.twin is not None:
                arm.twin.device.set_input(number - 1, on)

    def told(self, arm: Arm, call: ScriptCall) -> None:
        """Note a call of the script."""
        self._patience.ask(self.elapsed_s)
        mark = self.assumptions.mark = SourceMark(call.line, 1, self._script)
        self.calls.append((mark, call.name, self.elapsed_s))
        if call.name in GRASPS:
            self._things[id(arm)].before_grasp(arm)
        elif call.name == "read_inputs":
            on = [str(number) for number, high in self._plan.inputs.items() if high]
            self.assumptions.note(f"inputs are {WORDS[False]}, but for {', '.join(on) or 'none'}")

    @property
    def elapsed_s(self) -> float:
        """The time of all arms that have a clock of their own."""
        clocks = {id(getattr(arm.pace, "clock", arm.pace)): arm.pace.now_s() for arm in self.twins}
        return sum(clocks.values())

    def took(self) -> tuple[Took, ...]:
        """Return what every call took, up to the next one."""
        ends = [*(at_s for _, _, at_s in self.calls), self.elapsed_s][1:]
        return tuple(
            Took(mark, name, max(end_s - at_s, 0.0))
            for (mark, name, at_s), end_s in zip(self.calls, ends, strict=True)
        )

    def _twin_of(self, config: ArmConfig, arm: Arm | None, options: ConnectOptions) -> Arm:
        settle = self.assumptions.note if self._plan.settle else None
        made = rehearsing_arm(config, arm, settle, _clock(options))
        self._things[id(made)] = self._known(knows_its_world(arm))
        return made

    def _known(self, known: bool) -> Things:
        return Things(self.assumptions, self._plan.width_mm, known=known)


def rehearse_script(
    script: Path, words: Sequence[str], config: ArmConfig, arm: Arm | None, plan: RehearsedPlan
) -> Rehearsal:
    """Rehearse a script. What it raises, other than to end, is the refusal of the answer.

    `config` is the arm that `Arm.connect()` without a target means, `arm` that arm where it could
    be asked where it stands.
    """
    stage = _Stage(config, arm, plan, script)
    connections = Connections(script, stage.own, stage.told, stage.made, stage.given)
    refusal: Exception | None = None
    whole = True
    try:
        with simulation_only():
            code = carry_out(script, words, connections)
        if code:
            refusal = BadRequest(f"{script} ended with {code}")
    except TooLong:
        whole = False
    except Exception as error:
        refusal = error
    line = None if refusal is None else line_of(refusal, script)
    return Rehearsal(
        (stage.took(),),
        tuple(stage.assumptions.found),
        refusal,
        None if line is None else SourceMark(line, 1, str(script)),
        whole,
        path=tuple(stage.path),
    )


def _plain(name: str) -> str:
    """Return the name of an arm without what a simulated one's has before it."""
    return name.removeprefix(SIM)


def _clock(options: ConnectOptions) -> PaceChoice:
    """Return the clock that several simulated arms of a script share; no real time passes."""
    return None if isinstance(options.pace, str | int | float) else options.pace
