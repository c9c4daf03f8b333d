"""Runs an example on a simulated arm, as `armdrive run` does, and watches the world of that arm."""

import contextlib
import io
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from armdrive import Arm
from armdrive.abilities import Abilities
from armdrive.arm import override_connections
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import simulated_config
from armdrive.programs.program import ENDING, ArmProgram, read_program
from armdrive.programs.rehearsal import SeenArm, rehearsing_arm
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.registry import DIALECTS
from armdrive.sim.world.table import block_of

from .watching import Watch

FOLDER = Path(__file__).parents[2] / "examples"
PUT = re.compile(r"--put (\S+)")


@dataclass(frozen=True, slots=True)
class Form:
    """A form of an example: what is written otherwise in it, and how much it does then."""

    size: Any
    changes: Mapping[str, str] = field(default_factory=dict)


@dataclass(slots=True)
class Ran:
    """What an example did: `said` to the person."""

    watch: Watch
    said: str
    names: Mapping[str, Any]


def anywhere(_: Abilities) -> str:
    """Give no reason against any arm."""
    return ""


@dataclass(frozen=True, slots=True)
class Example:
    """An example, where it can run, its forms, and what has to be there afterwards.

    `refused` gives the reason against an arm of such abilities, "" for none. `wrong` gives a
    sentence for everything that is physically not as it should be. `shorter` are forms for dialects
    that take long; None leaves one to the thorough run, where another example does much the same.
    """

    file: str
    whole: Form
    wrong: Callable[[Ran, Any], list[str]]
    refused: Callable[[Abilities], str] = anywhere
    shorter: Mapping[str, Form | None] = field(default_factory=dict)

    def form(self, dialect: str, *, whole: bool) -> Form | None:
        """Return the form that is run on a dialect, None where that is left for another time."""
        return self.whole if whole else self.shorter.get(dialect, self.whole)

    def against(self, dialect: str) -> str:
        """Return why the arm of a dialect cannot do it, "" where it can."""
        return self.refused(DIALECTS[dialect].abilities)


def run_example(example: Example, form: Form, config: ArmConfig | str) -> Ran:
    """Run an example in a form on a referenced simulated arm that stands on its mark."""
    text = (FOLDER / example.file).read_text(encoding="utf-8")
    for old, new in form.changes.items():
        assert text.count(old) == 1, f"{example.file} does not say once: {old}"
        text = text.replace(old, new)
    found = simulated_config(config) if isinstance(config, str) else config
    with contextlib.closing(rehearsing_arm(SeenArm(found), lambda _: None)) as arm:
        assert arm.twin is not None
        for words in PUT.findall(text):
            arm.twin.world.put(block_of(words.split(",")))
        watch = Watch(arm.twin.world)
        carry_out = _run_program if example.file.endswith(ENDING) else _run_script
        said, names = carry_out(text, example.file, arm)
        return Ran(watch, said, names)


class _Listener:
    """The person at the terminal of a program: lets everything go on."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def say(self, text: str) -> None:
        self.said.append(text)

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        self.said.append(text)


def _run_program(text: str, file: str, arm: Arm) -> tuple[str, Mapping[str, Any]]:
    person = _Listener()
    source = ArmProgram(read_program(text, file), arm.config)
    ProgramRun(RunPlan(source.machine), Performer(arm, person)).carry_out()
    return "\n".join(person.said), {}


def _run_script(text: str, file: str, arm: Arm) -> tuple[str, Mapping[str, Any]]:
    names: dict[str, Any] = {"__name__": "__main__"}
    said = io.StringIO()
    alone = mock.patch.object(sys, "argv", [file])
    with alone, override_connections(lambda *_: arm), contextlib.redirect_stdout(said):
        exec(compile(text, file, "exec"), names)
    return said.getvalue(), names
