"""Chains as tables of plain rows, in mm and degrees, as a person writes them, and as text.

An edge for people: keys say their unit. A row of a revolute joint has `theta_deg`, `d_mm`,
`a_mm`, `alpha_deg`, `offset_deg`, `low_deg`, `high_deg`; a prismatic one has `offset_mm`,
`low_mm`, `high_mm` instead. `joint` is its name and `kind` is "revolute" or "prismatic". What is
left out is zero, and without limits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.errors import KinematicsError, finite, suggestion
from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD, as_list
from kinematics.frames.transforms import IN_PLACE, Transform

Row = dict[str, str | float]

_COMMON = ("joint", "kind", "theta_deg", "d_mm", "a_mm", "alpha_deg")
_OWN = ("offset", "low", "high")


def chain_of_rows(
    rows: Iterable[Mapping[str, object]],
    *,
    convention: Convention = Convention.STANDARD,
    base: Transform = IN_PLACE,
    tool: Transform = IN_PLACE,
    name: str = "",
) -> Chain:
    """Make a chain of table rows.

    Raises `KinematicsError`, which names the row, for a key that no row has (with the nearest
    one) or a kind that no joint is, and `BadNumber` for what is not a number.
    """
    listed = as_list(rows) or ()
    for number, row in enumerate(listed, 1):
        if not isinstance(row, Mapping):
            raise KinematicsError(f"row {number} is a table of keys and values, not {row!r}")
    links = tuple(_link(number, row) for number, row in enumerate(listed, 1))
    names = tuple(str(row.get("joint", f"joint_{i}")) for i, row in enumerate(listed, 1))
    return Chain(links, convention, base, tool, name, names)


def rows_of(chain: Chain) -> tuple[Row, ...]:
    """Return the rows that `chain_of_rows` makes this chain's links of."""
    return tuple(
        _row(name, link) for name, link in zip(chain.joint_names, chain.links, strict=True)
    )


def table_text(chain: Chain) -> str:
    """Return the link table as text in mm and degrees, `*` at what the joint varies.

    The heading names the convention, since the same numbers mean another arm in the other one.
    """
    craig = chain.convention is Convention.CRAIG
    head = ("joint", "theta/deg", "d/mm", "a/mm", "alpha/deg")
    if craig:
        head = ("joint", "theta/deg", "d/mm", "a before/mm", "alpha before/deg")
    cells = [head]
    for name, link in zip(chain.joint_names, chain.links, strict=True):
        theta, distance, length, twist = link.parameters(0.0)
        revolute = link.kind is JointKind.REVOLUTE
        cells.append(
            (
                name,
                _plain(_degrees(theta)) + ("*" if revolute else ""),
                _plain(distance) + ("" if revolute else "*"),
                _plain(length),
                _plain(_degrees(twist)),
            )
        )
    title = f"{chain.name}: " if chain.name else ""
    return "\n".join(
        [f"{title}{chain.convention.value} convention, * varies", *aligned(cells, left=1)]
    )


def aligned(cells: Sequence[Sequence[str]], *, left: int = 0, gap: str = "  ") -> list[str]:
    """Return rows of cells as lines of aligned columns, the first `left` of them flush left."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    sides = [str.ljust] * left + [str.rjust] * (len(widths) - left)
    return [
        gap.join(side(cell, width) for side, cell, width in zip(sides, row, widths, strict=True))
        for row in cells
    ]


def _link(number: int, row: Mapping[str, object]) -> DHLink:
    kind = _kind(number, row.get("kind", JointKind.REVOLUTE.value))
    unit = "deg" if kind is JointKind.REVOLUTE else "mm"
    allowed = [*_COMMON, *(f"{key}_{unit}" for key in _OWN)]
    for key in row:
        if key not in allowed:
            hint = suggestion(key, allowed)
            raise KinematicsError(
                f"row {number}: a {kind.value} joint has no {key!r}{hint} "
                f"(there are {', '.join(allowed)})"
            )

    def number_of(key: str) -> float:
        value = finite(key, row.get(key, 0.0))
        return math.radians(value) if key.endswith("_deg") else value

    def bound_of(key: str, without: float) -> float:
        return number_of(key) if key in row else without

    return DHLink(
        number_of("theta_deg"),
        number_of("d_mm"),
        number_of("a_mm"),
        number_of("alpha_deg"),
        kind,
        number_of(f"offset_{unit}"),
        bound_of(f"low_{unit}", -math.inf),
        bound_of(f"high_{unit}", math.inf),
    )


def _kind(number: int, given: object) -> JointKind:
    for kind in JointKind:
        if given is kind or given == kind.value:
            return kind
    raise KinematicsError(
        f"row {number}: a joint is {' or '.join(kind.value for kind in JointKind)}, not {given!r}"
    )


def _row(name: str, link: DHLink) -> Row:
    revolute = link.kind is JointKind.REVOLUTE
    row: Row = {
        "joint": name,
        "kind": link.kind.value,
        "theta_deg": _degrees(link.theta_rad),
        "d_mm": link.d_mm,
        "a_mm": link.a_mm,
        "alpha_deg": _degrees(link.alpha_rad),
    }
    for key in _OWN:
        value = getattr(link, key)
        if math.isfinite(value) and not (key == "offset" and value == 0.0):
            row[f"{key}_{'deg' if revolute else 'mm'}"] = _degrees(value) if revolute else value
    return row


def _degrees(angle_rad: float) -> float:
    """Return degrees, whole ones where the radians are a whole number of them but for rounding."""
    degrees = math.degrees(angle_rad)
    whole = round(degrees)
    return (
        float(whole) if abs(math.radians(whole) - angle_rad) <= QUARTER_TOLERANCE_RAD else degrees
    )


def _plain(value: float) -> str:
    """Format without the minus sign of a rounded zero."""
    return f"{round(value, 4) + 0.0:g}"
