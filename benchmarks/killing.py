"""A jogging program is killed outright: how long the simulated arm in another process goes on."""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from measuring import Row, Section, p99
from sim_process import SimProcess

from armdrive.holder import ask_holder

SEED = 1982
JOG_S = 20.0
HOST = (
    "import sys\n"
    "from armdrive import Arm\n"
    "with Arm.connect(sys.argv[1], dialect='teachmover') as arm:\n"
    "    arm.confirm_reference()\n"
    f"    arm.jog_j(base=float(sys.argv[2]), speed=1.0, duration_s={JOG_S})\n"
)


def kill_once(sim: SimProcess, direction: float, after_s: float) -> tuple[float, float]:
    """Jog, kill, and return the seconds to stand-still and the announced bound."""
    with subprocess.Popen([sys.executable, "-c", HOST, sim.port, str(direction)]) as host:
        try:
            sim.wait_until_moving()
            announced_s = float(ask_holder(sim.port, "status")["stop_time_s"])
            time.sleep(after_s)
        finally:
            killed_s = time.monotonic()
            host.kill()
        return sim.rest_after_s(killed_s), announced_s


def killing(kills: int = 10) -> Section:
    """Kill at random moments of a burst."""
    chance = random.Random(SEED)
    with tempfile.TemporaryDirectory() as folder, SimProcess(Path(folder) / "arm") as sim:
        found = [
            kill_once(sim, (-1.0) ** index, chance.uniform(0.2, 0.5)) for index in range(kills)
        ]
    rests, bounds = [rest_s for rest_s, _ in found], [bound_s for _, bound_s in found]
    shares = {"the announced bound": max(rests) / max(bounds)}
    rows = (
        Row("announced: status.stop_time_s", max(bounds) * 1e3, "ms"),
        Row("SIGKILL to stand-still", median(rests) * 1e3, "ms", p99(rests) * 1e3),
        Row("the worst of them", max(rests) * 1e3, "ms", times=shares),
    )
    return Section(
        "Killed in mid-jog",
        rows,
        f"{kills} kills of a program that jogs the base at full speed; seen every few ms at the "
        "physical motors",
    )
