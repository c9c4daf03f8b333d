"""Damped least-squares steps as straight-line code, one function for each size of the system.

A step solves (JᵗJ + damping · largest diagonal entry) s = Jᵗ e by Cholesky's decomposition
(Marquardt, 1963). Written out, with every entry a local variable, it takes a tenth of the time that
loops over lists take, and descents do little else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import sqrt

from kinematics.chains.code_lines import functions_of

Rows = Sequence[Sequence[float]]

StepFinder = Callable[[Rows, Sequence[float], float], tuple[float, ...]]
"""Return the step for a Jacobian's rows, the errors, and the damping."""


@lru_cache(maxsize=16)
def damped_step(rows: int, columns: int) -> StepFinder:
    """Return the function for a Jacobian of this size."""
    found: StepFinder = functions_of(_source(rows, columns), {"sqrt": sqrt}, "steps")["step"]
    return found


def _source(rows: int, columns: int) -> str:
    """Return the source: a is the system, l its triangle, y and s the two substitutions."""
    joints = range(columns)
    listed = ", ".join(f"({', '.join(f'j{r}{c}' for c in joints)},)" for r in range(rows))
    lines = [f"{listed}, = rows", f"{', '.join(f'e{r}' for r in range(rows))}, = error"]
    for c in joints:
        lines += [
            f"a{c}{d} = " + "+".join(f"j{r}{c}*j{r}{d}" for r in range(rows)) for d in range(c + 1)
        ]
    diagonal = ", ".join(f"a{c}{c}" for c in joints)
    lines.append(f"damping *= max({diagonal}, 1e-300)")
    for c in joints:
        for d in range(c):
            less = "".join(f"-l{c}{k}*l{d}{k}" for k in range(d))
            lines.append(f"l{c}{d} = (a{c}{d}{less})*i{d}")
        less = "".join(f"-l{c}{k}*l{c}{k}" for k in range(c))
        lines.append(f"p{c} = a{c}{c}{less}+damping")
        lines.append(f"i{c} = 1.0/sqrt(p{c}) if p{c} > 0.0 else 0.0")
        pull = "+".join(f"j{r}{c}*e{r}" for r in range(rows))
        less = "".join(f"-l{c}{k}*y{k}" for k in range(c))
        lines.append(f"y{c} = ({pull}{less})*i{c}")
    for c in reversed(joints):
        less = "".join(f"-l{k}{c}*s{k}" for k in range(c + 1, columns))
        lines.append(f"s{c} = (y{c}{less})*i{c}")
    lines.append(f"return ({', '.join(f's{c}' for c in joints)},)")
    return "def step(rows, error, damping):\n" + "\n".join(f"    {line}" for line in lines)
