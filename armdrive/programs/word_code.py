"""What each word is compiled to."""

# ruff: noqa: D102 - the methods are named for the words

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.programs.emitting import Emitter
from armdrive.programs.instructions import Op
from armdrive.programs.syntax import (
    Do,
)
from armdrive.programs.terms import (
    Name,
)
from armdrive.programs.writing import written

LOOKING = ("depart", "depart_line", "draw")
"""Words that first have to know where the arm stands."""

GOING = ("move", "move_line", "move_with", "move_line_with", "approach", "approach_line",
         "depart", "depart_line", "draw", "ready")  # fmt: skip
"""Words that take what `open` and `close` said along."""

_NAMED = GOING[:6]


class WordCode(Emitter):
    """Emits the words; most are an act of their values, see `act`."""

    def act(self, line: Do) -> None:
        looking = line.word in LOOKING
        if looking:
            self.emit(Op.LOOK, line.mark)
        count = self.values(line) + looking
        if line.word in GOING:
            self.emit(Op.FINGERS, line.mark, line.word)
        about = written(line.arguments[0]) if line.word in _NAMED else ""
        self.emit(Op.ACT, line.mark, line.word, count=count, about=about)

    def speed(self, line: Do) -> None:
        self.values(line)
        self.emit(Op.SPEED, line.mark)

    def opening(self, line: Do) -> None:
        if line.word == "close":
            self.emit(Op.PUSH, line.mark, value=0.0)
        shut = line.word == "close"
        self.emit(Op.OPENING, line.mark, line.word, count=self.values(line) + shut)

    def grasp(self, line: Do) -> None:
        self.emit(Op.ACT, line.mark, line.word, value=True)
        self.into(line)

    def into(self, line: Do) -> None:
        name = dict(line.links).get("into")
        if name is not None and isinstance(name[0], Name):
            self.store(name[0].name, name[0].mark)
        else:
            self.emit(Op.DROP, line.mark)

    def wait(self, line: Do) -> None:
        links = dict(line.links)
        limit = links.get("within", ())
        count = self.values(line)
        for value in limit:
            self.value(value)
        word = "wait within" if limit else line.word
        self.emit(Op.ACT, line.mark, word, value=True, count=count + len(limit))
        if "into" in links or not limit:
            self.into(line)
            return
        met = self.emit(Op.JUMP_IF, line.mark)
        wanted = ", ".join(written(value) for value in line.arguments)
        text = f"the inputs were not {wanted} within {written(limit[0])} s"
        self.emit(Op.FAIL, line.mark, value=text)
        self.aim(met)

    def here(self, line: Do) -> None:
        self.emit(Op.LOOK, line.mark)
        name = line.arguments[0]
        if isinstance(name, Name):
            self.store(name.name, name.mark)
            if line.word == "remember":
                self.value(name)
                self.emit(Op.ACT, line.mark, line.word, count=1, about=name.name)

    def shift(self, line: Do) -> None:
        count = self.values(line)
        for value in dict(line.links)["by"]:
            self.value(value)
        self.emit(Op.USE, line.mark, "shifted", count=count + 3)
        name = line.arguments[0]
        if isinstance(name, Name):
            self.store(name.name, name.mark)

    def expect(self, line: Do) -> None:
        condition, *rest = line.arguments
        self.value(condition)
        met = self.emit(Op.JUMP_IF, line.mark)
        for value in rest:
            self.value(value)
        text = "" if rest else f"it was expected that {written(condition)}"
        self.emit(Op.FAIL, line.mark, value=text, count=len(rest))
        self.aim(met)

    def stop(self, line: Do) -> None:
        count = self.values(line)
        if count:
            self.emit(Op.ACT, line.mark, "type", count=count)
        self.emit(Op.END, line.mark)

    def return_(self, line: Do) -> None:
        self.emit(Op.RETURN, line.mark)

    def break_(self, line: Do) -> None:
        self.scope.loops[-1][1].append(self.emit(Op.JUMP, line.mark))

    def continue_(self, line: Do) -> None:
        self.emit(Op.JUMP, line.mark, target=self.scope.loops[-1][0])


WORD_CODE: Mapping[str, Callable[[WordCode, Do], None]] = MappingProxyType({
    "speed": WordCode.speed, "open": WordCode.opening, "close": WordCode.opening,
    "grasp": WordCode.grasp, "wait": WordCode.wait, "here": WordCode.here,
    "remember": WordCode.here, "shift": WordCode.shift, "expect": WordCode.expect,
    "stop": WordCode.stop, "return": WordCode.return_, "break": WordCode.break_,
    "continue": WordCode.continue_,
})  # fmt: skip
"""The words that are more than an act of their values."""
