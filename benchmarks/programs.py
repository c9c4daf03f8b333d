"""What programs cost: `python benchmarks/programs.py [SECTION ...] [--json]`.

Calls a second of the Python API on simulated time, each beside a floor; the same moves as Python
calls, as a program file and through the async twin; and `armdrive run` on an empty program beside
a bare interpreter.
"""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from measuring import Row, Section, command, interleaved, own_home, ratio, report, timing

from armdrive import Arm, AsyncArm, Pose, PoseMove
from armdrive.programs.program import ArmProgram, read_program
from armdrive.programs.rehearsal import UnattendedPerson
from armdrive.programs.running import Performer, ProgramRun, RunPlan

NEAR, FAR = (
    Pose.of(x_mm=240, y_mm=-40, z_mm=120, pitch_deg=-90),
    Pose.of(x_mm=240, y_mm=40, z_mm=120, pitch_deg=-90),
)
"""The two ends of the line that everything here draws."""


@contextmanager
def ready() -> Iterator[Arm]:
    """Connect to a simulated TeachMover, referenced, at one end of the line."""
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        arm.move_to(NEAR)
        yield arm


def calls(rounds: int = 15, times: int = 20) -> Section:
    """Measure single calls, and what each cannot do without."""
    with ready() as arm:
        joints = arm.joints
        solve = arm.model.arm.fk
        ends = (NEAR, FAR)

        def alternating(call: Callable[[Pose], object]) -> Callable[[], None]:
            def work() -> None:
                for index in range(times):
                    call(ends[(index + 1) % 2])

            return work

        cases: dict[str, Callable[[], None]] = {
            "one forward solution": alternating(lambda _: solve(joints)),
            "arm.status": alternating(lambda _: arm.status),
            "arm.pose": alternating(lambda _: arm.pose),
            "arm.preview(pose), and nothing sent": alternating(
                lambda pose: arm.preview(PoseMove(pose))
            ),
            "arm.move_j(base_deg=...)": alternating(
                lambda pose: arm.move_j(base_deg=9.0 if pose is FAR else -9.0)
            ),
            "arm.move_to(pose)": alternating(arm.move_to),
            "arm.move_l(pose), 80 mm": alternating(arm.move_l),
            "arm.gripper.open(mm)": alternating(
                lambda pose: arm.gripper.open(30.0 if pose is FAR else 40.0)
            ),
        }
        taken = interleaved(cases, rounds)
    floor = taken["one forward solution"]
    return Section(
        "Calls of the Python API, on simulated time",
        tuple(
            Row(
                name,
                times / median(seconds),
                "calls/s",
                None,
                {}
                if seconds is floor
                else {"the time of a forward solution": ratio(seconds, floor)},
            )
            for name, seconds in taken.items()
        ),
        f"{rounds} rounds of {times} calls each, in turn, on one simulated TeachMover in process",
    )


def ways(rounds: int = 15, times: int = 20) -> Section:
    """Measure the same lines written in three ways."""
    text = "\n".join(
        [
            "point near = at(240, -40, 120, -90)",
            "point far = at(240, 40, 120, -90)",
            f"repeat {times // 2}",
            "  move_line far",
            "  move_line near",
            "end",
        ]
    )
    program = read_program(text, "lines.arm")
    with ready() as arm, asyncio.Runner() as runner:
        twin = runner.run(_readied())

        def by_calls() -> None:
            for _ in range(times // 2):
                arm.move_l(FAR)
                arm.move_l(NEAR)

        def by_program() -> None:
            ProgramRun(
                RunPlan(ArmProgram(program, arm.config).machine), Performer(arm, UnattendedPerson())
            ).carry_out()

        async def lines() -> None:
            for _ in range(times // 2):
                await twin.move_l(FAR)
                await twin.move_l(NEAR)

        taken = interleaved(
            {
                "Python calls": by_calls,
                "a program file": by_program,
                "the async twin": lambda: runner.run(lines()),
            },
            rounds,
        )
        runner.run(twin.close())
    floor = taken["Python calls"]
    return Section(
        "The same straight lines, written in three ways",
        tuple(
            timing(
                name,
                seconds,
                "ms a line",
                per=times,
                beside={} if seconds is floor else {"Python calls": floor},
            )
            for name, seconds in taken.items()
        ),
        f"{rounds} rounds of {times} lines of 80 mm each, in turn, on simulated time",
    )


async def _readied() -> AsyncArm:
    arm = await AsyncArm.connect("sim:teachmover")
    await arm.home()
    await arm.move_to(NEAR)
    return arm


def starting(rounds: int = 20) -> Section:
    """Run an empty program from the command line."""
    bare = "a bare interpreter"
    with own_home() as folder:
        empty = {".arm": folder / "empty.arm", ".py": folder / "empty.py"}
        for path in empty.values():
            path.write_text("", encoding="utf-8")
        cases = {bare: [sys.executable, "-c", "pass"]} | {
            f"armdrive run empty{kind}": [*command(), "run", str(path), "--sim", "teachmover"]
            for kind, path in empty.items()
        }
        taken = interleaved({name: _started(words) for name, words in cases.items()}, rounds)
    return Section(
        "From the command to the end of an empty program",
        tuple(
            timing(name, seconds, beside={} if name == bare else {bare: taken[bare]})
            for name, seconds in taken.items()
        ),
        f"{rounds} runs each, in turn; as {' '.join([Path(command()[0]).name, *command()[1:]])}",
    )


def _started(words: list[str]) -> Callable[[], object]:
    return lambda: subprocess.run(words, check=True, capture_output=True)


SECTIONS = {"calls": calls, "ways": ways, "starting": starting}


def main(argv: list[str] | None = None) -> int:
    """Measure all sections, or those that are asked for."""
    return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
