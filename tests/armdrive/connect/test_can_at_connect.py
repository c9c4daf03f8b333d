"""Problems at connecting to drives on a bus: each is reported, nothing moves, and it can be fixed.

Every row is of an arm that this program has not seen yet, and some are of one that it has moved,
behind a wire that was lost. Each ends in the same program, where the arm moves.
"""

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest
from amounts import amount
from can_fault_bench import SETTLED_S, Bus, check_works_again
from served import Served
from waiting import at_last

from armdrive import Arm
from armdrive.errors import ArmError, DeviceFault, LinkLost, NoAnswer, PortInUse, SettingsDiffer
from armdrive.sim.cia402.objects import varied
from armdrive.status import State, Trust
from firmware_protocol import mks
from firmware_protocol.canopen import DEVICE_TYPE, Nmt, NmtCommand

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")

LOST, NO, SILENT, DIFFERS, LOCKED, BACK = "E407", "E501", "E502", "E206", "E506", "E409"
ELBOW = 2
"""The motor whose drive is tampered with, counted from 0."""
BUS = "power.*120 ohm.*ids and bit rate match the arm file"
PLUG = r"drive 3 \(elbow\) does not answer, while others.*power.*plug.*bit rate.*arm file"


def flashed(*settings, drives=(ELBOW,)):
    """Return what sets MKS drives up as somebody else might, and what sets them right again."""

    def spoil(bus: Bus) -> Callable[[], None]:
        nodes = [bus.twin.board.nodes[each] for each in drives]
        before = [[node.flash.of(type(each)) for each in settings] for node in nodes]

        def put(*many) -> None:
            for node, some in zip(nodes, many, strict=True):
                for each in some:
                    node.flash.put(each)
                node.remake()

        put(*[settings] * len(nodes))
        return lambda: put(*before)

    return spoil


def given(*faults: str):
    """Return what gives an arm faults of the simulator, and what ends them."""

    def spoil(bus: Bus) -> Callable[[], None]:
        bus.fault(*faults)
        return bus.twin.faults.end

    return spoil


def another(*lacking: int, **objects: int):
    """Return what puts another CiA 402 drive into the elbow, and the right one back."""

    def spoil(bus: Bus) -> Callable[[], None]:
        node = bus.twin.board.nodes[ELBOW]
        right = node.objects.dictionary

        def put(dictionary) -> None:
            node.objects.dictionary = node.pdos._dictionary = dictionary
            node.objects.renew(node.number)
            bus.twin.board.reset_drive(ELBOW)

        changed = {DEVICE_TYPE: objects["kind"]} if objects else {}
        put(varied(frozenset(lacking), changed, ()))
        return lambda: put(right)

    return spoil


@dataclass(frozen=True)
class Row:
    """A fault: how it comes, its code, words for what it is and for what is to be done."""

    dialect: str
    spoil: Callable[[Bus], Callable[[], None]]
    code: str
    words: str
    late: bool = False
    """Whether it is found when the motors are to be switched on."""
    options: dict = field(default_factory=dict)
    notice: str = ""
    notice_code: str = DIFFERS


def both(name: str, spoil, code: str, words: str) -> dict[str, Row]:
    """Return the rows of a fault that drives of either kind can have."""
    return {f"{each}: {name}": Row(each, spoil, code, words) for each in ("mks", "cia402")}


OLD = "1.0.4"
"""Firmware that tells nothing of how it is set up: it is found out by an order."""
TWO_IDS = "more than one drive answers to the {} 2: .*give each"
NOTHING = r"no answer to `(READ ENCODER|SDO 1000)`.*" + BUS
ROWS: dict[str, Row] = {
    **both("nobody acknowledges", given("alone"), SILENT, NOTHING),
    **both("the adapter has left the bus", given("bus-off"), LOST, "bus-off.*resistor.*bit rate"),
    **both("no drive has power", given(*(f"drive-dead {each}" for each in range(1, 7))), SILENT,
           NOTHING),
    **both("a drive is missing", given("drive-dead 3"), NO, PLUG),
    "mks: a drive says nothing": Row("mks", given("drive-mute 3"), NO, PLUG),
    **both("a drive has another id", given("drive-id 3 33"), NO, PLUG),
    "mks: two drives have one id, so that one is missing": Row(
        "mks", given("drive-id 3 2"), NO, f"{PLUG}.*And {TWO_IDS.format('id')}"),
    "cia402: two drives have one id, so that one is missing": Row(
        "cia402", given("drive-id 3 2"), NO, f"^(device fault: )?{TWO_IDS.format('node number')}"),
    "mks: all drives have another bit rate": Row(
        "mks", flashed(mks.SetBitrate(mks.Bitrate.K250), drives=range(6)), SILENT, NOTHING),
    "mks: a drive has another bit rate": Row(
        "mks", flashed(mks.SetBitrate(mks.Bitrate.K250)), NO, PLUG),
    "mks: a drive waits for pulses": Row(
        "mks", flashed(mks.SetMode(mks.Mode.PULSE_FOC)), NO,
        r"drive 3 \(elbow\) is in mode 2.*set mode 5.*SR_vFOC.*doctor --fix", late=True,
        notice=r"mode of drive 3 \(elbow\) is 2.*expected 5.*`3: 82 05`"),
    "mks: a drive of old firmware waits for pulses": Row(
        "mks", flashed(mks.SetMode(mks.Mode.PULSE_FOC)), NO,
        r"drive 3 \(elbow\) refused ENABLE.*mode.*set.*SR_vFOC", late=True,
        options={"firmware": OLD}),
    "mks: a drive does not reply": Row(
        "mks", flashed(mks.SetReplies(mks.ReplyMode.NONE)), NO,
        r"drive 3 \(elbow\) answers queries, but does not confirm.*are off.*--fix", late=True,
        notice=r"replies of drive 3 \(elbow\) is none, expected full.*`3: 8c 01 01`"),
    "mks: a drive of old firmware does not reply": Row(
        "mks", flashed(mks.SetReplies(mks.ReplyMode.NONE)), NO,
        r"drive 3 \(elbow\) answers queries, but does not confirm.*replies are off.*8C", late=True,
        options={"firmware": OLD}),
    "cia402: a node is no drive": Row(
        "cia402", another(kind=401), NO,
        r"drive 3 \(elbow\) reports.*profile 401, not a drive of CiA 402: check the ids.*doctor"),
    "cia402: a node does not tell what it is": Row(
        "cia402", another(0x1000), NO,
        r"drive 3 \(elbow\) refused object 1000:00.*not a CANopen device: check the ids"),
    "cia402: a drive has no interpolation time": Row(
        "cia402", another(0x60C2), NO,
        r'drive 3 \(elbow\) refused object 60C2:01 Interp.*no such object.*strategy = "profile"'),
    "cia402: a drive cannot tell its position": Row(
        "cia402", another(0x6064), NO,
        r"drive 3 \(elbow\) refused object 1A00:03 .*\(6064:00 Position.*newer firmware"),
    "cia402: a drive takes no target": Row(
        "cia402", another(0x607A), NO,
        r"drive 3 \(elbow\) refused object 1600:03 .*\(607A:00 Target.*newer firmware"),
    "cia402: a drive is in fault": Row(
        "cia402", given("drive-fault 3 4310"), NO,
        r"drive 3 \(elbow\) is in fault.*too hot \(error 4310\).*(clears that|clear the cause)",
        late=True, notice=r"drive 3 \(elbow\) is in fault.*error 4310", notice_code=LOCKED),
}  # fmt: skip


COMES_BACK = (
    "mks: no drive has power",
    "mks: two drives have one id, so that one is missing",
    "mks: a drive waits for pulses",
    "mks: a drive does not reply",
    "cia402: nobody acknowledges",
    "cia402: a drive is missing",
    "cia402: a node is no drive",
    "cia402: a drive is in fault",
)
"""Of each kind of fault, one that is met by an arm that comes back."""


def refused(call, row: Row) -> None:
    """Check that a call fails as a row says, in words for a person."""
    with pytest.raises(ArmError) as failed:
        call()
    assert failed.value.code == row.code, failed.value
    assert re.search(row.words, str(failed.value)), failed.value
    assert not re.search("``|garbled|Traceback", str(failed.value))


def switch_on(arm: Arm) -> None:
    """Leave an error, and have the motors switched on, as a person does."""
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    arm.enable()


def is_not_switched_on(arm: Arm, row: Row) -> None:
    """Check an arm that is there, and whose motors cannot be switched on."""
    assert re.search(row.notice, arm.status.notice), arm.status.notice
    refused(lambda: switch_on(arm), row)
    assert arm.status.state in (State.ERROR_STOP, State.DISABLED)
    if arm.status.error_code != BACK:  # a reset that failed leaves what was latched before
        assert arm.status.error_code == row.code
        assert re.search(row.words, arm.status.error), arm.status.error


def sends_motion(bus: Bus, row: Row) -> bool:
    """Tell whether anything was sent that switches a motor on, or moves it, and need not be.

    Only the silence to an order shows that a drive confirms none.
    """
    shown_by_order = bus.options.get("firmware") == OLD or "does not confirm" in row.words
    return bool(bus.motion_frames) and not shown_by_order


@pytest.mark.parametrize("name", ROWS)
def test_a_wrong_setting_is_reported_at_connecting_and_the_arm_moves_once_it_is_right(name):
    row = ROWS[name]
    bus = Bus(row.dialect, options=row.options)
    fix = row.spoil(bus)
    bus.settle()
    stood = bus.motors
    if row.late:
        arm = bus.connect()
        assert arm.status.notice_code == (row.notice_code if row.notice else "")
        is_not_switched_on(arm, row)
        assert arm.status.trust is Trust.UNKNOWN
    else:
        refused(bus.connect, row)
    assert bus.motors == stood
    assert not sends_motion(bus, row)
    fix()
    bus.settle()
    arm = arm if row.late else bus.connect()
    assert bus.motors == stood
    check_works_again(arm, stood)


@pytest.mark.parametrize("name", amount(COMES_BACK[2::2], COMES_BACK))
def test_a_wrong_setting_is_reported_at_reconnecting_and_the_arm_moves_once_it_is_right(name):
    row = ROWS[name]
    bus = Bus(row.dialect, options=row.options)
    arm = bus.ready()
    bus.twin.faults.add("unplug")
    arm.sleep(SETTLED_S)
    assert arm.status.state is State.DISCONNECTED
    bus.settle()  # drives live on behind a pulled cable
    bus.sent.clear()
    fix = row.spoil(bus)
    bus.settle()
    stood = bus.motors
    bus.twin.link.replug()
    if row.late:
        arm.reconnect()
        assert not bus.motion_frames
        is_not_switched_on(arm, row)
    else:
        refused(arm.reconnect, row)
        assert not bus.motion_frames
        assert arm.status.state is State.DISCONNECTED
        assert arm.status.error_code == LOST
    assert bus.motors == stood
    fix()
    bus.settle()
    if not row.late:
        arm.reconnect()
    assert arm.status.trust in (Trust.RESTORED, Trust.SUSPECT)
    check_works_again(arm, stood)


@pytest.mark.parametrize(
    "setting",
    [mks.SilenceWatchdog(60), mks.SilenceWatchdog(0), mks.SetReplies(mks.ReplyMode.IMMEDIATE)],
    ids=str,
)
def test_a_drive_with_other_settings_that_do_no_harm_is_driven(setting):
    bus = Bus("mks")
    flashed(setting)(bus)
    arm = bus.connect()
    assert ("3: 8c 01 01" in arm.status.notice) == isinstance(setting, mks.SetReplies)
    check_works_again(arm, bus.motors)
    kept = bus.twin.board.nodes[ELBOW].flash.of(mks.SilenceWatchdog)
    assert kept == mks.SilenceWatchdog(round(bus.config.device.watchdog_s * 1000))


def test_drives_with_other_microsteps_are_switched_on_and_nothing_moves():
    bus = Bus("mks")
    fix = flashed(mks.SetMicrosteps(64))(bus)
    arm = bus.ready()
    stood = bus.motors
    with pytest.raises(SettingsDiffer, match=r"microsteps of drive 3 .* 64, expected 16.*--fix"):
        arm.move_j(base_deg=5)
    assert bus.motors == stood
    fix()
    arm.reset() if arm.status.state is State.ERROR_STOP else arm.enable()
    check_works_again(arm, stood)


def test_a_node_that_another_master_stopped_is_started_again():
    bus = Bus("cia402")
    stopped = Nmt(NmtCommand.STOP, ELBOW + 1).frame
    bus.twin.device.receive((stopped,), bus.twin.device.now_s)
    stood = bus.motors
    arm = bus.connect()
    assert bus.motors == stood
    assert not bus.motion_frames
    check_works_again(arm, stood)


@needs_pty
def test_a_wrong_bit_rate_is_reported_and_the_right_one_works(tmp_path):
    path = tmp_path / "can0"
    wrong, right = (f"can:slcan:{path}?bitrate={rate}000" for rate in (500, 250))
    with Served("mks", pty=path, bitrate=250_000) as bus:
        stood = bus.watch.motors
        # the adapter, in a thread of its own, tells of it before or after the drives are late
        with pytest.raises((LinkLost, NoAnswer), match=r"power.*120 ohm.*bit rate") as failed:
            Arm.connect(wrong, dialect="mks")
        assert failed.value.code == (LOST if isinstance(failed.value, LinkLost) else SILENT)
        if failed.value.code == LOST:
            assert f"armdrive doctor --can '{wrong.removeprefix('can:')}'" in str(failed.value)
        assert bus.watch.motors == stood
        # what failed to connect gives the adapter back in a thread of its own, perhaps late
        late = (PortInUse, NoAnswer)
        with at_last(lambda: Arm.connect(right, dialect="mks"), lambda: None, late) as arm:
            assert bus.watch.motors == stood
            assert arm.status.state is State.STANDBY
            at_last(lambda: arm.jog_j(base_deg=-1.0), arm.reset, (DeviceFault, NoAnswer))
        assert bus.watch.motors != stood
