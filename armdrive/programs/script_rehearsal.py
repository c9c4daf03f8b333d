"""Rehearses a Python script: it runs with the simulated twins of its arms.

Only its calls of arms are rehearsed. Everything else that it does really happens.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from armdrive.arm import Arm
from armdrive.connect.parts import ConnectOptions, connect_simulated
from armdrive.connect.target import SIM, find
from armdrive.errors import ArmInUse, BadRequest
from armdrive.programs.problems import SourceMark
from armdrive.programs.progress import Took
from armdrive.programs.rehearsal import (
    DEFAULT_OPTIONS,
    WORDS,
    Assumptions,
    Patience,
    Rehearsal,
    RehearsalOptions,
    SeenArm,
    Things,
    TooLong,
    rehearsing_arm,
    trace,
)
from armdrive.programs.scripts import Connections, ScriptCall, carry_out, place_of, simulation_only
from armdrive.runtime.clock import PaceChoice
from kinematics.geometry import Point


class _Stage:
    """Gives a script its twins, and records what it does with them."""

    def __init__(
        self, seen: SeenArm, options: RehearsalOptions, script: Path, patience: Patience
    ) -> None:
        self.assumptions = Assumptions()
        self.path: list[Point] = []
        self.calls: list[tuple[SourceMark, str, float]] = []
        self.twins: list[Arm] = []
        self._seen = seen
        self._options = options
        self._script = str(script)
        self._patience = patience
        self._things: dict[int, Things] = {}
        self._last: dict[str, Arm] = {}

    def own(self, options: ConnectOptions) -> Arm:
        """Return the twin of the arm that the command names."""
        return self._twin_of(self._seen, options)

    def given(self, target: str, options: ConnectOptions) -> Arm:
        """Return the twin of an arm that the script names; a simulated arm is its own twin."""
        found = find(target, dialect_name=options.dialect, baud=options.baud)
        config = found.config
        own_world = target.startswith(SIM) or options.twin is not None
        if not own_world:
            same = _plain(config.name) == _plain(self._seen.config.name)
            seen = replace(self._seen, config=config) if same else SeenArm.unasked(found)
            return self._twin_of(seen, options)
        made = Arm(
            connect_simulated(
                config,
                twin=options.twin,
                pace=_clock(options),
                operator=options.operator,
            )
        )
        self._things[id(made)] = self._found(known=True)
        return made

    def made(self, arm: Arm) -> None:
        """Give a twin its inputs."""
        self.twins.append(arm)
        if self._options.traced:
            trace(arm, self.path)
        for number, on in self._options.inputs.items():
            if arm.twin is not None:
                arm.twin.device.set_input(number - 1, on)

    def called(self, arm: Arm, call: ScriptCall) -> None:
        """Record a call of the script."""
        mark = self.assumptions.mark = SourceMark(call.line, 1, self._script)
        self._patience.before_act(mark, self.elapsed_s)
        self.calls.append((mark, call.name, self.elapsed_s))
        if call.grasps:
            self._things[id(arm)].before_grasp(arm)
        elif call.name == "io.read":
            on = [str(number) for number, high in self._options.inputs.items() if high]
            self.assumptions.note(f"inputs are {WORDS[False]}, but for {', '.join(on) or 'none'}")

    @property
    def elapsed_s(self) -> float:
        """The simulated time of all clocks together."""
        paces = [arm.parts.pace for arm in self.twins]
        clocks = {id(getattr(pace, "clock", pace)): pace.now_s() for pace in paces}
        return sum(clocks.values())

    def took(self) -> tuple[Took, ...]:
        """Return how long every call took, up to the next one."""
        ends = [*(at_s for _, _, at_s in self.calls), self.elapsed_s][1:]
        return tuple(
            Took(mark, name, max(end_s - at_s, 0.0))
            for (mark, name, at_s), end_s in zip(self.calls, ends, strict=True)
        )

    def _twin_of(self, seen: SeenArm, options: ConnectOptions) -> Arm:
        """Return a twin of an arm, standing where the script's last connection left it.

        Raises `ArmInUse` while that connection is open, as the arm itself does.
        """
        name = _plain(seen.config.name)
        last = self._last.get(name)
        if last is not None:
            if not last.closed:
                raise ArmInUse(f"{name} is held by this script: close that connection first")
            left = SeenArm.of(last)
            world = None if seen.world is None else left.world
            seen = replace(seen, position=left.position, last_seen=left.last_seen, world=world)
        settle = self.assumptions.note if self._options.settle else None
        made = self._last[name] = rehearsing_arm(seen, settle, _clock(options))
        self._things[id(made)] = self._found(known=seen.world is not None)
        return made

    def _found(self, *, known: bool) -> Things:
        return Things(self.assumptions, self._options.width_mm, known=known)


def rehearse_script(
    script: Path,
    words: Sequence[str],
    seen: SeenArm,
    patience: Patience,
    options: RehearsalOptions = DEFAULT_OPTIONS,
) -> Rehearsal:
    """Rehearse a script; an error that it raises is the refusal of the answer.

    `seen` is the arm that `Arm.connect()` without a target means.
    """
    stage = _Stage(seen, options, script, patience)
    connections = Connections(script, stage)
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
    return Rehearsal(
        (stage.took(),),
        tuple(stage.assumptions.found),
        refusal,
        None if refusal is None else place_of(refusal, script),
        whole,
        path=tuple(stage.path),
    )


def _plain(name: str) -> str:
    """Return the name of an arm without the prefix of a simulated one."""
    return name.removeprefix(SIM)


def _clock(options: ConnectOptions) -> PaceChoice:
    """Return the simulated clock that the arms of a script share."""
    real = isinstance(options.pace, str | int | float)
    return options.clock if real else options.simulated_pace
