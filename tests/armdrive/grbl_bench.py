"""A simulated GRBL board on a simulated wire: send lines, let time pass, read the replies."""

import math
from dataclasses import replace
from functools import partial

from armdrive.config.sections import GripperSettings
from armdrive.connect.target import simulated_config
from armdrive.registry import simulate
from armdrive.sim.mechanics.motors import LimitSwitch
from armdrive.sim.wire import DeviceLine, MemoryLink
from firmware_protocol.grbl import Banner, StatusReport
from firmware_protocol.grbl.answers import decode_answer

BAUD = 115_200
PER_UNIT = 10.0
SLOPE = 500.0
AXES = 6
MACHINE = {
    **{100 + axis: PER_UNIT for axis in range(AXES)},
    **{110 + axis: 6000.0 for axis in range(AXES)},
    **{120 + axis: SLOPE for axis in range(AXES)},
    **{130 + axis: 200.0 for axis in range(AXES)},
    11: 0.01,
}
"""The settings of the measured board: units of ten steps, 500 units/s^2."""
HOMING = {**MACHINE, 22: 1, 24: 25, 25: 3000, 26: 250, 27: 1}


def config_of(kind="stepper", **device):
    """Return the configuration of the board's arm, with a kind of gripper."""
    config = simulated_config("grbl")
    model = config.model
    if kind != "stepper":
        model = replace(model, transmission=model.transmission.without_gripper())
    return replace(
        config,
        model=model,
        gripper=GripperSettings(kind=kind),
        device=replace(config.device, **device),
    )


class Bench:
    """`heard` has every line that the board has sent, and `reports` the status reports."""

    def __init__(self, values=MACHINE, *, baud=BAUD, config=None, saved=None, **options):
        config = config or config_of()
        self.device = simulate(config, saved, **options).device
        self.board = self.device.board
        self.board.settings.values.update(values)
        self.board.drive.rack.limits = self.board.settings.limits()
        if not saved:
            self.device.world.energised = self.board.settings.motors_stay_on
        self.link = MemoryLink(DeviceLine(self.device, baud), "simulated arm")
        self.now_s = 0.0
        self.heard: list[str] = []
        self.reports: list[StatusReport] = []
        self.rest = b""
        self.wait(0.05)

    @property
    def banners(self):
        found = (decode_answer(one.encode()) for one in self.heard if one.startswith(("G", "g")))
        return [one for one in found if isinstance(one, Banner)]

    def put(self, data):
        """Send bytes."""
        self.link.write(data if isinstance(data, bytes) else data.encode("latin-1"), self.now_s)

    def wait(self, seconds):
        """Let time pass; return the lines that arrived."""
        self.now_s += seconds
        *lines, self.rest = (self.rest + self.link.read(self.now_s)).split(b"\r\n")
        said = [line.decode() for line in lines if line]
        self.heard += said
        found = (decode_answer(line.encode()) for line in said if line.startswith("<"))
        self.reports += [one for one in found if isinstance(one, StatusReport)]
        return said

    def say(self, text, seconds=0.05):
        """Send a line or a real-time command, and let time pass; return the lines that arrived."""
        self.put(text if len(text) == 1 else text + "\n")
        return self.wait(seconds)

    def ask(self):
        """Request a status report, and return it; None without one."""
        before = len(self.reports)
        self.put("?")
        for _ in range(100):
            self.wait(0.001)
            if len(self.reports) > before:
                return self.reports[-1]
        return None

    @property
    def x(self):
        """The board's position of its first axis."""
        return self.board.drive.counts[0] / PER_UNIT

    def finish(self):
        """Let time pass until no event is left; return all lines."""
        while (due_s := self.link.next_s()) < math.inf:
            self.now_s = max(self.now_s, due_s)
            self.wait(0.0)
            assert self.now_s < 1e4
        return self.heard


def stands_at(bench, motor):
    return bench.device.world.motors[motor]


def with_switches_ahead(bench, units=100.0):
    """Put every limit switch some units ahead of its motor."""
    motors = bench.device.world.motors
    found = {
        n: LimitSwitch(partial(stands_at, bench, n), count + round(units * 10))
        for n, count in enumerate(motors)
    }
    bench.board.switches.by_axis = found
    bench.board.limits.forget(bench.board)
    return bench


def homing_bench(values=HOMING, **options):
    """Return a board that can home, on an arm without mechanical stops."""
    bench = with_switches_ahead(Bench(values, **options))
    stops = bench.device.world.body.stops
    bench.device.world._stops = [replace(one, low_rad=-99.0, high_rad=99.0) for one in stops]
    return bench
