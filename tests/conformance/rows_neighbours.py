"""What another program of the same user may do to an arm that is held: watch, stop, pause, slow."""

from __future__ import annotations

import json
import subprocess
import sys
import threading

from armdrive.errors import Stopped

from .behaviour import Behaviour
from .going import begin_joints, begin_sweep, refused, sweep_plan
from .real_time_bench import ROOT, RealTimeBench
from .rows_conducting import RATE_S, SLOW, STANDS_S, slowed_enough, steps_made
from .rows_faults import between
from .rows_moving import arrived
from .rows_stopping import settled, under_way, within_bound
from .seen import check

HELD = ("pty", "tcp")
"""An arm in this process is held by nobody."""
ENDS_S = 30.0
SLOWLY = 0.15
"""A motion that outlasts the beginning of another program on a busy computer."""


def begin_command(bench: RealTimeBench, *words: str) -> subprocess.Popen[str]:
    """Begin a command of the command line about the arm on the bench."""
    where = ["--port", bench.port, "--dialect", bench.row.name]
    return subprocess.Popen(
        [sys.executable, "-m", "armdrive", *words, *where],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def command(bench: RealTimeBench, *words: str) -> None:
    """Give a command, and wait until that program has ended."""
    with begin_command(bench, *words) as program:
        told, _ = program.communicate(timeout=ENDS_S)
    check(program.returncode == 0, f"`armdrive {words[0]}` ended with: {told}")
    check("asked" in told, f"`armdrive {words[0]}` found no arm: {told}")


def another_program_pauses_and_resumes_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    _, goal, _ = sweep_plan(arm)
    handle = begin_sweep(arm, speed=SLOWLY)
    under_way(bench)
    status = arm.status
    command(bench, "pause")
    rest = bench.rest()
    time_s = status.silent_time_s + bench.noise_s
    check(rest.after_s <= time_s, f"paused, it went on for {rest.after_s:.3f} s, not {time_s:.3f}")
    stood = bench.stands(STANDS_S, "paused").motors
    check(arm.status.paused and not handle.done, "it was not paused on its way")
    command(bench, "resume")
    under_way(bench)
    for _ in range(20):
        between(bench.look(), stood, goal)
        bench.sleep(bench.look_s)
    arm.stop()
    settled(bench, arm)


def another_program_stops_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    handle = begin_sweep(arm, speed=SLOWLY)
    under_way(bench)
    status = arm.status
    command(bench, "stop")
    within_bound(bench, status, bench.rest(), "stopped by another program")
    refused(handle.wait, Stopped, "waiting for a motion that another program stopped")
    settled(bench, arm)


def another_program_slows_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    plan = sweep_plan(arm)
    command(bench, "slow", f"{SLOW:g}")
    check(arm.speed_override == SLOW, f"asked for {SLOW:.0%}, and it is {arm.speed_override:.0%}")
    begin_sweep(arm)
    under_way(bench)
    slowed_enough(steps_made(bench, RATE_S), plan)
    arm.stop()
    settled(bench, arm)


def another_program_watches_it(bench: RealTimeBench) -> None:
    arm = bench.ready()
    with begin_command(bench, "watch", "--json", "--every", "0.02") as program:
        end = threading.Timer(ENDS_S, program.kill)
        end.start()
        before = bench.look()
        seen = [program.stdout.readline()]
        bench.stands(STANDS_S, "watched")
        begin_joints(arm).wait()
        arrived(bench, arm)
        bench.leave()
        seen += program.stdout
        end.cancel()
    states = [json.loads(line)["state"] for line in seen if line]
    check(states[:1] == ["standby"], f"a watcher of a standing arm saw {states[:1]}")
    check("moving" in states, f"a watcher of a motion saw {states}")
    check(states[-1] == "disconnected", f"at the end a watcher saw {states[-1]}")
    check(program.returncode == 0, f"the watching program ended with {program.returncode}")
    check(before.motors != bench.look().motors, "nothing was there to be watched")


ROWS = (
    Behaviour("another program pauses and resumes it", "several programs",
              another_program_pauses_and_resumes_it, transports=HELD),
    Behaviour("another program stops it", "several programs", another_program_stops_it,
              transports=HELD),
    Behaviour("another program slows it", "several programs", another_program_slows_it,
              transports=HELD),
    Behaviour("another program watches it to the end", "several programs",
              another_program_watches_it, transports=HELD),
)  # fmt: skip
