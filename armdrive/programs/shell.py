"""The shell: carries out on an arm what is typed at a prompt, and answers its own words.

Each of its own words is a row of the table at the end, from which help, completion and docs are
made. A row's function yields replies.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.errors import BadRequest, OperatorNeeded
from armdrive.errors.printable import command_line
from armdrive.programs.acts import RunStep
from armdrive.programs.language.values import PlaceValue, value_text
from armdrive.programs.language.words import (
    FORMS,
    FUNCTIONS,
    RESERVED,
    SPELLINGS,
    meanings,
    overview,
)
from armdrive.programs.program import (
    ArmProgram,
    Machine,
    Program,
    program_path,
    read_program,
)
from armdrive.programs.running import (
    AfterAct,
    BeforeAct,
    Performer,
    ProgramRun,
    RunPerson,
    RunPlan,
)
from armdrive.programs.session import Session
from armdrive.registry import dialect
from armdrive.sim.world import World
from armdrive.sim.world.table import PARTS, block_of
from armdrive.status import outcome_words
from armdrive.storage.files import require_free, write_named
from kinematics.errors import suggestion
from kinematics.text import counted


class Left(Exception):
    """The person is done."""


# What one of the shell's own words has to say.
Answers: TypeAlias = Iterator[str]

# A word and the text after it; `list = 3` assigns a value instead.
_LINE = re.compile(r"\s*([a-z]+)(?:\s+([^\s=(].*?))?\s*", re.IGNORECASE)

# The name of a pipe in places.
INPUT = "standard input"

# The word after the name of a file that may be overwritten.
OVER = "over"


class Shell:
    """A prompt's session on one arm; `typing` says that a person types, not a pipe.

    `agreed` asks that person a question. `at` is the step at which the last entry was interrupted,
    if it was.
    """

    def __init__(self, arm: Arm, agreed: Callable[[str], bool], *, typing: bool) -> None:
        self.arm = arm
        self.agreed = agreed
        self.typing = typing
        self.done = 0
        self.at: RunStep | None = None
        self._stops = arm.stops
        self._outputs = 0
        self.start_over()

    def start_over(self) -> None:
        """Forget everything typed. The arm stays as it is."""
        self.session = Session("" if self.typing else INPUT)

    def own_word(self, line: str) -> Answers | None:
        """Return what one of the shell's own words has to say; None for any other line.

        What there is to say is found, or done, as it is taken. Raises `Left` for `quit`.
        """
        match = None if self.session.unfinished else _LINE.fullmatch(line)
        row = None if match is None else OWN_WORDS.get(match[1].lower())
        return None if match is None or row is None else row.answer(self, match[2] or "")

    def machine(self, entry: Program) -> Machine:
        """Return the machine of an entry, with the arm's present points."""
        return ArmProgram(entry, self.arm.config).machine()

    def carry_out(
        self,
        entry: Program,
        machine: Machine,
        person: RunPerson,
        *,
        before: Sequence[BeforeAct] = (),
        after: Sequence[AfterAct] = (),
    ) -> None:
        """Carry out an entry, and learn the names that it sets, even if it is interrupted."""
        self.at = None
        self._forget_stops()
        performer = Performer(self.arm, person, since=self._stops, outputs=self._outputs)
        plan = RunPlan(lambda: machine, goes_on=True)
        run = ProgramRun(plan, performer, before=before, after=after)
        done = False
        try:
            run.carry_out()
            done = True
        finally:
            self.at = run.at
            self.session.learn(entry, machine, done=done)
            self.arm.program = None
        self._outputs = performer.outputs
        self.done += 1

    def _forget_stops(self) -> None:
        """Ignore a stop between two typed entries; it does end the input of a pipe."""
        if self.typing and self.arm.stops != self._stops:
            # otherwise a stop that the engine has not seen yet would end the next motion
            run_blocking(self.arm.parts.runner.stand_still())
            self._stops = self.arm.stops

    def save(self, path: Path, *, over: bool) -> int:
        """Save the entries carried out as a program; return how many lines. Raises `BadRequest`.

        Another file is replaced only with `over`.
        """
        text = self.session.text
        if not text.strip():
            raise BadRequest("there is nothing to save: no line has run yet")
        require_free(path, overwrite=over, how=f"type `save {path} {OVER}`")
        program = read_program(text, str(path))
        ArmProgram(program, self.arm.config).machine()  # what is written can be run here
        write_named(path, text.encode("utf-8"))
        return len(text.splitlines())


# The shell's own words, besides those of the language.


def _help(shell: Shell, rest: str) -> Answers:
    yield from help_on(rest, shell)


def _list(shell: Shell, _: str) -> Answers:
    yield shell.session.text.rstrip("\n") or "nothing has been carried out yet"


def _save(shell: Shell, rest: str) -> Answers:
    name, _, over = rest.rpartition(" ")
    named, force = (name, True) if over.lower() == OVER and name else (rest, False)
    path = program_path(named, "save stack.arm")
    count = counted(shell.save(path, over=force), "line is", "lines are")
    check = command_line("run", path, "--check")
    yield f"{count} in {path}: rehearse the program with `{check}`"


def _new(shell: Shell, _: str) -> Answers:
    shell.start_over()
    yield "names, subprograms and the list are forgotten; the arm stays"


def _names(shell: Shell, _: str) -> Answers:
    context = shell.session.context
    for name, value in context.variables.items():
        sign = ":" if isinstance(value, PlaceValue) else " ="
        yield f"  {name}{sign} {value_text(value)}"
    for define in context.defines:
        yield f"  {define.name}({', '.join(define.parameters)})"
    for name, point in shell.arm.points.items():
        yield f"  {name}: {PlaceValue(joints_deg=dict(point.joints.deg))}, saved"
    yield f"  speed {value_text(context.speed * 100.0)}%"


def _status(shell: Shell, _: str) -> Answers:
    yield str(shell.arm.status)


def _done(act: Callable[[Arm], object]) -> Callable[[Shell, str], Answers]:
    """Return the function of a word that calls the arm, and says its state then."""

    def answer(shell: Shell, _: str) -> Answers:
        act(shell.arm)
        yield outcome_words(shell.arm.status)

    return answer


def _disable(shell: Shell, rest: str) -> Answers:
    yield dialect(shell.arm.status.dialect).torque.disable_warning
    question = "Park it first with `ready`, or support it. Switch the motors off now? Type yes: "
    if rest.lower() != "yes" and not (shell.typing and shell.agreed(question)):
        raise OperatorNeeded("the motors were left as they are: `disable yes` switches them off")
    yield from _done(Arm.disable)(shell, rest)


def _quit(_: Shell, __: str) -> Answers:
    raise Left


# -- the table of a simulated arm ------------------------------------------------------------


def _put(shell: Shell, rest: str) -> Answers:
    """Put a block on the table: `put A 250 0`, or with commas."""
    world = _world(shell)
    block = block_of(rest.replace(",", " ").split())
    with shell.arm.parts.pace.lock:
        world.put(block)
    yield _block_words(world, block.name)


def _blocks(shell: Shell, _: str) -> Answers:
    """Say where every block stands, as the simulated world itself has it."""
    world = _world(shell)
    for name in list(world.scene.blocks):
        yield _block_words(world, name)
    if not world.scene.blocks:
        yield "there are no blocks: `put A 250 0` puts one on the table"


def _block_words(world: World, name: str) -> str:
    block = world.scene.blocks[name]
    where = "in the fingers, its" if world.scene.held == name else "its"
    size = f"{block.width_mm:g} mm wide and {block.height_mm:g} mm high"
    return f"  {name}: {where} bottom at {block.place_words}, {size}"


def _world(shell: Shell) -> World:
    twin = shell.arm.twin
    if twin is None:
        raise BadRequest("what lies on the table of a real arm is unknown")
    return twin.world


# -- help and completion ------------------------------------------------------------------------


def help_on(word: str, shell: Shell) -> list[str]:
    """Return what a word means, or all words with a line each. Raises `BadRequest`."""
    low = word.strip().lower()
    if not low:
        own = (f"  {row.pattern:<34}{row.says}" for row in OWN_WORDS.values())
        last = "Ctrl-C stops what moves; a block ends with `end`"
        return [*overview(), "words of the shell", *own, last]
    found = meanings(low)
    if low in OWN_WORDS:
        found.append(f"{OWN_WORDS[low].pattern}\n  {OWN_WORDS[low].says}")
    named = [each for each in shell.session.context.defines if each.name.lower() == low]
    found += [f"{each.name}({', '.join(each.parameters)})\n  A subprogram." for each in named]
    if not found:
        known = (*SPELLINGS, *FUNCTIONS, *OWN_WORDS, *(row.name for row in FORMS))
        raise BadRequest(f"there is no word {word!r}{suggestion(low, known)}")
    return found


def known_words(shell: Shell) -> list[str]:
    """Return everything that can be completed at the prompt."""
    context = shell.session.context
    return [
        *(word for word in RESERVED if len(word) > 1),
        *OWN_WORDS,
        *context.variables,
        *(define.name for define in context.defines),
        *shell.arm.points,
    ]


@dataclass(frozen=True, slots=True)
class OwnWord:
    """A word of the shell: how its line is written, what it does, and the function that answers."""

    pattern: str
    says: str
    answer: Callable[[Shell, str], Answers]


# Every word of the shell.
OWN_WORDS: Mapping[str, OwnWord] = MappingProxyType({row.pattern.split()[0]: row for row in (
    OwnWord("help [WORD]", "List all words, or explain one.", _help),
    OwnWord("status", "Everything known about the arm.", _status),
    OwnWord("names", "The values, subprograms and points that are known.", _names),
    OwnWord("list", "The lines carried out so far, as a program.", _list),
    OwnWord(f"save FILE.arm [{OVER}]", "Write the list into a program file.", _save),
    OwnWord("new", "Forget names, subprograms and the list.", _new),
    OwnWord(f"put {PARTS}", "Put a block on a simulated arm's table, or move it there, mm.", _put),
    OwnWord("blocks", "Where the blocks of a simulated arm stand.", _blocks),
    OwnWord("reset", "Clear an error, after you have looked at the arm. Moves nothing.",
            _done(Arm.reset)),
    OwnWord("reconnect", "Reconnect a lost connection. Moves nothing.", _done(Arm.reconnect)),
    OwnWord("enable", "Switch the motors on. Moves nothing.", _done(Arm.enable)),
    OwnWord("disable [yes]", "Switch the motors off. The arm can sag.", _disable),
    OwnWord("quit", "Leave, as Ctrl-D does. `exit` is the same.", _quit),
    OwnWord("exit", "Leave, as `quit` does.", _quit),
)})  # fmt: skip
