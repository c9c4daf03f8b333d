"""Every dialect has every behaviour: in simulated time, a few over a pty; and the page says so."""

import re
import sys
from collections.abc import Sequence
from zlib import crc32

import pytest
from amounts import THOROUGH
from pages import page_path
from waiting import LONG_S

from armdrive.errors import DeviceFault
from armdrive.registry import DIALECTS

from .behaviour import EVERYWHERE, Behaviour
from .bench import Bench
from .faults import EXPECTED_ERRORS, MOVING, STANDING
from .memory_bench import VARIANTS, MemoryBench, ThoroughMemoryBench, Variant
from .observation import Broken
from .real_time_bench import PtyBench
from .running import BEHAVIOURS, BENCHES, RowResult, Verdict
from .table import page

SIMULATED = list(DIALECTS)

LOOKED_AT = {name: MemoryBench(name) for name in SIMULATED}
"""A bench of each dialect, to ask whether a row applies to it."""


def kind(dialect: str) -> tuple[bool, bool]:
    """Return how motion is driven: over a bus or not, and by a queue or in bursts."""
    row = DIALECTS[dialect]
    return row.can, bool(row.abilities.queued_segments)


def turn_of(row: Behaviour) -> int:
    """Return a number that follows from the name alone: a new row leaves all others as they are."""
    return crc32(row.name.encode())


def runs_today(row: Behaviour, dialect: str) -> bool:
    """Return whether the everyday tests run a row on a dialect: one of each kind, in turn."""
    applies = [name for name in SIMULATED if not row.why_not_applicable(LOOKED_AT[name])]
    if THOROUGH or dialect not in applies:
        return dialect in applies
    alike = [name for name in applies if kind(name) == kind(dialect)]
    return dialect == alike[turn_of(row) // 2 % len(alike)]


def moments_of(row: Behaviour, name: str, all_s: Sequence[float | None]) -> list[float | None]:
    """Return when a fault strikes today: where an error is expected, else one moment in turn."""
    fault = row.fault
    if fault is None:
        return []
    expected = [each for each in (STANDING, MOVING) if (name, fault.name, each) in EXPECTED_ERRORS]
    able = [each for each in all_s if fault.idle or each is not STANDING]
    return expected or [able[turn_of(row) // 8 % len(able)]]


def run(behaviour: Behaviour, bench: Bench) -> None:
    """Run a row, or skip it with the reason why it is not applicable."""
    why = behaviour.why_not_applicable(bench)
    if why:
        pytest.skip(why)
    behaviour.run(bench)


EVERYDAY = {"cia402": Variant("cia402", "cia402", {"period_ms": 20})}
"""Settings of the everyday rows: at twice the period the drives exchange half as many frames."""


@pytest.mark.parametrize(
    ("behaviour", "dialect"),
    [
        pytest.param(row, dialect, id=f"{row.name}-{dialect}")
        for row in BEHAVIOURS
        if row.runs_over("memory")
        for dialect in SIMULATED
        if runs_today(row, dialect)
    ],
)
def test_on_simulated_time(behaviour, dialect):
    """A row strikes one dialect of each kind; faults and stops come at one moment.

    `tests/bounds` checks the bounds at their worst moments. With THOROUGH=1, and by
    `python -m tests.conformance`, all dialects and all moments are tested.
    """
    settings = EVERYDAY.get(dialect)
    with ThoroughMemoryBench(dialect) if THOROUGH else MemoryBench(dialect, settings) as bench:
        if not THOROUGH:
            turn = turn_of(behaviour) // 8 % len(bench.stops_after_s)
            bench.fault_moments_s = moments_of(behaviour, dialect, bench.fault_moments_s)
            bench.stops_after_s = bench.stops_after_s[turn:][:1]
        run(behaviour, bench)


def runs_on_variant(row: Behaviour, variant: Variant) -> bool:
    """Return whether the everyday tests run a row on a variant.

    They run a quarter of the rows of the families in which the variant differs from its dialect;
    of the faults only those after which an error is expected, in motion.
    """
    if not row.runs_over("memory"):
        return False
    if THOROUGH:
        return True
    if row.fault and (variant.dialect, row.fault.name, MOVING) not in EXPECTED_ERRORS:
        return False
    turn = crc32(f"{variant.name} {row.name}".encode())
    return row.family in variant.differs and turn % 4 == 0


@pytest.mark.parametrize(
    ("variant", "behaviour"),
    [
        pytest.param(variant, row, id=f"{variant.name}: {row.name}")
        for variant in VARIANTS
        for row in BEHAVIOURS
        if runs_on_variant(row, variant)
    ],
)
def test_on_a_variant(variant, behaviour):
    with MemoryBench(variant.dialect, variant) as bench:
        bench.fault_moments_s = bench.fault_moments_s[-1:]
        try:
            run(behaviour, bench)
        except (Broken, DeviceFault) as error:
            if not re.search(r"`\$H[XYZABC]`: error 3, .* not known or not supported", str(error)):
                raise
            pytest.skip("this build homes all axes at once, not one after another")


class UnhurriedPtyBench(PtyBench):
    """A pty bench on a computer that may be busy."""

    punctual = False
    look_s = 0.1  # each look asks another process, and no bound depends on it
    stops_after_s = (0.2,)

    def watch(self, done, longest_s):
        """Observe until `done()`; the limit only ends a hang."""
        return super().watch(done, max(longest_s, LONG_S))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_few_over_a_pty():
    """Bounds are checked in simulated time, and on an idle computer by the command.

    Drives rightly find a program gone that a busy computer delays; a board does not.
    """
    with UnhurriedPtyBench("grbl") as bench:
        for behaviour in (row for row in BEHAVIOURS if row.smoke):
            behaviour.run(bench)
            bench.disconnect()


# -- The page --------------------------------------------------------------------------------------


def result(verdict=Verdict.KEPT, transport="memory", words="", row=BEHAVIOURS[0]):
    return RowResult(row.name, "teachmover", transport, verdict, words)


def test_the_page_has_every_behaviour_and_every_dialect():
    shown = page_path("conformance").read_text(encoding="utf-8")
    names = re.findall(r"^[-|] (.*?)(?: \||$)", shown, re.MULTILINE)
    assert {row.name for row in BEHAVIOURS} <= set(names)
    assert f"| behaviour | {' | '.join(DIALECTS)} |" in shown


def test_every_row_has_a_name_of_its_own_and_is_run_somewhere():
    assert len({row.name for row in BEHAVIOURS}) == len(BEHAVIOURS)
    assert set(BENCHES) | {"port"} >= set(EVERYWHERE)
    assert not [row.name for row in BEHAVIOURS if not set(row.transports) & set(BENCHES)]


def test_a_page_has_one_word_for_all_transports_or_one_for_each_and_names_what_is_broken():
    first, second = BEHAVIOURS[:2]
    found = [result(), result(transport="pty"), result(row=second)]
    assert f"- {first.name}\n" in page((first, second), found, "make it")
    found = [result(), result(Verdict.BROKEN, "pty", "it moved")]
    shown = page((first,), found, "make it")
    assert f"| {first.name} | yes · NO |" in shown
    assert f"- {first.name} (teachmover, pty): it moved" in shown
    shown = page((first,), [result(Verdict.NOT_APPLICABLE, words="no such switch")], "make it")
    assert "- no such switch (teachmover)" in shown
