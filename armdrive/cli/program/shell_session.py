"""Takes the lines of a prompt: carries out entries on the arm, and the shell's own words."""

from __future__ import annotations

import argparse
import contextlib
import re
import signal
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from armdrive.arm import Arm
from armdrive.cli.presenter import agreed, put, put_error
from armdrive.cli.program.run_common import (
    LOOK_EVERY_S,
    Pressed,
    RunTerminal,
    put_blocks,
    stopped_by_interrupt,
)
from armdrive.cli.program.run_output import Display, RunOutput
from armdrive.cli.terminal_person import ask_operator
from armdrive.dialog.operator import PostureRequest
from armdrive.errors import ArmError, BadRequest, NotReferenced, OperatorNeeded
from armdrive.errors.actions import SHELL, presented
from armdrive.errors.table import tagged
from armdrive.programs.acts import Say
from armdrive.programs.interpreter import to_json
from armdrive.programs.language.syntax import Tree
from armdrive.programs.language.values import PlaceValue, value_text
from armdrive.programs.language.words import (
    FORMS,
    FUNCTIONS,
    OVER,
    RESERVED,
    SPELLINGS,
    meanings,
    overview,
)
from armdrive.programs.language.writing import unparse
from armdrive.programs.problems import ProgramError, SourceMark, mark_of
from armdrive.programs.program import ENDING, Machine, read_program_file
from armdrive.programs.session import INPUT, ArmSession, PromptEntry, Session
from armdrive.registry import dialect
from armdrive.setup.keyboard import raw_terminal
from armdrive.sim.world.table import GripScene, block_of
from armdrive.status import State, joints_view, pose_view, status_view
from kinematics.errors import suggestion

ENTER = (b"\r", b"\n")


@contextlib.contextmanager
def keys_at_prompt() -> Iterator[Pressed]:
    """Yield what tells whether Enter was pressed: not as a line, which readline would take."""
    with raw_terminal() as terminal:

        def pressed() -> bool:
            keys = terminal.read(LOOK_EVERY_S)
            return any(key in keys for key in ENTER)

        yield pressed


def ask_at_prompt(request: PostureRequest) -> bool:
    """Ask whether the arm stands in a posture; Ctrl-C is a no."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return ask_operator(request)
    except KeyboardInterrupt:
        put("\n")
        return False
    finally:
        signal.signal(signal.SIGINT, before)


WAYS_OUT: Mapping[State, str] = MappingProxyType(
    {
        State.ERROR_STOP: "look at the arm; `reset` leaves the error, and moves nothing",
        State.DISABLED: "`enable` switches the motors on",
        State.DISCONNECTED: "`reconnect` looks for the wire; `save` and `quit` need none",
    }
)
"""What to type in each state in which nothing moves."""

REFERENCE = "`home` references the arm"

_LINE = re.compile(r"\s*([a-z]+)(?:\s+([^\s=(].*?))?\s*", re.IGNORECASE)
"""A word and the text after it; `list = 3` assigns a value instead."""


class Left(Exception):
    """The person is done."""


ShellAction: TypeAlias = Callable[["Shell", str], None]
"""Carries out a word of the shell, given the text after it."""


class Shell:
    """A prompt's session on one arm; `typing` tells that a person types, and not a pipe."""

    def __init__(self, arm: Arm, options: argparse.Namespace, *, typing: bool) -> None:
        self.arm = arm
        self.typing = typing
        self._output = RunOutput(
            as_json=bool(options.json), rewrites=None if typing else False, words=SHELL
        )
        self.on_arm = ArmSession(arm, typing=typing)

    @property
    def session(self) -> Session:
        """What has been typed so far."""
        return self.on_arm.session

    @property
    def json(self) -> bool:
        """Whether events are printed instead of text."""
        return self._output.as_json

    def tell(self, event: Mapping[str, Any] | None, text: str) -> None:
        """Say something: an event for programs, lines for people."""
        self._output.tell(event, text)

    def take(self, line: str, position: int = 1) -> None:
        """Take a line: an entry's, or one of the shell's own words.

        `position` is its number in the input. Raises what the entry does, and `Left` for `quit`.
        """
        match = None if self.session.unfinished else _LINE.fullmatch(line)
        if match is not None and match[1].lower() in OWN_WORDS:
            self._do(OWN_WORDS[match[1].lower()], match[2] or "", position)
            return
        self.session.book = frozenset(self.arm.points)
        entry = self.session.take(line, position)
        if entry is not None:
            self.carry_out(entry)

    def _do(self, action: ShellAction, rest: str, position: int) -> None:
        try:
            with stopped_by_interrupt(lambda: [self.arm]):
                action(self, rest)
        except ArmError as error:
            if not (self.typing or self.json or isinstance(error, ProgramError)):
                put_error(f"{SourceMark(position, 1, INPUT)}\n")
            raise

    def carry_out(self, entry: PromptEntry) -> None:
        """Carry an entry out, shown as it is."""
        machine = self.on_arm.machine(entry)
        shown = Display(self._output, entry.program.lines, prompt=True)
        keys = keys_at_prompt if self.typing else None  # lines of a pipe are no answers
        show_values = partial(self._say_values, machine) if entry.says else None
        person = RunTerminal(self.arm, shown, keys, show_values)
        with shown.shown(), stopped_by_interrupt(lambda: [self.arm], ends=not self.typing):
            shown.run.use(self.arm)
            try:
                self.on_arm.carry_out(entry, machine, person, [] if entry.says else [shown])
            except BaseException as error:
                self._failed(entry, error, shown)
                raise

    def _say_values(self, machine: Machine, text: str) -> None:
        """Say values: to programs as such."""
        stage = machine.next()
        values = stage.act.values if stage is not None and isinstance(stage.act, Say) else ()
        view = {"event": "value", "values": list(map(to_json, values)), "text": text}
        self.tell(view, text)

    def _failed(self, entry: PromptEntry, error: BaseException, shown: Display) -> None:
        """Show where an entry ended early, unless it is the only line, which was just typed."""
        at = self.on_arm.at
        mark = mark_of(error, None if at is None else at.mark)
        program = entry.program
        seen = mark is not None and mark.file == program.file and "\n" not in program.text
        if self.json or not (self.typing and seen):
            shown.failed(mark, error, "")

    def complain(self, error: BaseException) -> None:
        """Say what went wrong, and what can be typed now."""
        put_error(f"armdrive: {presented(tagged(error), SHELL)}\n")
        ways = [WAYS_OUT.get(self.arm.status.state, "")]
        ways += [REFERENCE] * isinstance(error, NotReferenced | OperatorNeeded)
        put_error("".join(f"{way}\n" for way in ways if way))
        if self.session.unfinished:
            put_error("the line was not taken; Ctrl-C leaves the block\n")


# The shell's own words, besides those of the language: one table at the end.


def _help(shell: Shell, rest: str) -> None:
    for text in help_on(rest, shell):
        shell.tell({"event": "help", "text": text}, text)


def _list(shell: Shell, _: str) -> None:
    for number, body in shell.session.kept.items():
        text = unparse(Tree(body)).rstrip("\n")
        first, *others = text.split("\n")
        rows = [f"{number:>4}  {first}", *(f"      {line}" for line in others)]
        shell.tell({"event": "list", "entry": number, "text": text}, "\n".join(rows))
    if not shell.session.kept:
        shell.tell(None, "nothing has been carried out yet")


def _drop(shell: Shell, rest: str) -> None:
    if not (rest.isascii() and rest.isdecimal()):
        raise BadRequest("write it like `drop 3`, with a number that `list` shows")
    shell.session.drop(int(rest))
    shell.tell({"event": "dropped", "entry": int(rest)}, f"entry {rest} is out of the list")


def _save(shell: Shell, rest: str) -> None:
    name, _, over = rest.rpartition(" ")
    named, force = (name, True) if over.lower() == OVER and name else (rest, False)
    path = _program_path(named, "save stack.arm")
    lines = shell.on_arm.save(path, over=force)
    shell.tell(
        {"event": "saved", "file": str(path), "lines": lines},
        f"{lines} lines are in {path}: `armdrive run {path} --check` rehearses them",
    )


def _load(shell: Shell, rest: str) -> None:
    path = _program_path(rest, "load stack.arm")
    program = read_program_file(path)
    shell.carry_out(shell.session.load(program, str(path)))
    shell.tell(
        {"event": "loaded", "file": str(path)},
        f"the subprograms, points and values of {path} are known; `names` lists them",
    )


def _program_path(word: str, example: str) -> Path:
    name = word.strip().strip('"')
    if not name:
        raise BadRequest(f"say which file: `{example}`")
    path = Path(name)
    if path.suffix.lower() != ENDING:
        raise BadRequest(f"{path} is no program file: one ends in {ENDING}")
    return path


def _new(shell: Shell, _: str) -> None:
    shell.on_arm.start_over()
    shell.tell({"event": "new"}, "names, subprograms and the list are forgotten; the arm stays")


def _points(shell: Shell, _: str) -> None:
    for name, value in shell.session.context.variables.items():
        if isinstance(value, PlaceValue):
            view = {"event": "point", "name": name, "value": to_json(value), "book": False}
            shell.tell(view, f"  {name}: {value}")
    for name, point in shell.arm.points.items():
        deg = dict(point.joints.deg)
        place = PlaceValue(joints_deg=deg)
        view = {"event": "point", "name": name, "value": to_json(place), "book": True}
        shell.tell(view, f"  {name}: {place}, saved")


def _names(shell: Shell, _: str) -> None:
    context = shell.session.context
    for name, value in context.variables.items():
        if not isinstance(value, PlaceValue):
            view = {"event": "name", "name": name, "value": value}
            shell.tell(view, f"  {name} = {value_text(value)}")
    for define in context.defines:
        head = f"{define.name}({', '.join(define.parameters)})"
        shell.tell({"event": "subprogram", "name": define.name, "text": head}, f"  {head}")
    _points(shell, "")
    speed = f"  speed {value_text(context.speed * 100.0)}%"
    shell.tell({"event": "speed", "value": context.speed}, speed)


def _where(shell: Shell, _: str) -> None:
    status = shell.arm.status
    view = {
        "event": "where",
        "pose": pose_view(status.pose),
        "joints": joints_view(status.joints),
        "opening_mm": status.gripper_mm,
    }
    if status.pose is None:
        shell.tell(view, "the arm's position is unknown: `home` references it")
        return
    fingers = "" if status.gripper_mm is None else f", fingers {status.gripper_mm:.1f} mm apart"
    shell.tell(view, f"tip {status.pose}\njoints {status.joints}{fingers}")


def _status(shell: Shell, _: str) -> None:
    status = shell.arm.status
    shell.tell({"event": "status", **status_view(status)}, str(status))


def _reset(shell: Shell, _: str) -> None:
    shell.arm.reset()
    _tell_state(shell)


def _reconnect(shell: Shell, _: str) -> None:
    shell.arm.reconnect()
    _tell_state(shell)


def _enable(shell: Shell, _: str) -> None:
    shell.arm.enable()
    _tell_state(shell)


def _disable(shell: Shell, rest: str) -> None:
    what = f"after disable the arm {dialect(shell.arm.status.dialect).torque.disable}"
    shell.tell({"event": "warning", "text": what}, what)
    question = "Park it first with `ready`, or support it. Switch the motors off now? Type yes: "
    if rest.lower() != "yes" and not (shell.typing and agreed(question)):
        raise OperatorNeeded("the motors were left as they are: `disable yes` switches them off")
    shell.arm.disable()
    _tell_state(shell)


def _tell_state(shell: Shell) -> None:
    status = shell.arm.status
    shell.tell(
        {"event": "status", **status_view(status)},
        f"state {status.state.value}, motor current {status.current.value}, "
        f"position {status.trust.value}",
    )


def _quit(_: Shell, __: str) -> None:
    raise Left


# -- the table of a simulated arm ------------------------------------------------------------


def _put(shell: Shell, rest: str) -> None:
    """Put a block on the table: `put A 250 0`, or with commas."""
    _scene(shell)
    block = block_of(rest.replace(",", " ").split())
    put_blocks(shell.arm, [block])
    _tell_block(shell, block.name)


def _blocks(shell: Shell, _: str) -> None:
    """Say where every block stands, as the simulated world itself has it."""
    names = list(_scene(shell).blocks)
    for name in names:
        _tell_block(shell, name)
    if not names:
        shell.tell(None, "there are no blocks: `put A 250 0` puts one on the table")


def _tell_block(shell: Shell, name: str) -> None:
    scene = _scene(shell)
    block, held = scene.blocks[name], scene.held == name
    where = "in the fingers, its" if held else "its"
    text = f"{where} bottom at x {block.x_mm:.1f}, y {block.y_mm:.1f}, z {block.z_mm:.1f} mm"
    size = f"{block.width_mm:g} mm wide and {block.height_mm:g} mm high"
    view = {"event": "block", **asdict(block), "held": held}
    shell.tell(view, f"  {name}: {text}, {size}")


def _scene(shell: Shell) -> GripScene:
    twin = shell.arm.twin
    if twin is None:
        raise BadRequest("what lies on the table of a real arm is unknown")
    return twin.world.scene


# -- help and completion ------------------------------------------------------------------------


def help_on(word: str, shell: Shell) -> list[str]:
    """Return what a word means, or all words with a line each. Raises `BadRequest`."""
    low = word.strip().lower()
    if not low:
        return overview()
    found = meanings(low)
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


OWN_WORDS: Mapping[str, ShellAction] = MappingProxyType({
    "help": _help, "where": _where, "status": _status, "names": _names, "points": _points,
    "list": _list, "drop": _drop, "save": _save, "load": _load, "new": _new, "put": _put,
    "blocks": _blocks, "reset": _reset, "reconnect": _reconnect, "enable": _enable,
    "disable": _disable, "quit": _quit, "exit": _quit,
})  # fmt: skip
"""The function of every word of the shell."""
