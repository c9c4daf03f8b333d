"""Every dialect of the table keeps every behaviour: on simulated time all, over a pty a handful."""

from __future__ import annotations

import re
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest
from amounts import THOROUGH
from waiting import LONG_S

from armdrive.connect.target import state_file
from armdrive.errors import DeviceFault
from armdrive.registry import DIALECTS

from .behaviour import Behaviour
from .bench import Bench
from .expected_errors import EXPECTED_ERRORS, MOVING, STANDING
from .faults import FAULTS
from .memory_bench import VARIANTS, MemoryBench, ThoroughMemoryBench, Variant
from .real_time_bench import PortBench, PtyBench
from .rows_faults import survives_in_motion, survives_while_idle
from .running import BEHAVIOURS
from .seen import Broken

SIMULATED = list(DIALECTS)
needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
of_all = pytest.mark.parametrize("behaviour", BEHAVIOURS, ids=lambda row: row.name)


def expects_error(behaviour: Behaviour, dialect: str) -> bool:
    """Return whether a row of a fault says which error it ends in."""
    if not isinstance(behaviour.run, partial):
        return False
    moment = STANDING if behaviour.run.func is survives_while_idle else MOVING
    return (dialect, behaviour.run.keywords["fault"].name, moment) in EXPECTED_ERRORS


def tried(behaviour: Behaviour, dialect: str) -> bool:
    """Return whether a row is tried on a dialect today.

    Those that expect an error are; of the two rows of any other fault, one is, in turn.
    """
    if THOROUGH or not isinstance(behaviour.run, partial):
        return True
    fault, standing = behaviour.run.keywords["fault"], behaviour.run.func is survives_while_idle
    if expects_error(behaviour, dialect):
        return True
    turn = FAULTS.index(fault) + SIMULATED.index(dialect)
    return not fault.idle or turn % 2 == standing


in_process = pytest.mark.parametrize(
    ("behaviour", "dialect"),
    [
        pytest.param(row, dialect, id=f"{row.name}-{dialect}")
        for row in BEHAVIOURS
        if row.meant_for("memory")
        for dialect in SIMULATED
        if tried(row, dialect)
    ],
)


def run(behaviour: Behaviour, bench: Bench) -> None:
    """Run a row, or skip it with the reason why this arm cannot have it."""
    why = behaviour.lacking(bench)
    if why:
        pytest.skip(why)
    behaviour.run(bench)


@in_process
def test_on_simulated_time(behaviour, dialect):
    """A fault meets one dialect in motion and the next one standing, and comes at one moment.

    So does a stop, whose bounds `tests/bounds` holds at their worst moments every day. All moments,
    and more, with THOROUGH=1 in the environment, and by `python -m tests.conformance`.
    """
    with ThoroughMemoryBench(dialect) if THOROUGH else MemoryBench(dialect) as bench:
        if not THOROUGH:
            turn = (BEHAVIOURS.index(behaviour) + SIMULATED.index(dialect)) // 2
            if expects_error(behaviour, dialect):
                turn = -1  # well under way
            bench.moments_s = bench.moments_s[turn % len(bench.moments_s) :][:1]
            bench.stops_after_s = bench.stops_after_s[turn % len(bench.stops_after_s) :][:1]
        run(behaviour, bench)


def held_against(row: Behaviour, variant: Variant) -> bool:
    """Return whether a row is tried on a variant today: where that is unlike the dialect's arm.

    Of the faults whose errors are known, every second one strikes drives that are sent bursts.
    """
    if not row.meant_for("memory") or not tried(row, variant.dialect):
        return False
    if THOROUGH or not variant.differs:
        return True
    if row.family == "fault" and isinstance(row.run, partial):
        moving = row.run.func is survives_in_motion and expects_error(row, variant.dialect)
        if not moving or FAULTS.index(row.run.keywords["fault"]) % 2:
            return False
    return row.family in variant.differs


@pytest.mark.parametrize(
    ("variant", "behaviour"),
    [
        pytest.param(variant, row, id=f"{variant.name}: {row.name}")
        for variant in VARIANTS
        for row in BEHAVIOURS
        if held_against(row, variant)
    ],
)
def test_on_a_variant(variant, behaviour):
    with MemoryBench(variant.dialect, variant) as bench:
        bench.moments_s = bench.moments_s[-1:]
        try:
            run(behaviour, bench)
        except (Broken, DeviceFault) as error:
            if not re.search(r"`\$H[XYZABC]`: error 3, .* not known or not supported", str(error)):
                raise
            pytest.skip("this build homes all axes at once, not one after another")


@needs_pty
def test_a_handful_over_a_pty():
    """All dialects side by side, one process each: nearly all of it is waiting in real time.

    Bounds on times are held on simulated time, and here by `python -m tests.conformance` on a
    computer that has nothing else to do.
    """
    with ThreadPoolExecutor(len(SIMULATED)) as pool:
        broken = [words for found in pool.map(handful, SIMULATED) for words in found]
    assert not broken, "\n".join(broken)


class UnhurriedPtyBench(PtyBench):
    """Over a pty on a computer that may be busy."""

    punctual = False
    look_s = 0.02  # each look is answered by a process of its own, and no bound depends on it

    def watch(self, done, longest_s):
        """Look until `done()`; a limit ends a hang, and is no bound."""
        return super().watch(done, max(longest_s, LONG_S))


UNHURRIED = {"cia402": "[cia402]\nheartbeat_ms = 2000\nperiod_ms = 40\n"}
"""Settings without which real drives rightly stop where their program is kept from its work."""


ATTEMPTS = 4
"""How often a row may end in a fault over a pty.

The drives there are a process of their own. Where a busy computer keeps it from its work, they were
gone, and the driver is right to say so. What is really broken is broken each time.
"""


def handful(dialect: str) -> list[str]:
    """Run the rows for every day on one bench; return what was broken."""
    left = [row for row in BEHAVIOURS if row.smoke]
    for _ in range(ATTEMPTS):
        broken, left = attempted(dialect, left)
        if not left:
            break
    return broken


def attempted(dialect: str, rows: list[Behaviour]) -> tuple[list[str], list[Behaviour]]:
    """Run rows on one bench; return what was broken, in words and as rows."""
    words, broken = [], []
    with UnhurriedPtyBench(dialect) as bench:
        if dialect in UNHURRIED:
            bench.fit(UNHURRIED[dialect])
        state_file(bench.config.name).unlink(missing_ok=True)  # an earlier attempt's
        for behaviour in (row for row in rows if not row.lacking(bench)):
            try:
                behaviour.run(bench)
                bench.leave()
            except Exception as error:
                words.append(f"{dialect}: {behaviour.name}: {error}")
                broken.append(behaviour)
    return words, broken


@pytest.fixture(scope="session")
def one_home(tmp_path_factory):
    """What one row records of a real arm, the next one takes up."""
    return tmp_path_factory.mktemp("arm")


@pytest.mark.hardware
@of_all
def test_on_a_real_arm(behaviour, arm_port, arm_dialect, one_home, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(one_home))
    with PortBench(arm_dialect, arm_port) as bench:
        run(behaviour, bench)


def test_no_two_behaviours_share_a_name():
    names = [row.name for row in BEHAVIOURS]
    assert len(set(names)) == len(names)
