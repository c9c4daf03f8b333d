"""A program that was read and checked, and the machine that runs it.

A machine gives acts one at a time, takes their answers, and can be written down. It is pure: it
knows no arm and no clock. Its caller repeats `stage = machine.next()`, carries `stage.act` out, and
hands the answer to `machine.answer(...)`, until `next` returns None.

A snapshot holds the state before the present act, so a machine restored from it gives the same act
again, and then the same rest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmError, BadRequest
from armdrive.moves import GraspMove
from armdrive.programs.acts import (
    Act,
    Answer,
    AwaitInputs,
    Go,
    Look,
    ReadInput,
    RunStage,
)
from armdrive.programs.interpreter import (
    HANDLERS,
    STATE,
    VALUE,
    ActNeeded,
    Frame,
    LineContext,
    MachineState,
    value_of,
)
from armdrive.programs.language import ENDING
from armdrive.programs.language.checking import CheckedProgram, checked, values_read
from armdrive.programs.language.grammar import read_tree
from armdrive.programs.language.syntax import (
    NOWHERE,
    Assign,
    Call,
    Define,
    Do,
    Goto,
    If,
    JointsOf,
    Repeat,
    Statement,
    Tree,
    While,
    set_by,
)
from armdrive.programs.language.values import (
    ForwardKinematics,
    LineFailure,
    PlaceValue,
    Value,
    number,
    place,
    truth,
)
from armdrive.programs.language.words import COUNT
from armdrive.programs.problems import (
    Problem,
    ProgramError,
    SourceLines,
    SourceMark,
    lines_of,
    numbered_lines,
    program_error,
)
from armdrive.storage.point_file import points_of
from armdrive.text.json_forms import by_name
from armdrive.text.reading import read_text
from kinematics.errors import KinematicsError, suggestion
from kinematics.spaces import Joints, Pose

# What is known before a program runs: the names of those that ran before it at a prompt.


@dataclass(frozen=True, slots=True)
class Context:
    """The subprograms and values that are known already, by names in lower case.

    `opening` is the one that the fingers take with the next move, see `MachineState`. `lines` are
    those that the subprograms were read from.
    """

    defines: tuple[Define, ...] = ()
    variables: Mapping[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None
    lines: SourceLines = field(default_factory=dict)

    def but(self, defines: tuple[Define, ...]) -> tuple[Define, ...]:
        """Return the known subprograms that these do not replace, followed by these."""
        replaced = {define.name.lower() for define in defines}
        kept = (each for each in self.defines if each.name.lower() not in replaced)
        return (*kept, *defines)


@dataclass(frozen=True)
class Program:
    """A program that was read and checked.

    `tree` is the program as written, `code` are its blocks; `context` was known before it.
    `lines` are its lines and those of the context. `near` says that a person has just typed it, so
    an error does not name its place.
    """

    text: str
    file: str
    tree: Tree
    code: CheckedProgram = field(default_factory=CheckedProgram)
    context: Context = field(default_factory=Context)
    lines: SourceLines = field(default_factory=dict)
    near: bool = False

    def error(self, problems: Iterable[Problem]) -> ProgramError:
        """Return the error with these problems, at least one."""
        return program_error(problems, self.lines, self.file if self.near else None)

    @cached_property
    def digest(self) -> str:
        """The sha256 of the text."""
        return hashlib.sha256(self.text.encode("utf-8", "surrogatepass")).hexdigest()

    @property
    def wanted(self) -> Mapping[str, SourceMark]:
        """The points of the arm's book that it uses, and where each is named first."""
        return self.code.points

    def machine(
        self,
        points: Mapping[str, Mapping[str, float]] | None = None,
        fk: ForwardKinematics | None = None,
        joint_names: tuple[str, ...] | None = None,
    ) -> Machine:
        """Return a run of it, at its beginning.

        `points` is the arm's book: joint angles (deg, by joint) by the names of the points. `fk`
        computes the pose of joint angles; `joint_names` are the arm's joints. Raises `ProgramError`
        with every unknown name.
        """
        places, problems = self._places({} if points is None else points)
        if joint_names is not None:
            problems += self._wrong_joints(joint_names)
        if problems:
            raise self.error(problems)
        known = self.context
        variables = dict(known.variables)
        state = MachineState(variables=variables, speed=known.speed, opening=known.opening)
        return Machine(self, places, fk, state)

    def restored(
        self, snapshot: Mapping[str, object], *, fk: ForwardKinematics | None = None
    ) -> Machine:
        """Resume a run where its snapshot was made, with the points of that time.

        Raises `ProgramError` for a snapshot of another program, or of another format.
        """
        if (snapshot.get("format"), snapshot.get("program")) != (FORMAT, self.digest):
            raise ProgramError(
                "this state is that of another program, or of another version of armdrive: start "
                "the program again"
            )
        try:
            values = by_name(VALUE).read(snapshot["points"], "points")
            points = {name: place(value) for name, value in values.items()}
            state = STATE.read(snapshot["state"], "state")
            for frame in state.frames:  # raises `IndexError` for a state beyond the end
                _ = (*self.code.blocks[frame.block].body, None)[frame.at]
            _ = {**state.frames[0].own}  # type: ignore[dict-item] # raises `TypeError` for None
        except (KeyError, TypeError, ValueError, IndexError, ArmError, LineFailure) as error:
            raise ProgramError(f"this state of a program cannot be used: {error}") from None
        return Machine(self, points, fk, state)

    @property
    def _statements(self) -> Iterator[Statement]:
        return (line for block in self.code.blocks for line in block.body)

    def _places(
        self, book: Mapping[str, Mapping[str, float]]
    ) -> tuple[dict[str, PlaceValue], list[Problem]]:
        own = {name.name for line in self._statements for name in set_by(line)}
        places, problems = {}, []
        for name, mark in self.wanted.items():
            found = _in_book(name, book, own | {*self.context.variables})
            if isinstance(found, str):
                problems.append(Problem(mark, found))
            else:
                places[name] = PlaceValue(joints_deg=dict(found))
        return places, problems

    def _wrong_joints(self, joint_names: tuple[str, ...]) -> list[Problem]:
        values = (value for line in self._statements for value in values_read(line))
        found = [value for value in values if isinstance(value, JointsOf)]
        wrong = [(each.mark, _joints_wrong([*dict(each.angles)], joint_names)) for each in found]
        return [Problem(mark, text) for mark, text in wrong if text]


def _in_book(
    name: str, book: Mapping[str, Mapping[str, float]], own: Collection[str]
) -> Mapping[str, float] | str:
    """Return a point by its name, or a sentence that says why there is none.

    Capitals do not matter, unless two points differ in nothing else. `own` are the program's names,
    which a misspelt name may mean.
    """
    if name in book:
        return book[name]
    alike = [each for each in book if each.lower() == name.lower()]
    if len(alike) == 1:
        return book[alike[0]]
    near = suggestion(name, (*book, *own))
    return f"{name!r} is not defined, and no saved point has that name{near}"


def _joints_wrong(named: list[str], known: tuple[str, ...]) -> str:
    unknown = next((name for name in named if name not in known), None)
    if unknown is not None:
        return f"this arm has no joint {unknown!r}{suggestion(unknown, known)}"
    missing = [name for name in known if name not in named]
    return (
        f"a place in joint angles names every joint: {', '.join(missing)} missing"
        if missing
        else ""
    )


# The most lines between two acts. They take some tenths of a second.
MOST_STEPS = 100_000

# How deep subprograms may call one another, or themselves.
DEEPEST_CALL = 50

# The format of a snapshot.
FORMAT = 3


class Machine:
    """One run of a program.

    `points` are the places of the arm's book that the program uses; `fk` is the arm's.
    """

    def __init__(
        self,
        program: Program,
        points: Mapping[str, PlaceValue],
        fk: ForwardKinematics | None,
        state: MachineState,
    ) -> None:
        self.program = program
        self._points = points
        self._fk = fk
        self._state = state
        self._stage: RunStage | None = None
        self._error: ProgramError | None = None

    @property
    def ended_by_stop(self) -> bool:
        """Whether it ended at a `stop`, and not after its last line."""
        return self._state.ended and isinstance(self._line, Do)

    def require_fingers_moved(self) -> None:
        """Raise `ProgramError` if an `open` or a `close` still waits for a move at the end."""
        opening = self.context.opening
        if opening is not None and not self.ended_by_stop:
            word = "close" if opening == 0.0 else "open"
            text = f"`{word}` waits for the next move, and none follows: write `{word}_now`"
            raise self._failure(text, self.program.tree.body[-1].mark)

    @property
    def context(self) -> Context:
        """The names that it has set so far, for the next entry at a prompt."""
        known, state = self.program.context, self._state
        own = self.program.tree.defines
        lines = self.program.lines
        return Context(known.but(own), dict(state.variables), state.speed, state.opening, lines)

    def next(self) -> RunStage | None:
        """Return the present act, the same until it is answered; None at the end.

        Raises `ProgramError` if a line cannot be carried out, and again when it is called again.
        """
        if self._error is not None:
            raise self._error
        if self._stage is None and not self._state.ended:
            self._stage = self._run_on()
        return self._stage

    def answer(self, answer: Answer) -> None:
        """Take the answer to the act. Raises `ProgramError` for an answer of a wrong kind."""
        stage = self.next()
        if stage is None:
            raise ProgramError("the program has ended: there is no act to answer")
        try:
            brought = _brought(stage.act, answer)
        except LineFailure as error:
            raise self._failure(f"the answer does not fit: {error}", stage.mark) from None
        self._state.answers += (brought,)
        if isinstance(stage.act, Go):
            self._state.moved = True  # the fingers moved too: `opening` is done with
        self._stage = None

    @property
    def fingerprint(self) -> str:
        """A key that is equal for equal states of the program."""
        return json.dumps(STATE.write(self._state))

    def snapshot(self) -> dict[str, object]:
        """Return the program's whole state, as plain JSON data."""
        return {
            "format": FORMAT,
            "program": self.program.digest,
            "points": by_name(VALUE).write(dict(self._points)),
            "state": STATE.write(self._state),
        }

    # -- line by line ------------------------------------------------------------------------

    def _line_of(self, frame: Frame) -> Statement | None:
        """Return the line at which a block is; None at its end."""
        body = self.program.code.blocks[frame.block].body
        return body[frame.at] if frame.at < len(body) else None

    @property
    def _line(self) -> Statement | None:
        return self._line_of(self._state.frames[-1])

    def _run_on(self) -> RunStage | None:
        """Go on to the next act; return None at the end."""
        wrong, mark = "the program loops here without giving the arm anything to do", NOWHERE
        for _ in range(MOST_STEPS):
            line = self._line
            if line is None:
                self._end_block()
            else:
                context = LineContext(self._state, line, self._points, self._fk)
                try:
                    self._run(line, context)
                except ActNeeded as needed:
                    return RunStage(needed.act, needed.mark)
                except (LineFailure, ArmError, KinematicsError) as error:
                    wrong, mark = str(error), context.mark
                    break
                mark = line.mark
            if self._state.ended:
                return None
        self._error = self._failure(wrong, mark)
        raise self._error

    def _run(self, line: Statement, context: LineContext) -> None:
        """Run a line, and go to the next one."""
        frame, code = self._state.frames[-1], self.program.code
        match line:
            case Do(word="break"):
                self._leave_for_loop()
            case Do(word="continue"):
                self._leave_for_loop()
                return
            case Do(word="return"):
                while self._leave().own is None:
                    pass
            case Do(word=word):
                HANDLERS[word](context)
                if self._state.ended:
                    return
            case Assign(value=value):
                context.store(context.values((value,))[0])
            case Goto(name=name):
                while name.lower() not in code.blocks[self._state.frames[-1].block].labels:
                    self._leave()
                frame = self._state.frames[-1]
                frame.at = code.blocks[frame.block].labels[name.lower()]
            case Call():
                self._call(line, context)
                return
            case If(branches=branches):
                for index, branch in enumerate(branches):
                    context.mark = branch.mark
                    if branch.condition is None or truth(value_of(branch.condition, context)):
                        self._enter(code.blocks[frame.block].inner[frame.at][index])
                        return
            case While(condition=condition):
                if truth(context.values((condition,))[0]):
                    self._enter(code.blocks[frame.block].inner[frame.at][0])
                    return
            case Repeat():
                if _another_round(line, frame, context):
                    self._enter(code.blocks[frame.block].inner[frame.at][0])
                    return
        self._follow()

    def _follow(self) -> None:
        """Go to the line after the present one."""
        state = self._state
        frame = state.frames[-1]
        frame.at, frame.begun, frame.rounds, state.answers = frame.at + 1, 0, None, ()
        if state.moved:
            state.opening, state.moved = None, False

    def _enter(self, block: int, own: dict[str, Value] | None = None) -> None:
        """Begin a block. The line around it stays the present one of its own block."""
        self._state.answers = ()
        self._state.frames += (Frame(block, own=own),)

    def _leave(self) -> Frame:
        """Go back to the line around the present block."""
        self._state.answers = ()
        *outer, left = self._state.frames
        self._state.frames = tuple(outer)
        return left

    def _leave_for_loop(self) -> None:
        self._leave()
        while not isinstance(self._line, While | Repeat):
            self._leave()

    def _end_block(self) -> None:
        """Go on where a block ends: a loop decides itself whether there is another round."""
        if len(self._state.frames) == 1:
            self._state.ended = True
            return
        self._leave()
        if not isinstance(self._line, While | Repeat):
            self._follow()

    def _call(self, line: Call, context: LineContext) -> None:
        values = context.values(line.arguments)
        if len([each for each in self._state.frames if each.own is not None]) > DEEPEST_CALL:
            raise LineFailure(f"subprograms call one another more than {DEEPEST_CALL} deep")
        called = self.program.code.subprograms[line.name.lower()]
        self._enter(called.block, dict(zip(called.parameters, values, strict=True)))

    def _failure(self, text: str, mark: SourceMark) -> ProgramError:
        lines = (self._line_of(frame) for frame in self._state.frames[:-1])
        calls = [line.mark.line for line in lines if isinstance(line, Call)]
        led = "".join(f", called in line {line}" for line in reversed(calls[-3:]))
        return self.program.error([Problem(mark, text + led)])


def _another_round(line: Repeat, frame: Frame, context: LineContext) -> bool:
    """Begin the next round of a loop, unless all are done."""
    if not frame.begun and line.count is not None:
        frame.rounds = int(number(context.values((line.count,), (COUNT,))[0]))
    if frame.rounds is not None and frame.begun >= frame.rounds:
        return False
    if frame.rounds is not None or line.variable:
        frame.begun += 1  # endless rounds that nothing counts all have the same state
    context.store(float(frame.begun))
    return True


def _brought(act: Act, answer: Answer) -> Value:
    """Return the value of an answer for its line; True for an act without a value."""
    match act:
        case Look():
            if not isinstance(answer, PlaceValue):
                raise LineFailure("the place of the arm is needed")
            return answer
        case ReadInput():
            return truth(answer)
        case AwaitInputs(within_s=limit_s) if limit_s is not None:
            return truth(answer)
        case Go(move=GraspMove()):
            return number(answer)
        case _:
            return True


# Reading a program.


def read_program(text: str, file: str = "") -> Program:
    """Read a program and check it as a whole. Raises `ProgramError` with all that is wrong."""
    tree, problems = read_tree(text, file)
    lines = numbered_lines(lines_of(text), file)
    return checked_program(Program(text, file, tree, lines=lines), problems)


def checked_program(program: Program, problems: Iterable[Problem] = ()) -> Program:
    """Check a program that was read with these problems. Raises `ProgramError`."""
    own, known = program.tree.defines, program.context
    rest = tuple(line for line in program.tree.body if not isinstance(line, Define))
    # known subprograms are checked again: this program may replace what they call
    code, wrong = checked(Tree((*rest, *known.but(own))), frozenset(known.variables))
    if problems or wrong:
        raise program.error([*problems, *wrong])
    return replace(program, code=code)


# A program for one arm, with that arm's points and joints.


def program_path(word: str, example: str) -> Path:
    """Return the path of a program file that a person names; `example` shows how."""
    name = word.strip().strip('"')
    if not name:
        raise BadRequest(f"say which file: `{example}`")
    path = Path(name)
    if path.suffix.lower() != ENDING:
        raise BadRequest(f"{path} is not a program file: its name must end in {ENDING}")
    return path


@dataclass(frozen=True)
class ArmProgram:
    """A program and the arm that it is for."""

    program: Program
    config: ArmConfig

    def machine(self) -> Machine:
        """Return a machine at the beginning, with the arm's present points."""
        taught = points_of(self.config.name, self.config.model.arm).read()
        points = {name: point.joints.deg for name, point in taught.items()}
        names = self.config.model.arm.joint_names
        return self.program.machine(points, fk=self._fk, joint_names=names)

    def restored(self, snapshot: Mapping[str, object]) -> Machine:
        """Return a machine where a snapshot was made, with the points of that time."""
        return self.program.restored(snapshot, fk=self._fk)

    def _fk(self, joints_deg: Mapping[str, float]) -> Pose:
        names = self.config.model.arm.joint_names
        return self.config.model.arm.fk(Joints.of(*(joints_deg[n] for n in names), names=names))


def read_program_file(path: Path) -> Program:
    """Read a program file. Raises `BadRequest` if it is no readable text, and `ProgramError`."""
    return read_program(read_text(path, "the program", BadRequest), str(path))
