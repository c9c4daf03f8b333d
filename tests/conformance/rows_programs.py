"""What other programs of the same user may do to an arm in use: watch, stop, pause and slow it."""

import json
import subprocess
import sys
import threading

from armdrive.errors import Stopped

from .behaviour import row, rows_of
from .motions import begin_joints, begin_sweep, check_refused, sweep_plan
from .observation import check
from .real_time_bench import ROOT, RealTimeBench
from .rows_faults import check_between
from .rows_moving import check_arrived
from .rows_pausing import RATE_S, SLOW, STANDS_S, check_slowed, step_rate_hz
from .rows_stopping import check_settled, check_within_bound, sweeping

LOCKED = ("pty", "tcp")
"""The transports on which the driver locks the arm; in the same process it does not."""
ENDS_S = 30.0
SLOWLY = 0.15
"""At this speed a motion is still under way when another program has started."""


def start_command(bench: RealTimeBench, *words: str) -> subprocess.Popen[str]:
    """Start an `armdrive` command for the arm on the bench."""
    where = ["--port", bench.port, "--dialect", bench.row.name]
    return subprocess.Popen(
        [sys.executable, "-m", "armdrive", *words, *where],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def run_command(bench: RealTimeBench, *words: str) -> None:
    """Run an `armdrive` command, and check that it succeeded."""
    with start_command(bench, *words) as program:
        output, _ = program.communicate(timeout=ENDS_S)
    check(program.returncode == 0, f"`armdrive {words[0]}` ended with: {output}")
    check("asked" in output, f"`armdrive {words[0]}` found no arm: {output}")


@row("another program pauses and resumes it", "several programs", transports=LOCKED)
def another_program_pauses_and_resumes_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    _, goal, _ = sweep_plan(arm)
    handle = begin_sweep(arm, speed=SLOWLY)
    bench.wait_until_moving()
    status = arm.status
    run_command(bench, "pause")
    rest = bench.rest()
    check_within_bound(bench, status, rest, "paused by another program", silent=True)
    stood = bench.check_stands(STANDS_S, "paused").motors
    check(arm.status.paused and not handle.done, "it was not paused on its way")
    run_command(bench, "resume")
    bench.wait_until_moving()
    for _ in range(20):
        check_between(bench.look(), stood, goal)
        bench.sleep(bench.look_s)
    arm.stop()
    check_settled(bench, arm)


@row("another program stops it", "several programs", transports=LOCKED)
def another_program_stops_it(bench: RealTimeBench) -> None:
    arm, handle = sweeping(bench, SLOWLY)
    status = arm.status
    run_command(bench, "stop")
    check_within_bound(bench, status, bench.rest(), "stopped by another program")
    check_refused(handle.wait, Stopped, "waiting for a motion that another program stopped")
    check_settled(bench, arm)


@row("another program slows it", "several programs", transports=LOCKED)
def another_program_slows_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    plan = sweep_plan(arm)
    run_command(bench, "slow", f"{SLOW:g}")
    check(arm.speed_override == SLOW, f"asked for {SLOW:.0%}, and it is {arm.speed_override:.0%}")
    begin_sweep(arm)
    bench.wait_until_moving()
    check_slowed(step_rate_hz(bench, RATE_S), plan)
    arm.stop()
    check_settled(bench, arm)


@row("another program watches it to the end", "several programs", transports=LOCKED)
def another_program_watches_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    with start_command(bench, "watch", "--json", "--every", "0.02") as program:
        end = threading.Timer(ENDS_S, program.kill)
        end.start()
        before = bench.look()
        seen = [program.stdout.readline()]
        bench.check_stands(STANDS_S, "watched")
        begin_joints(arm).wait()
        check_arrived(bench, arm)
        bench.disconnect()
        seen += program.stdout
        end.cancel()
    states = [json.loads(line)["state"] for line in seen if line]
    check(states[:1] == ["standby"], f"a watcher of a standing arm saw {states[:1]}")
    check("moving" in states, f"a watcher of a motion saw {states}")
    check(states[-1] == "disconnected", f"at the end a watcher saw {states[-1]}")
    check(program.returncode == 0, f"the watching program ended with {program.returncode}")
    check(before.motors != bench.look().motors, "the arm did not move while it was watched")


ROWS = rows_of(globals())
