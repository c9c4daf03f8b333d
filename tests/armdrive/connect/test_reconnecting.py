"""Reconnecting, at the same port or another."""

import math
import sys
import threading
from dataclasses import replace
from types import SimpleNamespace

import pytest
from amounts import amount
from faults import as_it_stands
from pages import page
from served import Served
from waiting import LONG_S, until

from armdrive import Arm, JointMove, LinkLost, WrongState
from armdrive.config.sections import Connection
from armdrive.connect import port as mending
from armdrive.connect.control_socket import answered
from armdrive.connect.parts import connect_simulated
from armdrive.connect.port import PAUSES_S, NewLink, PortOpening, Reconnector, lock_names
from armdrive.connect.target import find, simulated_config
from armdrive.errors import NoAnswer, NoSuchPort, NotReferenced, PortInUse, PortUnavailable
from armdrive.moves import Jog, Space
from armdrive.registry import DIALECTS, simulate
from armdrive.status import Current, State, Trust
from armdrive.transports import ports

RECONNECTS_S = 8.0
"""Longer than any pause between two tries and the resuming after it."""


@pytest.fixture
def connected():
    """Connect to simulated arms that are closed at the end."""
    arms = []

    def connect(dialect: str = "teachmover", **options) -> Arm:
        arm = Arm.connect(f"sim:{dialect}", **options)
        arms.append(arm)
        return as_it_stands(arm)

    yield connect
    for arm in arms:
        arm.close()


def unplug(arm: Arm) -> None:
    arm.twin.faults.add("unplug")
    arm.sleep(0.5)
    assert arm.status.state is State.DISCONNECTED


def replug(arm: Arm) -> None:
    arm.twin.faults.end()
    arm.twin.link.replug("elsewhere")


def replug_mute(arm: Arm) -> None:
    """Put the cable back into a device that says nothing."""
    arm.twin.faults.add("mute")
    arm.twin.link.replug()
    arm.twin.link.line.plug()


def lose_and_find(arm: Arm) -> None:
    unplug(arm)
    replug(arm)
    arm.sleep(RECONNECTS_S)


two_kinds = pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
"""A device that gets bursts and one that queues; conformance does the same for all dialects."""


@pytest.mark.parametrize(
    "dialect", amount(["grbl", "cia402"], ["teachmover", "grbl", "mks", "cia402"])
)
def test_an_arm_whose_wire_comes_back_allows_no_motion_before_error_stop(connected, dialect):
    arm = connected(dialect, reconnect=True)
    unplug(arm)
    replug(arm)
    states, until_s = {arm.status.state}, arm.status.time_s + RECONNECTS_S
    while arm.parts.pace.now_s() < until_s:
        arm.sleep(0.001)
        states.add(arm.parts.core.state)
        if arm.parts.core.state is State.ERROR_STOP:  # nothing but a person leaves it
            until_s = min(until_s, arm.parts.pace.now_s() + 1.0)
            arm.sleep(0.02)
    assert states == {State.DISCONNECTED, State.ERROR_STOP}


@two_kinds
@pytest.mark.parametrize(("port", "now"), [("elsewhere", ", now elsewhere at "), ("", ":")])
def test_a_reconnected_link_reports_a_new_port(connected, dialect, port, now):
    arm = connected(dialect, reconnect=True)
    unplug(arm)
    arm.sleep(3.0)
    assert (arm.status.error_code, arm.status.notice_code) == ("E407", "E403")
    arm.twin.faults.end()
    arm.twin.link.replug(port or None)
    arm.sleep(RECONNECTS_S)
    assert arm.status.error_code == "E409"
    assert port in arm.status.link
    assert arm.status.error.startswith(f"the connection was lost and is back{now}")


@two_kinds
@pytest.mark.parametrize("stop", [Arm.stop, Arm.estop])
@pytest.mark.parametrize("moving", amount([False], [False, True]))
def test_a_stop_that_cannot_reach_the_arm_does_not_end_well(connected, dialect, moving, stop):
    arm = connected(dialect, reconnect=True)
    arm.move_j(base_deg=80, wait=not moving)
    arm.twin.faults.add("unplug")
    arm.sleep(0.5)
    for _ in range(2):
        with pytest.raises(LinkLost, match=r"did not reach the arm .*its own switch"):
            stop(arm)
    replug(arm)
    arm.sleep(RECONNECTS_S)
    stop(arm)
    arm.close()
    stop(arm)


@two_kinds
@pytest.mark.parametrize("word", ["stop", "pause", "resume"])
def test_another_program_learns_that_its_request_did_not_reach_the_arm(connected, dialect, word):
    arm = connected(dialect)
    arm.twin.faults.add("unplug")
    arm.sleep(0.5)
    _, answers = answered(arm.parts.connection, {"request": word})
    assert f"the {word} did not reach the arm" in next(answers)["error"]
    assert (arm.parts.runner.stops > 0, arm.status.paused) == (
        word == "stop",
        word == "pause",
    )


@pytest.mark.parametrize("reconnect", [False, True])
def test_the_status_of_a_lost_arm_bounds_what_was_under_way(reconnect):
    config = simulated_config("teachmover")
    config = replace(config, motion=replace(config.motion, planned_burst_s=1.5))
    arm = as_it_stands(Arm(connect_simulated(config, reconnect=reconnect)))
    world = arm.twin.world
    idle_s = arm.status.silent_time_s
    arm.move_j(base_deg=80, wait=False)
    arm.sleep(0.2)
    moving = arm.status
    assert moving.silent_time_s > idle_s + 1.0
    arm.twin.link.unplug()
    arm.sleep(0.05)
    lost, tip = arm.status, world.tip
    assert lost.state is State.DISCONNECTED
    assert lost.silent_time_s == moving.silent_time_s
    assert lost.trust_code == "E716"
    arm.twin.link.line.advance(arm.parts.pace.now_s() + lost.silent_time_s)
    assert idle_s < math.dist(tip, world.tip) <= lost.silent_distance_mm
    arm.twin.link.replug()
    if reconnect:
        arm.sleep(RECONNECTS_S)
        assert arm.status.silent_time_s == idle_s
        assert arm.status.acknowledged == world.motors, "it was looked at when it stood"
        arm.twin.link.unplug()
        arm.sleep(1.0)
        assert (arm.status.state, arm.status.silent_time_s) == (State.DISCONNECTED, idle_s)
    arm.close()


def test_a_position_that_was_referenced_is_restored_and_wants_to_be_confirmed(connected):
    arm = connected(reconnect=True)
    arm.move_j(shoulder_deg=45)
    arm.io.write(1)
    joints = arm.joints
    lose_and_find(arm)
    assert (arm.status.current, arm.status.outputs) == (Current.UNKNOWN, None)
    arm.reset()
    assert arm.status.trust is Trust.RESTORED
    assert arm.status.trust_code == "E720"
    assert arm.joints == joints
    with pytest.raises(NotReferenced):
        arm.move_j(shoulder_deg=50)
    arm.reference.confirm_restored()
    assert arm.move_j(shoulder_deg=50)


def test_a_board_that_lost_its_power_meanwhile_is_suspect(connected):
    arm = connected(reconnect=True)
    arm.move_j(shoulder_deg=45)
    unplug(arm)
    arm.twin.faults.add("brown-out")
    arm.twin.link.line.advance(arm.parts.pace.now_s() + 1.0)
    replug(arm)
    arm.sleep(RECONNECTS_S)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.current is Current.UNKNOWN
    with pytest.raises(WrongState, match=r"error-stop: look at the arm, then call `reset\(\)`"):
        arm.move_j(shoulder_deg=50)  # `home` would be refused too
    arm.reset()
    with pytest.raises(NotReferenced, match=r"look at the arm, then call `home\(\)`"):
        arm.move_j(shoulder_deg=50)


@pytest.mark.parametrize(("board", "trust"), [("uno", Trust.SUSPECT), ("leonardo", Trust.RESTORED)])
def test_registers_of_zero_prove_nothing_if_reconnecting_may_have_reset_the_board(
    connected, board, trust
):
    twin = simulate(simulated_config("armdroid"), board=board)
    arm = connected("armdroid", twin=twin, reconnect=True)
    assert not arm.twin.board.registers.largest
    unplug(arm)
    arm.twin.board.opened()
    replug(arm)
    arm.sleep(RECONNECTS_S)
    assert arm.status.trust is trust


def test_reconnecting_goes_on_while_no_arm_answers(connected):
    arm = connected(reconnect=True)
    unplug(arm)
    replug_mute(arm)
    arm.sleep(20.0)
    assert arm.status.state is State.DISCONNECTED
    assert arm.status.notice_code == "E502"
    assert "but the arm is not ready" in arm.status.error
    assert "then call `reset()`" not in arm.status.error + arm.status.notice
    assert arm.parts.connection.reconnector.tries > 1
    arm.twin.faults.end()
    arm.sleep(RECONNECTS_S)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.notice == ""


def test_the_pauses_between_tries_grow(connected):
    arm = connected(reconnect=True)
    unplug(arm)
    arm.sleep(60.0)
    early = len(PAUSES_S)
    assert early < arm.parts.connection.reconnector.tries <= early + 60.0 / PAUSES_S[-1]


def test_an_arm_that_was_disabled_stays_disabled(connected):
    arm = connected(reconnect=True)
    arm.disable()
    lose_and_find(arm)
    assert arm.status.state is State.DISABLED
    assert arm.status.error == ""
    arm.enable()


def test_an_emergency_stop_outlives_the_loss(connected):
    arm = connected(reconnect=True)
    arm.estop()
    for _ in range(2):
        lose_and_find(arm)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.error_code == "E303"
    assert arm.status.error.count("Meanwhile the connection was lost") == 1
    assert arm.status.error.count("`reset()`") == 1


@pytest.mark.parametrize("disabled", [False, True])
def test_an_emergency_stop_without_a_wire_latches_once_it_is_back(connected, disabled):
    arm = connected(reconnect=True)
    if disabled:
        arm.disable()
    unplug(arm)
    with pytest.raises(LinkLost):
        arm.estop()
    arm.sleep(2.0)
    replug(arm)
    arm.sleep(RECONNECTS_S)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.error_code == "E303"


@pytest.mark.parametrize("fault", ["estop", "unplug"])
def test_a_jog_that_was_held_or_waited_is_forgotten(connected, fault):
    arm = connected(reconnect=True)
    jog = Jog(Space.JOINT, (("shoulder", 1.0),))
    arm.jogging.hold(jog, speed=0.5, for_s=1.0)
    arm.sleep(0.3)
    arm.jogging.nudge(Jog(Space.JOINT, (("shoulder", 5.0),)), speed=0.5)
    if fault == "estop":
        arm.estop()
    else:
        unplug(arm)
    assert arm.parts.core.nudges == []
    assert arm.parts.core.hold is None
    arm.jogging.nudge(jog, speed=0.5)
    arm.jogging.hold(jog, speed=0.5, for_s=1.0)
    if fault == "unplug":
        replug(arm)
    arm.sleep(RECONNECTS_S)
    stood = arm.twin.world.motors
    assert arm.parts.core.hold is None
    assert arm.parts.core.nudges == []
    arm.reset()
    arm.sleep(2.0)
    assert arm.twin.world.motors == stood


def test_a_manual_reconnect_tries_once(connected):
    arm = connected()
    with pytest.raises(WrongState, match="nothing to reconnect"):
        arm.reconnect()
    unplug(arm)
    arm.sleep(10.0)
    assert arm.parts.connection.reconnector.tries == 0  # nobody asked for it
    with pytest.raises(PortUnavailable, match="plug it in"):
        arm.reconnect()
    replug_mute(arm)
    with pytest.raises(NoAnswer, match="no answer"):
        arm.reconnect()
    assert arm.status.state is State.DISCONNECTED
    arm.twin.faults.end()
    arm.sleep(5.0)
    assert arm.status.state is State.DISCONNECTED
    arm.reconnect()
    assert arm.status.state is State.ERROR_STOP
    arm.reset()


def test_a_closed_arm_is_not_looked_for(connected):
    arm = connected(reconnect=True)
    unplug(arm)
    arm.close()
    with pytest.raises(WrongState, match="closed for good"):
        arm.reconnect()
    before = arm.parts.connection.reconnector.tries
    replug(arm)
    arm.parts.engine.advance(arm.parts.pace.now_s() + 100.0)
    assert arm.parts.connection.reconnector.tries == before


def test_a_wire_can_be_lost_again_and_again(connected):
    arm = connected(reconnect=True)
    said = set()
    for _ in range(3):
        lose_and_find(arm)
        assert arm.status.state is State.ERROR_STOP
        said.add((arm.status.error_code, arm.status.error.count("is back")))
    assert said == {("E409", 1)}
    arm.reset()
    arm.reference.confirm_restored()
    assert arm.move_j(shoulder_deg=50)


@pytest.mark.parametrize("dialect", amount(["robko01", "mks"], list(DIALECTS)))
def test_a_pulled_cable_is_seen_within_a_second_by_a_standing_arm(connected, dialect):
    arm = connected(dialect)
    arm.sleep(0.4)
    arm.twin.faults.add("unplug")
    arm.sleep(1.0)
    assert arm.status.state is State.DISCONNECTED


# -- how soon a silent arm is given up ------------------------------------------------------------

GIVEN_UP_AFTER_S = {
    "teachmover": 2.3,
    "armdroid": 2.4,
    "robko01": 3.4,
    "grbl": 1.7,
    "mks": 1.7,
    "cia402": 1.7,
}
"""From the first look that a standing arm does not answer."""


@pytest.mark.parametrize(
    ("dialect", "after_s"), [*((dialect, 2.0) for dialect in DIALECTS), ("teachmover", 2.6)]
)
def test_a_standing_arm_that_falls_silent_is_given_up_as_soon_as_the_page_says(dialect, after_s):
    with Arm.connect(f"sim:{dialect}") as arm:
        arm.sleep(after_s)
        arm.twin.faults.add("mute")
        arm.sleep(GIVEN_UP_AFTER_S[dialect] + arm.config.motion.idle_poll_s)
        assert arm.status.state is State.ERROR_STOP
        assert arm.status.error_code == "E502"


def test_the_page_tells_those_times():
    times = " | ".join(f"{time_s} s" for time_s in GIVEN_UP_AFTER_S.values())
    assert f"| at rest | {times} |" in page("sharing")


AFTER_A_LOSS = {
    "move_j": lambda arm: arm.move_j(base_deg=10),
    "preview": lambda arm: arm.run(arm.preview(JointMove({"base_deg": 10})).resolved),
    "jog_j": lambda arm: arm.jog_j(base_deg=1),
    "jog_l": lambda arm: arm.jog_l(x_mm=1),
    "move_motors": lambda arm: arm.move_motors(1, 0, 0, 0, 0, 0),
    "grasp": lambda arm: arm.gripper.grasp(),
    "home": lambda arm: arm.home(),
    "enable": lambda arm: arm.enable(),
    "disable": lambda arm: arm.disable(),
    "reset": lambda arm: arm.reset(),
    "io.set": lambda arm: arm.io.set(1),
    "io.read": lambda arm: arm.io.read(),
    "io.wait": lambda arm: arm.io.wait(high=1),
    "reference.confirm": lambda arm: arm.reference.confirm(),
    "controller.read_program": lambda arm: arm.controller.read_program(),
}


@pytest.mark.parametrize(
    ("dialect", "fault"),
    [("grbl", "unplug"), ("cia402", "mute"), *amount([], [("robko01", "mute"), ("mks", "unplug")])],
)
def test_an_arm_that_is_lost_in_motion_is_shown_where_it_was_last_seen(connected, dialect, fault):
    arm = connected(dialect)
    handle = arm.start(JointMove({"base_deg": 40.0}, speed=0.3))
    arm.sleep(1.0)
    arm.twin.faults.add(fault)
    seen = arm.joints
    while not handle.done:
        arm.sleep(0.001)
        if not handle.done:
            seen = arm.joints
    assert arm.joints == seen
    assert seen["base"] > math.radians(1.0)


def test_a_lost_link_takes_back_what_was_noted_about_a_motion(connected):
    arm = connected()
    arm.jog_j(shoulder_deg=90)
    assert "limit" in arm.status.notice
    unplug(arm)
    arm.sleep(20.0)
    assert arm.status.state is State.DISCONNECTED
    assert "limit" not in arm.status.notice


@pytest.mark.parametrize("moving", [False, True])
def test_every_call_after_a_loss_says_why_the_link_is_lost_and_what_to_do(connected, moving):
    arm = connected()
    arm.move_j(base_deg=80, wait=not moving)
    unplug(arm)
    assert arm.preview(JointMove({"base_deg": 10})).refusal is not None
    for call in AFTER_A_LOSS.values():
        with pytest.raises(LinkLost, match=r"unplugged\).*plug it in, then call `reconnect\(\)`"):
            call(arm)
    arm.close()
    for call in AFTER_A_LOSS.values():
        with pytest.raises(WrongState, match="closed for good: create a new one"):
            call(arm)


# -- Other ports -----------------------------------------------------------------------------------

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
NUMBER = "A50285BI"


@pytest.fixture
def plugged(monkeypatch):
    """USB adapters that this computer is made to believe in: name of the port to number."""
    adapters: dict[str, str] = {}

    def found():
        return [SimpleNamespace(device=name, serial_number=adapters[name]) for name in adapters]

    monkeypatch.setattr(ports, "_found", found)
    return adapters


class TestFinding:
    def test_an_adapter_is_found_under_any_name(self, plugged):
        plugged["/dev/ttyUSB7"] = NUMBER
        assert ports.device_of(NUMBER) == "/dev/ttyUSB7"
        assert ports.device_of(NUMBER, "/dev/ttyUSB0") == "/dev/ttyUSB7"
        assert ports.serial_number_of("/dev/ttyUSB7") == NUMBER
        assert ports.serial_number_of("/dev/ttyUSB0") == ""

    def test_an_adapter_that_is_not_there_is_named_with_those_that_are(self, plugged):
        plugged["/dev/ttyUSB7"] = "OTHER"
        plugged["/dev/ttyS0"] = None
        with pytest.raises(NoSuchPort, match=rf"{NUMBER} \(present: OTHER \(/dev/ttyUSB7\)\)"):
            ports.device_of(NUMBER)
        plugged.clear()
        with pytest.raises(NoSuchPort, match="none with a number"):
            ports.device_of(NUMBER)

    def test_adapters_with_the_same_number_need_a_port_name(self, plugged):
        plugged["/dev/ttyUSB1"] = plugged["/dev/ttyUSB2"] = NUMBER
        assert ports.device_of(NUMBER, "/dev/ttyUSB2") == "/dev/ttyUSB2"
        with pytest.raises(NoSuchPort, match="/dev/ttyUSB1 and /dev/ttyUSB2"):
            ports.device_of(NUMBER, "/dev/ttyUSB0")

    def test_a_name_that_udev_has_made_is_kept_while_it_leads_there(self, plugged, tmp_path):
        device, link = tmp_path / "ttyUSB0", tmp_path / "by-id"
        device.touch()
        link.symlink_to(device)
        plugged[str(device)] = NUMBER
        assert ports.serial_number_of(str(link)) == NUMBER
        assert ports.device_of(NUMBER, str(link)) == str(link)

    def test_an_arm_file_may_give_the_number_alone(self, plugged):
        config = find("/dev/ttyUSB0", dialect_name="teachmover").config
        config = replace(config, connection=Connection("teachmover", usb_serial=NUMBER))
        wiring = PortOpening(config)
        with pytest.raises(NoSuchPort):
            wiring.open()
        assert lock_names(config) == (config.name,)  # whoever holds it can be reached
        plugged["/dev/no-such-port"] = NUMBER
        assert wiring.find() == "/dev/no-such-port"
        with pytest.raises(PortUnavailable, match="/dev/no-such-port"):
            wiring.open()
        with pytest.raises(PortUnavailable, match="usb_serial"):
            PortOpening(replace(config, connection=Connection("teachmover")))


def moving(arm, there):
    """Begin a motion and wait until the arm itself moves."""
    arm.reference.declare(arm.model.arm.ik(arm.model.reference.pose))
    handle = arm.move_j(shoulder_deg=70, wait=False)
    start = there.device.world.motors
    until(lambda: there.device.world.motors != start)
    return handle


@needs_pty
class TestPty:
    def test_an_adapter_comes_back_under_another_name(self, plugged, tmp_path):
        first, second = tmp_path / "first", tmp_path / "second"
        with Served("teachmover", pty=first) as arm_there:
            plugged[str(first)] = NUMBER
            arm = Arm.connect(str(first), dialect="teachmover", reconnect=True)
            handle = moving(arm, arm_there)
            arm_there.tell("unplug")
            plugged.clear()
            until(lambda: arm.status.state is State.DISCONNECTED)
            with pytest.raises(LinkLost):
                handle.wait()
            # another adapter takes the old name: it is not ours
            with Served("armdroid", pty=first):
                plugged[str(first)] = "OTHER"
                until(lambda: "OTHER" in arm.status.notice)
                assert arm.status.state is State.DISCONNECTED
                plugged[str(second)] = NUMBER
                arm_there.tell(f"replug as {second}")
                until(lambda: arm.status.state is State.ERROR_STOP)
            assert str(second) in arm.status.link
            assert arm.status.trust is Trust.SUSPECT
            arm.close()

    def test_a_port_without_a_number_comes_back_under_its_own_name(self, tmp_path):
        path = tmp_path / "arm"
        with Served("teachmover", pty=path) as there:
            with Arm.connect(str(path), dialect="teachmover", reconnect=True) as arm:
                thread = arm.parts.pace._thread
                there.tell("unplug")
                until(lambda: arm.status.state is State.DISCONNECTED)
                there.tell("replug")
                until(lambda: arm.status.state is State.ERROR_STOP)
                arm.reset()
                assert arm.status.state is State.STANDBY
                assert arm.io.read() is not None
            assert not thread.is_alive()

    def test_an_arm_that_is_looked_for_can_be_closed(self, tmp_path):
        path = tmp_path / "arm"
        with Served("teachmover", pty=path) as there:
            arm = Arm.connect(str(path), dialect="teachmover", reconnect=True)
            thread = arm.parts.pace._thread
            there.tell("unplug")
            until(lambda: arm.parts.connection.reconnector.tries > 0)
            arm.close()
            assert not thread.is_alive()
            there.tell("replug")
            Arm.connect(str(path), dialect="teachmover").close()  # the port was given back


@pytest.mark.parametrize("motion", amount([True], [False, True]), ids=str)
def test_a_lost_network_connection_is_seen(motion):
    with Served("teachmover", tcp="0") as there:
        arm = Arm.connect(there.port, dialect="teachmover")
        if motion:
            moving(arm, there)
        there.tell("unplug")
        until(lambda: arm.status.state is State.DISCONNECTED)
        arm.close()


@needs_pty
def test_a_lost_wire_is_seen_in_error_stop_too(tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as there:
        arm = Arm.connect(there.port, dialect="teachmover")
        arm.estop()
        there.tell("unplug")
        until(lambda: arm.status.state is State.DISCONNECTED)
        arm.close()


def test_a_network_host_that_closed_its_port_is_seen_at_the_next_look():
    with Served("robko01", udp="0") as there:
        arm = Arm.connect(there.port, dialect="robko01")
        arm.enable()
        assert arm.config.motion.idle_poll_s < 1.0
        there.tell("unplug")
        until(lambda: arm.status.state is State.DISCONNECTED)
        arm.close()


# -- the old wire lets its port go first ----------------------------------------------------------


class OneHolder:
    """A port that one wire at a time can have; a wire is slow to let it go."""

    description = "can:slcan:/dev/ttyACM0"

    def __init__(self) -> None:
        self.asked_for, self.may_close, self.tried = (threading.Event() for _ in range(3))
        self.held = True

    def close(self) -> None:
        self.may_close.wait(LONG_S)
        self.held = False

    def open_again(self):
        if self.held:
            raise PortInUse("in use by another program or by this one")
        raise LinkLost("free, but nobody is there")

    def woken(self) -> None:
        self.tried.set()


@pytest.fixture
def port():
    held = OneHolder()
    yield held
    held.may_close.set()


def looking(port):
    """Return who looks for a wire that was lost a moment ago, and has begun to."""
    engine = SimpleNamespace(link=port)
    core = SimpleNamespace(notify=lambda *_words: None)
    context = SimpleNamespace(engine=engine, core=core, now_s=0.0)
    reconnector = Reconnector(context, NewLink(port.open_again, in_thread=True))
    reconnector.lost(0.0)
    engine.link = SimpleNamespace(wake=port.woken)
    reconnector.ask(0.0)
    reconnector(0.0)
    return reconnector


def test_reconnecting_waits_until_the_old_link_has_released_its_port(port):
    reconnector = looking(port)
    assert not port.tried.wait(0.05)
    port.may_close.set()
    assert port.tried.wait(LONG_S)
    reconnector(0.0)
    assert reconnector.tries == 1
    assert "nobody is there" in str(reconnector.trouble)


def test_the_wait_for_an_old_link_to_release_its_port_has_a_limit(port, monkeypatch):
    monkeypatch.setattr(mending, "LET_GO_S", 0.01)
    reconnector = looking(port)
    assert port.tried.wait(LONG_S)
    reconnector(0.0)
    assert isinstance(reconnector.trouble, PortInUse)


@pytest.mark.parametrize("opened_before", [False, True])
def test_a_link_that_was_opened_for_a_closed_arm_is_closed(port, opened_before):
    closed = threading.Event()
    port.open_again = lambda: SimpleNamespace(close=closed.set)
    reconnector = looking(port)
    if opened_before:
        port.may_close.set()
        assert port.tried.wait(LONG_S)
        assert not closed.is_set()
    reconnector.close()
    port.may_close.set()
    assert closed.wait(LONG_S)
