"""Every call ends: on endless, dripping and mute wires, and when nothing ever comes."""

import contextlib
import math
import random
import re
from collections.abc import Callable
from dataclasses import replace

import pytest
from amounts import amount, in_pairs
from faults import as_it_stands, ready_arm, standing

from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialects.controller import HOMING_MARGIN_S
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.errors import ArmError, DeviceFault, NoAnswer, Refused, WrongState
from armdrive.moves import Jog
from armdrive.programs import running
from armdrive.programs.acts import Say
from armdrive.programs.running import Performer
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime import overrides
from armdrive.runtime.clock import RealPace, SimulatedClock, SimulatedPace
from armdrive.runtime.engine import CALL_LIMIT_S, LAST_STEPS, Engine, call_limit_s
from armdrive.runtime.overrides import NAPS
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.status import Current, State
from armdrive.tasks import ReadPosition, RequestRejected, SleepUntil
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame, Unpacker, pack

EVERY_S = 0.01
"""A flood comes in pieces of so long, as an operating system hands it over."""
DRIP_S = 0.12
"""A byte each: shorter than the silence that a reset waits for."""
JUST_BEFORE_S = 0.001

HEARTBEATS = b"".join(pack(Frame(0x700 + node, b"\x7f")) for node in (1, 2, 3, 4, 5, 6, 99))
IRRELEVANT = {
    "teachmover": b"0\r",
    "armdroid": b"Welcome, Armdroid!\r\n",
    "grbl": b"<Idle|MPos:0.000,0.000,0.000,0.000,0.000,0.000|FS:0,0>\r\n",
    "mks": HEARTBEATS,
    "cia402": HEARTBEATS,
}
"""What a device of the dialect may say, or others on its bus, and what answers nothing."""


def noise(dialect: str, size: int) -> bytes:
    """Return bytes of noise; on a bus, frames of ids that no drive here has."""
    draw = random.Random(size)
    if not DIALECTS[dialect].can:
        return draw.randbytes(size)
    return b"".join(pack(Frame(draw.randrange(0x10, 0x7F), draw.randbytes(8))) for _ in range(5))


class Wire(Link):
    """A link to a simulated arm that behaves until `spoil` puts another wire in its place."""

    description = "the wire"

    def __init__(self, twin: SimulatedArm) -> None:
        self.engine: Engine | None = None
        self.twin = twin
        self.now: Link = twin.link
        self.closed = False
        self.spoil_at = b""
        self.kind = ""

    def spoil(self, kind: str | None) -> None:
        """Make it a wire of a kind from now on; None makes it a good one again."""
        self.now = self.twin.link if kind is None else KINDS[kind](self)

    def write(self, data: bytes, now_s: float) -> None:
        self.now.write(data, now_s)
        if self.spoil_at and self.spoil_at in data:
            self.spoil(self.kind)

    def read(self, now_s: float) -> bytes:
        return self.now.read(now_s)

    def next_s(self) -> float:
        return self.now.next_s()

    def wait(self, timeout_s: float) -> None:
        self.now.wait(timeout_s)

    def wake(self) -> None:
        self.now.wake()

    def close(self) -> None:
        self.closed = True
        self.now.close()


class Talker(Link):
    """A wire on which pieces come at regular times, whatever is sent."""

    description = "a talker"

    def __init__(self, piece: Callable[[int], bytes], every_s: float) -> None:
        self._piece, self._every_s = piece, every_s
        self._count, self._due_s = 0, -math.inf

    def write(self, data: bytes, now_s: float) -> None:
        """Lose it."""

    def read(self, now_s: float) -> bytes:
        if now_s < self._due_s:
            return b""
        self._due_s = now_s + self._every_s
        self._count += 1
        return self._piece(self._count)

    def next_s(self) -> float:
        return self._due_s


class Dilatory(Link):
    """A wire to the true device, each of whose answers comes just before it would be late."""

    description = "a slow device"

    def __init__(self, wire: Wire) -> None:
        self._wire, self._link = wire, wire.twin.link
        self._held, self._due_s = b"", math.inf

    def write(self, data: bytes, now_s: float) -> None:
        self._link.write(data, now_s)

    def read(self, now_s: float) -> bytes:
        if said := self._link.read(now_s):
            self._held += said
            assert self._wire.engine is not None
            late_s = self._wire.engine.controller.next_s()
            self._due_s = now_s if math.isinf(late_s) else max(now_s, late_s - JUST_BEFORE_S)
        if now_s < self._due_s:
            return b""
        held, self._held, self._due_s = self._held, b"", math.inf
        return held

    def next_s(self) -> float:
        return min(self._link.next_s(), self._due_s)

    def close(self) -> None:
        self._link.close()


def _flood(wire: Wire) -> Talker:
    dialect = wire.twin.dialect
    size = max(int(DIALECTS[dialect].baud / 10 * EVERY_S), 1)
    return Talker(lambda count: noise(dialect, size + count % 3), EVERY_S)


def _irrelevant(wire: Wire) -> Talker:
    return Talker(lambda _: IRRELEVANT.get(wire.twin.dialect, b"\r\n"), EVERY_S)


def _drip(wire: Wire) -> Talker:
    heard = noise(wire.twin.dialect, 997)
    if DIALECTS[wire.twin.dialect].can:
        frames = [pack(each) for each in Unpacker().feed(heard)]
        return Talker(lambda count: frames[count % len(frames)], DRIP_S)
    return Talker(lambda count: heard[count % 997 : count % 997 + 1], DRIP_S)


KINDS: dict[str, Callable[[Wire], Link]] = {
    "silent": lambda _: Talker(lambda _: b"", 1e9),
    "flooding with noise": _flood,
    "flooding with what answers nothing": _irrelevant,
    "dripping": _drip,
    "answering at the last moment": Dilatory,
}


class Pace(SimulatedPace):
    """Simulated time that shows the wire who is driven."""

    def __init__(self, wire: Wire) -> None:
        super().__init__()
        self.wire = wire

    def start(self, engine: Engine) -> None:
        self.wire.engine = engine
        super().start(engine)


def wire_to(dialect: str) -> tuple[Wire, Pace]:
    """Return a wire to a simulated arm of a dialect, and the time in which it is."""
    wire = Wire(simulate(simulated_config(dialect)))
    return wire, Pace(wire)


def connected(dialect: str, wire: Wire, pace: Pace) -> Arm:
    """Connect over a wire, as it is."""
    arm = Arm(
        assemble(simulated_config(dialect), wire, pace, simulated=True, operator=wire.twin.operator)
    )
    arm.twin = wire.twin
    return arm


THREE = amount(["teachmover", "grbl", "cia402"], list(DIALECTS))
"""Devices that answer with a byte, with lines and with frames."""

AFTER_S = 3.0
"""What has been waited for in a motion before its look is answered by nobody: a few exchanges."""
FOUND = re.compile(r"within (\d+\.\d) s on ")


def ready(dialect: str) -> tuple[Arm, Pace]:
    """Return an arm in standby whose position is known, on a wire that behaves."""
    wire, pace = wire_to(dialect)
    return as_it_stands(connected(dialect, wire, pace)), pace


def latched(arm: Arm) -> None:
    arm.estop()
    arm.sleep(1.0)


def switched_off(arm: Arm) -> None:
    if arm.abilities.current.name != "NONE":
        arm.disable()


CALLS_ON_ENDLESS_WIRES = {
    "reset": (latched, lambda arm: arm.reset(), 0.0),
    "enable": (switched_off, lambda arm: arm.enable(), 0.0),
    "look": (lambda _: None, lambda arm: arm.io.read(), 0.0),
    "outputs": (lambda _: None, lambda arm: arm.io.write(1), 0.0),
    "move": (lambda _: None, lambda arm: arm.move_j(base_deg=5.0), AFTER_S),
    "home": (lambda _: None, lambda arm: arm.home(), AFTER_S),
    "close": (lambda _: None, lambda arm: arm.close(), 0.0),
}
"""What comes before a call, the call, and how much longer than its limit it may take."""


def told(error: ArmError, took_s: float) -> None:
    """Check that a silence tells the time that it really took."""
    found = FOUND.search(str(error))
    assert found, str(error)
    assert float(found[1]) == pytest.approx(took_s, abs=0.06)
    assert not re.search(r"[\x00-\x1f\x7f-\x9f]", str(error))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("dialect", THREE)
def test_connecting_ends_on_time(dialect, kind):
    wire, pace = wire_to(dialect)
    wire.spoil(kind)
    if kind == "answering at the last moment":
        assert call_limit_s(simulated_config(dialect).device) == CALL_LIMIT_S
        connected(dialect, wire, pace)
        assert pace.now_s() < CALL_LIMIT_S / 2.0
    else:
        with pytest.raises(NoAnswer, match="connect again") as silence:
            connected(dialect, wire, pace)
        told(silence.value, pace.now_s())
        assert "reset()" not in str(silence.value)
        assert wire.closed
        if kind == "silent" and not DIALECTS[dialect].can:
            assert "Check that the arm is switched on and its cable plugged in" in str(
                silence.value
            )
    assert pace.now_s() <= CALL_LIMIT_S + 0.05


@in_pairs("dialect, call, kind", THREE, list(CALLS_ON_ENDLESS_WIRES), list(KINDS))
def test_a_call_ends_on_time_and_the_arm_comes_back(dialect, kind, call):
    before, act, longer_s = CALLS_ON_ENDLESS_WIRES[call]
    arm, pace = ready(dialect)
    before(arm)
    pace.wire.spoil(kind)
    began_s = pace.now_s()
    slow = kind == "answering at the last moment"
    try:
        act(arm)
    except NoAnswer as error:
        if not longer_s:
            told(error, pace.now_s() - began_s)
        if arm.status.error_code == error.code:
            assert arm.status.current is Current.UNKNOWN
    except (DeviceFault, Refused):
        pass
    if not (slow and call == "home"):  # its operator jogs for long, and each of it ends
        assert pace.now_s() - began_s <= CALL_LIMIT_S + longer_s + 0.05
    pace.wire.spoil(None)
    if call != "close" and not comes_back(arm):  # the wire's lies were believed until a motion
        assert comes_back(arm)


def comes_back(arm: Arm) -> bool:
    """Tell whether an arm whose wire is good again can be reset, enabled and moved."""
    arm.sleep(3.0)
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    as_it_stands(arm)
    assert arm.status.state is State.STANDBY
    try:
        arm.move_j(base_deg=arm.joints.deg["base"] + 3.0)
    except DeviceFault:
        return False
    assert arm.status.acknowledged == arm.twin.world.motors
    return True


def test_a_background_poll_times_out_without_using_the_next_calls_time():
    arm, pace = ready("teachmover")
    pace.wire.spoil("dripping")
    arm.sleep(1.0)
    assert arm.parts.engine.busy
    began_s = pace.now_s()
    with pytest.raises(ArmError):
        arm.io.read()
    assert pace.now_s() - began_s <= CALL_LIMIT_S + 0.05
    assert arm.status.state is State.ERROR_STOP
    began_s = pace.now_s()
    with pytest.raises(ArmError):  # no answer to what was given up keeps the next call waiting
        arm.reset()
    assert pace.now_s() - began_s <= CALL_LIMIT_S + 0.05


def test_time_in_which_the_motion_of_another_call_is_waited_for_does_not_count():
    arm, pace = ready("teachmover")
    handle = arm.move_j(base_deg=80.0, speed=0.1, wait=False)
    arm.sleep(0.5)
    began_s = pace.now_s()
    arm.io.read()
    assert pace.now_s() - began_s > CALL_LIMIT_S
    assert handle.done
    assert arm.joints.deg["base"] == pytest.approx(80.0, abs=0.1)


def test_a_suspension_does_not_count_towards_a_devices_timeout():
    arm, pace = ready("teachmover")
    pace.wire.spoil("dripping")
    task = arm.parts.runner.submit(arm_look(arm), within_s=CALL_LIMIT_S)
    pace.wait(lambda: task.done, 10.0)
    arm.parts.engine.suspended(60.0)
    pace.wait(lambda: task.done, 0.0)
    assert task.until_s == pytest.approx(60.0 + CALL_LIMIT_S, abs=1.0)


def arm_look(arm: Arm):
    yield from arm.parts.context.look()


def test_an_arm_file_that_has_its_device_waited_for_longer_gets_more_time():
    settings = GrblSettings()
    assert call_limit_s(settings) == CALL_LIMIT_S
    assert call_limit_s(replace(settings, boot_s=3.0 * settings.boot_s)) == 3.0 * CALL_LIMIT_S
    assert call_limit_s(replace(settings, boot_s=0.5)) == CALL_LIMIT_S


@pytest.mark.parametrize("kind", ["silent", "flooding with noise", "dripping"])
def test_homing_by_switches_ends_on_time(kind):
    wire, pace = wire_to("grbl")
    config = simulated_config("grbl")
    joints = config.model.arm.ik(config.model.reference.pose)
    device = replace(config.device, homing_s=20.0)
    config = replace(config, homing=HomingSettings(joints=joints), device=device)
    arm = Arm(assemble(config, wire, pace, simulated=True, operator=wire.twin.operator))
    arm.enable()
    arm.parts.core.controller.searches_s = (None,) * 6  # the board does not report its speeds
    wire.spoil_at, wire.kind = b"$H", kind
    began_s = pace.now_s()
    with pytest.raises(DeviceFault, match=r"not ended after 3\d s; the device does not report"):
        arm.home()
    assert pace.now_s() - began_s <= device.homing_s + HOMING_MARGIN_S + CALL_LIMIT_S


# -- Waits that nothing ends -----------------------------------------------------------------------

LONGEST_WAIT_S = 3700.0
"""A pendant's program may be read for as long; nothing else comes near it."""


class SimulatedRealPace(RealPace):
    """What the driver takes for real time, and what passes as simulated time without a thread."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = SimulatedClock()
        self.lock = self.clock.lock
        self.waits: list[float] = []

    def now_s(self) -> float:
        return self.clock.now_s

    def start(self, engine: Engine) -> None:
        self._engine = engine
        self.clock.add(engine)

    def wait(self, done, timeout_s):
        self.waits.append(timeout_s)
        end_s = self.clock.now_s + timeout_s
        return self.clock.wait(done, end_s, lambda: self._engine is not None)

    def wake(self) -> None:
        """Nothing sleeps."""

    def close(self) -> None:
        engine, self._engine = self._engine, None
        if engine is not None:
            self.clock.remove(engine)


CALLS = {
    "move_j": lambda arm: arm.move_j(base_deg=3.0),
    "move_to": lambda arm: arm.move_to(arm.pose),
    "move_l": lambda arm: arm.move_l(arm.pose),
    "move_motors": lambda arm: arm.move_motors(*[5] * arm.abilities.motors),
    "park": lambda arm: arm.park(),
    "jog_j": lambda arm: arm.jog_j(base_deg=1.0),
    "jog_j for a time": lambda arm: arm.jog_j(base=1.0, duration_s=0.5),
    "jog_l": lambda arm: arm.jog_l(z_mm=1.0),
    "hold": lambda arm: arm.jogging.hold(Jog.joint(base=1.0), speed=0.3, for_s=0.5),
    "handle": lambda arm: arm.move_j(base_deg=2.0, wait=False).wait(),
    "cancel": lambda arm: arm.move_j(base_deg=9.0, wait=False).cancel(),
    "gripper": lambda arm: arm.gripper.open(15.0),
    "grasp": lambda arm: arm.gripper.grasp(),
    "home": lambda arm: arm.home(),
    "verify": lambda arm: arm.reference.verify(operator=arm.operator),
    "reference.confirm": lambda arm: arm.reference.confirm(),
    "io.read": lambda arm: arm.io.read(),
    "io.write": lambda arm: arm.io.write(1),
    "io.wait": lambda arm: arm.io.wait(high=7, within_s=1.0),
    "sleep": lambda arm: arm.sleep(1.0),
    "stop": lambda arm: arm.stop(),
    "estop": lambda arm: arm.estop(),
    "reset": lambda arm: arm.reset(),
    "reconnect": lambda arm: arm.twin.link.unplug() or arm.sleep(1.0) or arm.reconnect(),
    "disable": lambda arm: arm.disable(),
    "enable": lambda arm: arm.enable(),
    "controller.read_program": lambda arm: arm.controller.read_program(),
    "close": lambda arm: arm.close(),
}


def referenced(pace) -> Arm:
    return as_it_stands(Arm(connect_simulated(simulated_config("teachmover"), pace=pace)))


@pytest.fixture
def noted(monkeypatch):
    """Return a connected arm, and its pace, which notes how long it is waited for."""
    made = SimulatedRealPace()
    monkeypatch.setattr("armdrive.connect.parts.pace_of", lambda _: made)
    with contextlib.closing(referenced(None)) as arm:
        yield arm, made


@pytest.mark.parametrize("call", CALLS)
def test_every_wait_of_a_call_has_an_end(noted, call):
    arm, pace = noted
    pace.waits.clear()
    with contextlib.suppress(ArmError):
        CALLS[call](arm)
    assert pace.waits or call in ("hold", "estop")
    assert all(math.isfinite(each) and each <= LONGEST_WAIT_S for each in pace.waits)


def test_only_a_wait_for_an_input_without_a_deadline_is_for_as_long_as_that_takes(noted):
    arm, pace = noted
    arm.twin.device.at(pace.now_s() + 30.0, arm.request_stop)
    pace.waits.clear()
    with pytest.raises(ArmError, match="stop"):
        arm.io.wait(high=7)
    assert pace.waits == [math.inf]
    assert pace.now_s() >= 30.0


def test_a_pause_in_real_time_costs_a_waiting_call_nothing(noted):
    arm, pace = noted
    arm.pause()
    arm.twin.device.at(pace.now_s() + 400.0, arm.resume)
    handle = arm.move_j(base_deg=5.0, wait=False)
    handle._timeout_s = 5.0  # the looks at a paused arm, counted as its patience, were 14 s
    handle.wait()
    assert arm.joints.deg["base"] == pytest.approx(5.0, abs=0.1)
    assert pace.now_s() > 400.0


def test_an_endless_pause_in_real_time_gives_up_the_motion_and_stays_paused(monkeypatch, noted):
    monkeypatch.setattr(overrides, "LONGEST_PAUSE_S", 300.0)
    arm, pace = noted
    arm.pause()
    began_s, stood = pace.now_s(), arm.twin.world.motors
    with pytest.raises(WrongState, match=r"paused for 300 s.*`resume\(\)`.*`armdrive resume`"):
        arm.move_j(base_deg=5.0)
    assert pace.now_s() - began_s == pytest.approx(300.0, abs=2.0)
    assert arm.status.paused
    assert arm.status.state is State.STANDBY
    assert arm.twin.world.motors == stood
    arm.resume()
    arm.move_j(base_deg=5.0)


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
def test_a_pause_on_simulated_time_that_cannot_end_does_not_hang(monkeypatch, dialect):
    breaths = []
    monkeypatch.setattr(overrides, "LONGEST_SIMULATED_WAIT_S", 60.0)
    monkeypatch.setattr("armdrive.runtime.overrides.time.sleep", breaths.append)
    arm = standing(dialect)
    handle = arm.move_j(base_deg=30.0, wait=False)
    arm.sleep(0.5)
    arm.pause()
    arm.sleep(2.0)
    stood, began_s = arm.twin.world.motors, arm.parts.pace.now_s()
    with pytest.raises(WrongState, match="still paused"):
        handle.wait()
    assert arm.parts.pace.now_s() - began_s == pytest.approx(60.0, abs=3.0)
    assert len(breaths) == NAPS
    assert arm.status.paused
    assert arm.twin.world.motors == stood
    arm.resume()
    arm.move_j(base_deg=30.0)


def test_a_program_that_paused_its_own_arm_does_not_hang(monkeypatch):
    slept = []
    monkeypatch.setattr(running.time, "sleep", slept.append)
    arm = Arm.connect("sim:teachmover")
    arm.pause()
    with pytest.raises(WrongState, match="still paused"):
        Performer(arm, None).perform(Say("on"))
    assert sum(slept) == pytest.approx(5.0, abs=0.05)


# -- tasks that never wait ------------------------------------------------------------------------


def restless(now_s):
    while True:
        yield SleepUntil(now_s)


def test_a_task_that_loops_without_waiting_is_ended():
    arm = ready_arm()
    with pytest.raises(ArmError, match="without waiting"):
        run_blocking(arm.parts.runner.perform(restless(arm.parts.pace.now_s() - 1.0)))
    assert arm.move_j(base_deg=2).joints.deg["base"] == pytest.approx(2.0, abs=0.05)


def stubborn(raised):
    while True:
        try:
            yield SleepUntil(math.inf)
        except NoAnswer as error:
            raised.append(error)


def test_a_task_that_goes_on_after_its_time_is_ended():
    arm, raised = ready_arm(), []
    with pytest.raises(NoAnswer, match=r"within 1\.0 s"):
        run_blocking(arm.parts.runner.perform(stubborn(raised), 1.0))
    assert len(raised) == LAST_STEPS
    assert arm.move_j(base_deg=2).joints.deg["base"] == pytest.approx(2.0, abs=0.05)


def test_a_drivers_script_that_loops_without_waiting_is_ended():
    controller = ready_arm().parts.core.controller
    controller.script = lambda _request: restless_script()
    controller.begin(ReadPosition(), 0.0)
    controller.advance(0.0)
    assert isinstance(controller.next_event(), RequestRejected)
    assert not controller.busy


def restless_script():
    while True:
        yield -1.0
