"""Whether every name surely has a value where it is used, whichever way the program took there.

The analysis of definite assignment over the flat code: forward, what is set on all ways that lead
to an instruction. Of each subprogram is found what it surely sets, and what it needs to be set
when it is called (Aho, Lam, Sethi and Ullman, Compilers, section 9.2.5, with summaries for calls).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from armdrive.programs.acts import Mark
from armdrive.programs.compiling import Code
from armdrive.programs.instructions import Instruction, Op
from armdrive.programs.problems import Problem

_BOTH = (Op.JUMP_UNLESS, Op.JUMP_IF, Op.KEEP_OFF, Op.KEEP_ON, Op.ROUND)
_LAST = (Op.RETURN, Op.END, Op.FAIL)
_Needs = dict[tuple[str, Mark], int | None]


class _Settled:
    def __init__(self, code: Code, known: frozenset[str]) -> None:
        self._known = known
        self._rows = code.instructions
        self._all = frozenset(row.name for row in self._rows if row.op is Op.STORE)
        starts = (0, *code.entries.values())
        self._sets: dict[int, frozenset[str]] = dict.fromkeys(starts, self._all)
        self._needs: dict[int, _Needs] = {start: {} for start in starts}
        self._repeat(self._learn_sets)
        self._repeat(self._learn_needs)

    def problems(self) -> Iterator[Problem]:
        for (name, mark), line in self._needs[0].items():
            called = "" if line is None else f" when this is called in line {line}"
            yield Problem(mark, f"{name!r} may have no value yet here{called}: set it before")

    def _repeat(self, learn: Callable[[int], bool]) -> None:
        changed = True
        while changed:
            changed = False
            for start in self._sets:
                changed |= learn(start)

    def _learn_sets(self, start: int) -> bool:
        ways = self._ways(start)
        ends = [known for at, known in ways.items() if self._rows[at].op is Op.RETURN]
        found = frozenset.intersection(*ends) if ends else self._all
        changed = found != self._sets[start]
        self._sets[start] = found
        return changed

    def _learn_needs(self, start: int) -> bool:
        needs = self._needs[start]
        before = len(needs)
        for at, known in self._ways(start).items():
            row = self._rows[at]
            if row.op is Op.LOAD and row.name not in known:
                needs.setdefault((row.name, row.mark), None)
            if row.op is Op.CALL:
                for (name, mark), _ in list(self._needs[row.target].items()):
                    if name not in known:
                        needs.setdefault((name, mark), row.mark.line)
        return len(needs) != before

    def _ways(self, start: int) -> dict[int, frozenset[str]]:
        """Return what is surely set before each instruction that can be reached."""
        first = frozenset() if start else self._known
        known: dict[int, frozenset[str]] = {start: first}
        waiting = [start]
        while waiting:
            at = waiting.pop()
            row = self._rows[at]
            after = known[at] | self._adds(row)
            for following in _following(at, row):
                before = known.get(following)
                met = after if before is None else before & after
                if met != before:
                    known[following] = met
                    waiting.append(following)
        return known

    def _adds(self, row: Instruction) -> frozenset[str]:
        if row.op is Op.STORE:
            return frozenset((row.name,))
        return self._sets[row.target] if row.op is Op.CALL else frozenset()


def _following(at: int, row: Instruction) -> tuple[int, ...]:
    if row.op in _LAST:
        return ()
    if row.op is Op.JUMP:
        return (row.target,)
    return (at + 1, row.target) if row.op in _BOTH else (at + 1,)


def unsettled(code: Code, known: frozenset[str] = frozenset()) -> list[Problem]:
    """Return the names that may have no value where they are used; `known` have one already."""
    return list(_Settled(code, known).problems())
