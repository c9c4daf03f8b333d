"""CAN buses: adapters, addresses, opening, frames, and how a bus is lost."""

import contextlib
import errno
import sys
import threading

import can
import pytest
from amounts import every_row
from can_bench import LONG_S, FailingBus, frames_of, message, until_lost
from cli_calls import write_arm_file
from doctor_bench import plug
from hypothesis import given
from hypothesis import strategies as st
from waiting import FOREVER_S, returns, soon, until

from armdrive.errors import (
    BadRequest,
    LinkLost,
    NoSuchPort,
    PortForbidden,
    PortInUse,
    PortUnavailable,
)
from armdrive.transports import can_link, opening, ports
from armdrive.transports.address import CanAddress, is_can, scheme
from armdrive.transports.can_health import BusState, of_error_frame
from armdrive.transports.can_link import MOST_AWAKE_S, PATIENCE_S, CanLink
from armdrive.transports.opening import open_link
from armdrive.transports.ports import (
    PortInfo,
    can_refusal,
    device_of,
    list_can_ports,
    serial_number_of,
)
from firmware_protocol.frames import Frame, pack

pytestmark = pytest.mark.usefixtures("short_patience", "never_stale")

# -- Adapters --------------------------------------------------------------------------------------

NUMBER = "A50285BI"


@pytest.fixture
def computer(tmp_path, monkeypatch):
    """A computer with two CAN interfaces, one of them down, and a network card."""
    net = tmp_path / "net"
    for name, kind, flags in (("can0", 280, 0x80), ("eth0", 1, 0x1003), ("vcan0", 280, 0xC1)):
        (net / name).mkdir(parents=True)
        (net / name / "type").write_text(f"{kind}\n")
        (net / name / "flags").write_text(f"{flags:#x}\n")
    monkeypatch.setattr(ports, "NET", net)


def test_adapters_are_listed_with_what_each_needs(call, computer, monkeypatch, tmp_path):
    serial_ports = [
        PortInfo("/dev/ttyACM0", vid=0xAD50, pid=0x60C4),
        PortInfo("/dev/ttyUSB0", vid=0x0403, pid=0x6001),
        PortInfo("/dev/ttyS0"),
    ]
    down, up, adapter = list_can_ports(serial_ports)
    assert (down.port, up.port) == ("can:socketcan:can0", "can:socketcan:vcan0")
    assert "sudo ip link set can0 up type can bitrate 500000 restart-ms 100" in down.todo
    assert ports.bring_up("vcan0") == "sudo ip link set vcan0 up"
    assert up.todo == ""
    assert adapter.port == "can:slcan:/dev/ttyACM0?bitrate=500000"
    assert "slcan firmware" in adapter.description
    seen = call("ports", "--json", code=0).json["can"]
    assert [each["port"] for each in seen] == [down.port, up.port]
    assert "bring it up with" in call("ports", code=0).out
    refused("can:socketcan:can0?bitrate=250000", "set can0 up type can bitrate 250000")
    monkeypatch.setattr(ports, "NET", tmp_path / "none")
    assert list_can_ports([]) == []


def test_an_adapter_is_found_by_its_usb_serial_number(call, tmp_path, monkeypatch):
    adapter = tmp_path / "ttyACM3"
    plug(monkeypatch, {adapter: NUMBER})
    monkeypatch.setattr(ports, "BY_ID", tmp_path / "by-id")
    assert serial_number_of(f"can:slcan:{adapter}@115200") == NUMBER
    assert serial_number_of("can:socketcan:can0") == ""
    before = "can:slcan:/dev/ttyACM7?bitrate=500000"
    assert device_of(NUMBER, before) == f"can:slcan:{adapter}?bitrate=500000"
    assert device_of(NUMBER, "can:slcan:/dev/x@9600") == f"can:slcan:{adapter}@9600"
    with pytest.raises(NoSuchPort, match="no port has"):
        device_of("other", before)
    for name, port in (("six", f"can:slcan:{adapter}?bitrate=500000"), ("far", "can:socketcan:x")):
        write_arm_file(name, f'model = "teachmover"\n[connection]\nport = "{port}"\n')
    seen = call("ports", "--json", code=0).json
    assert seen["ports"][0]["arm_files"] == ["six"]
    assert seen["absent"] == []


# -- Addresses -------------------------------------------------------------------------------------

WORDS = st.text(st.characters(codec="ascii", categories=("L", "N")), max_size=8)


@given(WORDS, WORDS, st.dictionaries(WORDS.filter(bool), WORDS), st.sets(st.integers(0, 0x7FF)))
def test_an_address_is_read_as_it_is_written(interface, channel, options, ids):
    options.pop("ids", None)
    channel = channel if interface else ""
    address = CanAddress(interface, channel, tuple(options.items()), frozenset(ids))
    assert CanAddress.parse(str(address)) == address
    assert is_can(str(address))


def test_channels_keep_their_own_colons_and_speeds():
    far = CanAddress.parse("can:slcan:socket://host:4001?bitrate=500000")
    assert (far.channel, far.option("bitrate")) == ("socket://host:4001", "500000")
    assert CanAddress.parse("CAN:slcan:/dev/ttyACM0@9600").device == "/dev/ttyACM0"
    assert scheme("can:slcan:socket://host:4001") == ""
    assert not is_can("/dev/can:0")
    for port in ("can:x:y?bitrate", "can:x:y?ids=a", "can:x:y?ids=-1", "COM3"):
        with pytest.raises(BadRequest):
            CanAddress.parse(port)


# -- Opening ---------------------------------------------------------------------------------------


@pytest.fixture(autouse=True)
def no_configuration(monkeypatch):
    """Keep python-can's configuration of this computer out of the tests."""
    for name in ("CAN_INTERFACE", "CAN_CHANNEL", "CAN_BITRATE", "CAN_CONFIG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(can.util, "CONFIG_FILES", [])


def opened(port: str):
    return contextlib.closing(open_link(port, 0))


def refused(port: str, match: str, kind=PortUnavailable) -> None:
    with pytest.raises(kind, match=match):
        open_link(port, 0)


def test_what_an_address_leaves_out_is_configured(monkeypatch, tmp_path):
    file = tmp_path / "can.conf"
    file.write_text("[default]\ninterface = virtual\nchannel = by-file\nbitrate = 125000\n")
    monkeypatch.setattr(can.util, "CONFIG_FILES", [str(file)])
    with opened("can:") as link:
        assert link.description == "can:virtual:by-file at 125 kbit/s"
    with opened("can:virtual:mine?bitrate=1000000") as link:
        assert link.description == "can:virtual:mine at 1000 kbit/s"
    monkeypatch.setattr(can.util, "CONFIG_FILES", [])
    refused("can:", r"names no CAN interface.*CAN_INTERFACE.*can:slcan:/dev/ttyACM0")


def test_a_bus_that_cannot_be_opened_is_refused_in_words(monkeypatch):
    refused("can:sockecan:can0", r"did you mean 'socketcan'\?")
    refused("can:virtual:x?port=abc", "cannot be used")
    refused("can:udp_multicast:239.74.163.2", "an order would look confirmed")
    monkeypatch.setitem(sys.modules, "can", None)
    refused("can:virtual:x", "pip install python-can")


GS_USB = "can:gs_usb:0"


@every_row(
    "port, error, kind, words",
    [
        ("can:socketcan:can9", OSError(errno.ENODEV, "no"), NoSuchPort, "slcan firmware"),
        ("can:socketcan:can9", OSError(errno.EINVAL, "no"), PortUnavailable, "ip -details link"),
        (GS_USB, can.CanInitializationError("Cannot find device 0."), NoSuchPort, "slcan firmware"),
        (GS_USB, OSError(errno.EACCES, "no"), PortForbidden, "udev rule"),
        (GS_USB, OSError(errno.EBUSY, "no"), PortInUse, "can:socketcan:can0"),
        (GS_USB, ValueError("No backend available"), PortUnavailable, "libusb"),
        (GS_USB, ModuleNotFoundError("usb"), PortUnavailable, r"install 'python-can\[gs-usb\]'"),
        ("can:kvaser:0", NameError("canGetNumber"), PortUnavailable, "driver's library"),
        ("can:pcan:X", RuntimeError(), PortUnavailable, "RuntimeError"),
        ("can:slcan:/dev/ttyACM0", OSError(errno.EBUSY, "no"), PortInUse, "is in use"),
    ],
)
def test_driver_errors_are_put_into_words(port, error, kind, words):
    found = can_refusal(CanAddress.parse(port), error)
    assert type(found) is kind
    with pytest.raises(kind, match=words):
        raise found


def test_ctrl_c_between_the_bus_and_its_link_shuts_the_bus_down(monkeypatch):
    def interrupted(bus, *_):
        buses.append(bus)
        raise KeyboardInterrupt

    buses = []
    monkeypatch.setattr(opening, "CanLink", interrupted)
    with pytest.raises(KeyboardInterrupt):
        open_link("can:virtual:interrupted", 0)
    with pytest.raises(can.CanOperationError):
        buses[0].recv(0.0)


# -- Frames ----------------------------------------------------------------------------------------

BUS_OFF = message(0x040, bytes(8), is_error_frame=True)
NO_ACK = message(0x020, bytes(8), is_error_frame=True)


def test_frames_pass_both_ways_in_their_order(request):
    where = f"can:virtual:{request.node.name}"
    sent = [Frame(5, b"hello"), Frame(0x1ABCDEF0, b"\r\n", extended=True), Frame(7, remote=True)]
    packed = b"".join(map(pack, sent))
    with opened(where) as one, opened(where) as other, opened(f"{where}?ids=7,0x10") as picky:
        one.write(packed[:3], 0.0)
        one.write(packed[3:], 0.0)
        assert frames_of(other, 3) == sent
        assert frames_of(picky) == [sent[2]]
        other.write(pack(Frame(6)), 0.0)
        assert frames_of(one) == [Frame(6)]
        assert (one.health.received, other.health.received) == (1, 3)
        soon(one.wake)
        returns(lambda: one.wait(FOREVER_S))
    one.close()
    for use in (lambda: one.write(b"", 0.0), lambda: one.read(0.0)):
        with pytest.raises(LinkLost, match="closed"):
            use()
    assert not [each for each in threading.enumerate() if each.name.startswith("armdrive-can")]


def test_of_a_flood_the_oldest_frames_are_dropped_and_ones_own_are_passed_over(
    failing, monkeypatch
):
    monkeypatch.setattr(can_link, "MOST_UNREAD_FRAMES", 4)
    bus, link = failing
    bus.coming.append(message(1, bytes(12), is_fd=True, dlc=12))
    bus.coming.append(message(2, is_rx=False))
    bus.coming.extend(message(each) for each in range(10))
    until(lambda: link.health.received == 10)
    assert [each.can_id for each in frames_of(link, 4)] == [6, 7, 8, 9]
    assert link.health.overrun == 6


# -- Losses ----------------------------------------------------------------------------------------


def test_errors_of_a_moment_are_survived(patient, failing, monkeypatch):
    bus, link = failing
    bus.coming.extend([can.CanOperationError("error warning limit"), ValueError("odd"), NO_ACK])
    bus.coming.append(message(1))
    assert frames_of(link) == [Frame(1)]
    assert (link.health.read_errors, link.health.error_frames) == (2, 1)
    assert link.health.state is BusState.PASSIVE
    assert "acknowledged" in link.health.last_trouble
    bus.sending.extend([can.CanOperationError("x", errno.ENOBUFS), can.CanTimeoutError("y")])
    link.write(pack(Frame(1)) + pack(Frame(2)), 0.0)
    until(lambda: len(bus.sent) == 2)
    assert [each.arbitration_id for each in bus.sent] == [1, 2]
    bus.coming.append(can.CanOperationError("once more, and no frame comes after it"))
    until(lambda: link.health.read_errors == 3)
    until(lambda: not link._watch._since)
    monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", 0.0)
    link.wait(0.2)
    assert link.read(0.0) == b""


def breaks(bus: FailingBus, how: str) -> None:
    """Break a bus; each way is a row of the table below."""
    match how:
        case "bus-off":
            bus.coming.append(BUS_OFF)
        case "its driver knows of bus-off":
            bus.broken = can.BusState.ERROR
        case "passive":
            bus.coming.append(NO_ACK)
        case "cannot be read":
            bus.always = can.CanOperationError("error warning limit exceeded")
        case "gone":
            bus.coming.append(can.CanOperationError("failed to receive", errno.ENODEV))
        case "stuck":
            bus.stuck.clear()
        case "full":
            bus.full = True
        case "unplugged":
            bus.sending.append(can.CanOperationError("device unplugged"))
        case "down":
            bus.sending.append(can.CanOperationError("x", errno.ENETDOWN))


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("bus-off", "bus-off.*120 ohm"),
        ("its driver knows of bus-off", "its driver reports so"),
        ("passive", "no node acknowledged"),
        ("cannot be read", "error warning limit exceeded"),
        ("gone", "gone"),
        ("stuck", "took no frame"),
        ("full", "took no frame"),
        ("unplugged", "device unplugged"),
        ("down", "interface is down"),
    ],
)
def test_a_bus_that_does_not_work_is_a_loss_in_its_words(failing, monkeypatch, how, words):
    monkeypatch.setattr(can_link, "DRAIN_S", 0.05)
    monkeypatch.setattr(can_link, "CLOSING_S", 0.05)
    bus, link = failing
    breaks(bus, how)
    with contextlib.suppress(LinkLost):
        returns(lambda: link.write(pack(Frame(1)) + pack(Frame(2)), 0.0))
    lost = until_lost(link)
    with pytest.raises(LinkLost, match=words):
        raise LinkLost(lost)
    with pytest.raises(LinkLost):
        link.write(pack(Frame(3)), 0.0)
    returns(link.close)
    bus.stuck.set()
    until(lambda: bus._is_shutdown)


def test_frames_received_before_the_loss_come_first(failing):
    bus, link = failing
    bus.coming.extend([message(1), BUS_OFF])
    until(lambda: link.health.error_frames)
    assert link.read(0.0) == pack(Frame(1))
    assert "has left the bus" in until_lost(link)
    assert link.health.state is BusState.OFF


def test_more_frames_than_any_bus_carries_are_a_loss(failing):
    bus, link = failing
    bus.stuck.clear()
    link.write(pack(Frame(1)) * (2 * can_link.MOST_FRAMES), 0.0)
    assert "frames wait to be sent" in until_lost(link)


def test_frames_written_before_closing_are_sent_first_and_by_nobody_else(
    patient, failing, monkeypatch
):
    def periodic(*args, **kwargs):
        pytest.fail("a driver was asked to go on by itself")

    monkeypatch.setattr(can.BusABC, "send_periodic", periodic)
    bus, link = failing
    bus.stuck.clear()
    link.write(pack(Frame(1)) + pack(Frame(2)), 0.0)
    soon(bus.stuck.set)
    link.close()
    assert [each.arbitration_id for each in bus.sent] == [1, 2]


class Suspended:
    """A writer on a failing bus, on a clock that the test sets; `end` closes both."""

    def __init__(self, monkeypatch) -> None:
        monkeypatch.setattr(can_link, "FRESH_S", 0.15)
        monkeypatch.setattr(can_link, "PATIENCE_S", PATIENCE_S)
        self.now_s = 0.0
        self.bus = FailingBus()
        self.watch = can_link.Watch(lambda: self.now_s, lambda: None)
        self.writer = can_link.CanWriter(self.bus, self.watch, lambda: self.now_s)

    def stick(self) -> None:
        """Have the adapter hang in the middle of frame 1."""
        self.bus.stuck.clear()
        self.writer.put([Frame(1)])
        until(lambda: self.writer._sending)

    def end(self) -> list[int]:
        """End the writer; return the ids that were sent."""
        self.bus.stuck.set()
        self.writer.drain(LONG_S)
        self.watch.ended.set()
        self.writer.join(LONG_S)
        self.bus.shutdown()
        return [each.arbitration_id for each in self.bus.sent]


class TestSuspension:
    """What was to be sent before this program was suspended is not sent after it."""

    @pytest.fixture
    def bench(self, monkeypatch):
        return Suspended(monkeypatch)

    def test_a_suspension_in_mid_frame_forgets_the_frames_that_wait_and_loses_no_bus(self, bench):
        bench.stick()
        bench.writer.put([Frame(2), Frame(3)])
        bench.writer.look()
        bench.now_s = 20.0
        bench.writer.look()
        assert bench.watch.lost == ""
        bench.bus.stuck.set()
        bench.writer.drain(LONG_S)
        bench.writer.put([Frame(4)])
        assert bench.end() == [1, 4]
        assert bench.watch.health.forgotten == 2

    def test_a_frame_whose_time_ran_out_is_forgotten_and_the_bus_is_not_lost(
        self, bench, monkeypatch
    ):
        send = FailingBus.send

        def suspended(bus, msg, timeout=None):
            if bench.now_s == 0.0:
                bench.now_s = 20.0
                raise can.CanTimeoutError("the adapter takes nothing more")
            send(bus, msg, timeout)

        monkeypatch.setattr(FailingBus, "send", suspended)
        bench.writer.put([Frame(1)])
        until(lambda: bench.watch.health.forgotten == 1)
        bench.writer.put([Frame(2)])
        assert bench.end() == [2]
        assert bench.watch.lost == ""

    def test_an_adapter_that_is_stuck_while_the_program_is_awake_is_lost(self, bench):
        bench.stick()
        bench.writer.look()
        while not bench.watch.lost and bench.now_s < 2.0:
            bench.now_s += MOST_AWAKE_S / 2.0
            bench.writer.look()
        assert bench.now_s <= PATIENCE_S + MOST_AWAKE_S
        assert "took no frame" in bench.watch.lost
        bench.end()


class RefusingBus(FailingBus):
    """A bus whose adapter reports that it could not send a frame, as slcan does."""

    def __init__(self) -> None:
        self.refused = 0
        self.refusing = False
        super().__init__()

    def send(self, msg, timeout=None):
        self.refused += 1
        self.refusing = True


def test_an_adapter_that_refuses_frames_is_a_loss_if_it_lasts(monkeypatch):
    monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", LONG_S)
    with contextlib.closing(CanLink(bus := RefusingBus(), "can:refusing")) as link:
        link.write(pack(Frame(1)), 0.0)
        until(lambda: link.health.state is BusState.PASSIVE)
        bus.refusing = False
        until(lambda: link.health.state is BusState.ACTIVE)
        monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", 0.1)
        link.write(pack(Frame(1)), 0.0)
        assert "refuses frames" in until_lost(link)
        assert link.health.refused == 2


@every_row(
    "can_id, data, state",
    [
        (0x040, b"", BusState.OFF),
        (0x020, b"", BusState.PASSIVE),
        (0x004, b"\0\x20", BusState.PASSIVE),
        (0x004, b"\0\x08", BusState.WARNING),
        (0x004, b"\0\x40", BusState.ACTIVE),
        (0x100, b"", BusState.ACTIVE),
        (0x004, b"\0\x01", None),
        (0x088, bytes(8), None),
    ],
)
def test_error_frames_report_a_state(can_id, data, state):
    found = of_error_frame(can_id, data)
    assert (found and found[0]) is state
