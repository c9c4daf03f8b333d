"""Stop bounds that are broken, or inflated: announced half as long, or five times too long.

Each of the four figures is scaled where all dialects share it, and in each dialect's derivation.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from .mutant import Mutant

WORST_CASE = (
    "tests/bounds/test_bounds.py::test_the_worst_case_keeps_its_bound_and_reaches_half_of_it"
)
SCALES = {
    5.0: ("five times too long", "no bound is inflated: the worst case reaches half of it"),
    0.5: ("half as long", "no announced bound is broken"),
}
TIME, WAY = "the time of a stop", "the way of a stop"
SILENT_TIME, SILENT_WAY = "the time of a program that dies", "the way of a program that dies"
FIGURES = (TIME, WAY, SILENT_TIME, SILENT_WAY)

STOPS = ("stop, planned", "emergency stop, planned", "release of a held jog, jog")
SILENCES = ("killed host, planned", "pulled cable, planned", "pause, planned")
ROWS = {
    "mks": {
        "stop, planned": ("stop, upwards",),
        "killed host, planned": ("killed host, upwards",),
        "pulled cable, planned": ("pulled cable, upwards",),
        "pause, planned": ("pause, upwards",),
    },
    "grbl": {
        "killed host, planned": ("killed host, planned0", "killed host, planned1"),
    },
}
"""How the rows of these dialects are named where they are not named as the others'."""


@dataclass(frozen=True, slots=True)
class Derivation:
    """Where a file says the four figures of `FIGURES`: as arguments, in their order.

    `begin` stands before the first of them, so that the place is found only once.
    """

    path: str
    figures: tuple[str, str, str, str]
    begin: str = "return Stopping("
    between: str = ", "

    def scaled(self, figure: int, scale: float) -> tuple[str, str]:
        """Return the code as it is, and with one figure scaled."""
        scaled = list(self.figures)
        scaled[figure] = f"{scale} * ({scaled[figure]})"
        return tuple(f"{self.begin}{self.between.join(each)}" for each in (self.figures, scaled))


LINES = {"begin": "return Stopping(\n            ", "between": ",\n            "}
SHARED = Derivation(
    "armdrive/runtime/stop_bounds.py",
    ("self.time_s", "asked_mm", "self.silent_time_s", "silent_mm"),
    "return StopBound(",
)
BURSTS = ("stands_s", "motion_s", "stands_s", "motion_s")
DERIVATIONS = {
    "teachmover": Derivation("armdrive/dialects/controller.py", BURSTS),
    "robko01": Derivation("armdrive/dialects/robko01/controller.py", BURSTS),
    "armdroid": Derivation("armdrive/dialects/controller.py", BURSTS),
    "grbl": Derivation(
        "armdrive/dialects/grbl/planner.py",
        (
            "max(stands_s, heard_s + KILLED_S)",
            "heard_s + held_way_s + brakes_s / 2.0",
            "burst_s + wire_s + held_s + brakes_s + LAST_STEP_S",
            "burst_s + wire_s + held_way_s",
        ),
        **LINES,
    ),
    "mks": Derivation(
        "armdrive/dialects/mks/controller.py",
        ("begun_s + brakes_s", "asked[0]", "silent_s + brakes_s + HOST_DELAY_S", "silent[0]"),
        **LINES,
    ),
    "cia402": Derivation(
        "armdrive/dialects/cia402/controller.py",
        (
            "begun_s + ramp_s",
            "begun_s + ramp_s / 2.0",
            "silent_s + ramp_s",
            "silent_s + ramp_s / 2.0",
        ),
        **LINES,
    ),
}


def _tests_of(dialect: str, what: str) -> tuple[str, ...]:
    rows = STOPS if what in (TIME, WAY) else SILENCES
    named = [name for row in rows for name in ROWS.get(dialect, {}).get(row, (row,))]
    return tuple(f"{WORST_CASE}[{dialect}, {name}]" for name in named)


def _shared() -> Iterator[Mutant]:
    for figure, what in enumerate(FIGURES):
        tests = _tests_of("teachmover", what)  # the quickest to simulate
        for scale, (how, promise) in SCALES.items():
            old, new = SHARED.scaled(figure, scale)
            yield Mutant(f"{what} is announced {how}", promise, SHARED.path, old, new, tests)


def _of_each_dialect() -> Iterator[Mutant]:
    for dialect, derivation in DERIVATIONS.items():
        for figure, what in enumerate(FIGURES):
            tests = _tests_of(dialect, what)
            for scale, (how, promise) in SCALES.items():
                old, new = derivation.scaled(figure, scale)
                name = f"{dialect} derives {what} {how}"
                yield Mutant(name, promise, derivation.path, old, new, tests)


MUTANTS = (*_shared(), *_of_each_dialect())
