"""Links on CAN: ports, opening, reading."""

import contextlib
import errno
import sys
import threading

import can
import pytest
from can_bench import frames_of, message, until_lost
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
from armdrive.transports.can_health import BusState
from armdrive.transports.opening import _filters, open_link
from armdrive.transports.ports import (
    PortInfo,
    can_refusal,
    device_of,
    is_down,
    list_can_ports,
    serial_number_of,
)
from firmware_protocol.frames import Frame, pack

# -- Ports -----------------------------------------------------------------------------------------

NUMBER = "A50285BI"
BUS = "can:slcan:/dev/ttyACM7?bitrate=500000"


@pytest.fixture
def computer(tmp_path, monkeypatch):
    """A computer with two CAN interfaces, one of them down, and a network card."""
    net = tmp_path / "net"
    for name, kind, flags in (("can0", 280, 0x80), ("eth0", 1, 0x1003), ("vcan0", 280, 0xC1)):
        (net / name).mkdir(parents=True)
        (net / name / "type").write_text(f"{kind}\n")
        (net / name / "flags").write_text(f"{flags:#x}\n")
    monkeypatch.setattr(ports, "NET", net)


def test_interfaces_of_the_kernel_are_listed_and_how_to_bring_them_up(computer):
    down, up = list_can_ports([])
    assert (down.port, up.port) == ("can:socketcan:can0", "can:socketcan:vcan0")
    assert "sudo ip link set can0 up type can bitrate 500000" in down.todo
    assert up.todo == ""


def test_a_serial_adapter_is_known_by_its_usb_numbers(computer):
    adapters = [
        PortInfo("/dev/ttyACM0", vid=0xAD50, pid=0x60C4),
        PortInfo("/dev/ttyUSB0", vid=0x0403, pid=0x6001),
        PortInfo("/dev/ttyS0"),
    ]
    (found,) = (each for each in list_can_ports(adapters) if "slcan" in each.port)
    assert found.port == "can:slcan:/dev/ttyACM0?bitrate=500000"
    assert "slcan firmware" in found.description


def test_without_linux_there_is_nothing_to_list(monkeypatch, tmp_path):
    monkeypatch.setattr(ports, "NET", tmp_path / "none")
    assert list_can_ports([]) == []


def test_the_command_lists_them_in_words_and_as_json(call, computer):
    seen = call("ports", "--json", code=0).json["can"]
    assert [each["port"] for each in seen] == ["can:socketcan:can0", "can:socketcan:vcan0"]
    said = call("ports", code=0).out
    assert said.count("can:socketcan:can0") == 1
    assert "bring it up with" in said


class TestSameAdapter:
    @pytest.fixture
    def adapter(self, tmp_path, monkeypatch):
        device = tmp_path / "ttyACM3"
        plug(monkeypatch, {device: NUMBER})
        monkeypatch.setattr(ports, "BY_ID", tmp_path / "by-id")
        return device

    def test_the_number_behind_a_bus_is_its_adapters(self, adapter):
        assert serial_number_of(f"can:slcan:{adapter}?bitrate=500000") == NUMBER
        assert serial_number_of(f"can:slcan:{adapter}@115200") == NUMBER
        assert serial_number_of("can:socketcan:can0") == ""
        assert serial_number_of("can:") == ""

    def test_it_is_found_under_another_name_with_all_its_options(self, adapter):
        assert device_of(NUMBER, BUS) == f"can:slcan:{adapter}?bitrate=500000"
        assert device_of(NUMBER, "can:slcan:?ids=1") == f"can:slcan:{adapter}?ids=1"
        assert device_of(NUMBER, "can:slcan:/dev/x@9600") == f"can:slcan:{adapter}@9600"
        with pytest.raises(NoSuchPort, match="no port has"):
            device_of("other", BUS)

    def test_a_port_tells_the_arm_file_whose_bus_it_carries(self, call, adapter):
        lines = f'[connection]\nport = "can:slcan:{adapter}?bitrate=500000"\n'
        write_arm_file("six", f'model = "teachmover"\n{lines}')
        seen = call("ports", "--json", code=0).json
        assert seen["ports"][0]["arm_files"] == ["six"]
        assert seen["absent"] == []

    def test_a_bus_that_is_no_serial_port_is_not_called_absent(self, call, adapter):
        lines = '[connection]\nport = "can:socketcan:can0"\n'
        write_arm_file("six", f'model = "teachmover"\n{lines}')
        assert call("ports", "--json", code=0).json["absent"] == []


# -- Opening ---------------------------------------------------------------------------------------

NAMES = ("CAN_INTERFACE", "CAN_CHANNEL", "CAN_BITRATE", "CAN_CONFIG")


@pytest.fixture(autouse=True)
def no_configuration(monkeypatch):
    """Keep python-can's configuration of this computer out of the tests."""
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(can.util, "CONFIG_FILES", [])


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
    near = CanAddress.parse("CAN:slcan:/dev/ttyACM0@9600")
    assert (near.device, near.at("/dev/x").channel) == ("/dev/ttyACM0", "/dev/x@9600")
    assert CanAddress.parse("can:socketcan:can0").device == ""


def test_a_bus_is_no_network_address():
    assert scheme("can:slcan:socket://host:4001") == ""
    assert not is_can("/dev/can:0")


@pytest.mark.parametrize("port", ["can:x:y?bitrate", "can:x:y?ids=a", "can:x:y?ids=-1", "COM3"])
def test_an_address_that_makes_no_sense_is_refused(port):
    with pytest.raises(BadRequest):
        CanAddress.parse(port)


def opened(port: str):
    return contextlib.closing(open_link(port, 0))


class TestConfiguration:
    def test_the_environment_names_the_bus(self, monkeypatch):
        monkeypatch.setenv("CAN_INTERFACE", "virtual")
        monkeypatch.setenv("CAN_CHANNEL", "by-environment")
        monkeypatch.setenv("CAN_BITRATE", "250000")
        with opened("can:") as one, opened("can:virtual:by-environment") as other:
            assert one.description == "can:virtual:by-environment at 250 kbit/s"
            one.write(pack(Frame(1)), 0.0)
            assert frames_of(other) == [Frame(1)]

    def test_the_configuration_file_does_and_the_address_wins(self, monkeypatch, tmp_path):
        file = tmp_path / "can.conf"
        file.write_text("[default]\ninterface = virtual\nchannel = by-file\nbitrate = 125000\n")
        monkeypatch.setattr(can.util, "CONFIG_FILES", [str(file)])
        with opened("can:") as link:
            assert link.description == "can:virtual:by-file at 125 kbit/s"
        with opened("can:virtual:mine?bitrate=1000000") as link:
            assert link.description == "can:virtual:mine at 1000 kbit/s"

    def test_a_program_that_has_set_can_rc_is_heard(self, monkeypatch):
        monkeypatch.setattr(can, "rc", {"interface": "virtual", "channel": "by-rc"})
        with opened("can:") as link:
            assert link.description == "can:virtual:by-rc"


def refused(port: str, match: str, kind=PortUnavailable) -> None:
    with pytest.raises(kind, match=match):
        open_link(port, 0)


class TestRefusals:
    def test_nothing_is_configured(self):
        refused("can:", r"names no CAN interface.*CAN_INTERFACE.*can:slcan:/dev/ttyACM0")

    def test_an_unknown_interface_suggests_the_nearest(self):
        refused("can:sockecan:can0", r"did you mean 'socketcan'\?")

    def test_python_can_is_not_installed(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "can", None)
        refused("can:virtual:x", "pip install python-can")

    def test_an_option_that_makes_no_sense(self):
        refused("can:virtual:x?port=abc", "cannot be used")

    def test_an_interface_that_is_down(self, monkeypatch, tmp_path):
        monkeypatch.setattr(ports, "NET", tmp_path)
        (tmp_path / "can7").mkdir()
        (tmp_path / "can7" / "type").write_text("280")
        (tmp_path / "can7" / "flags").write_text("0x40080")
        found = is_down(CanAddress.parse("can:socketcan:can7?bitrate=250000"))
        assert "`sudo ip link set can7 up type can bitrate 250000 restart-ms 100`" in str(found)
        assert is_down(CanAddress.parse("can:socketcan:can8")) is None
        assert is_down(CanAddress.parse("can:pcan:can7")) is None
        assert ports.bring_up("vcan0") == "sudo ip link set vcan0 up"


def os_error(number: int) -> OSError:
    return OSError(number, "no")


GS_USB = "can:gs_usb:0"
CASES = [
    ("can:socketcan:can9", os_error(errno.ENODEV), NoSuchPort, "there is no CAN interface can9"),
    ("can:socketcan:can9", os_error(errno.ENETDOWN), PortUnavailable, "is down: bring it up"),
    ("can:socketcan:can9", os_error(errno.EAFNOSUPPORT), PortUnavailable, "has no SocketCAN"),
    ("can:socketcan:can9", os_error(errno.EINVAL), PortUnavailable, "ip -details link"),
    (GS_USB, can.CanInitializationError("Cannot find device 0. Devices found: 0"), NoSuchPort,
     "with slcan firmware is a serial port"),
    (GS_USB, os_error(errno.EACCES), PortForbidden, "udev rule"),
    (GS_USB, os_error(errno.EBUSY), PortInUse, "can:socketcan:can0"),
    (GS_USB, os_error(errno.EPIPE), PortUnavailable, "cannot be opened"),
    (GS_USB, ValueError("No backend available"), PortUnavailable, "libusb"),
    (GS_USB, ModuleNotFoundError("No module named 'usb'"), PortUnavailable,
     r"pip install 'python-can\[gs-usb\]'"),
    ("can:kvaser:0", NameError("canGetNumberOfChannels"), PortUnavailable, "driver's library"),
    ("can:pcan:", ValueError("the channel is missing"), PortUnavailable, "names no channel"),
    ("can:pcan:X", RuntimeError(), PortUnavailable, "RuntimeError"),
    ("can:slcan:/dev/ttyACM0", os_error(errno.EBUSY), PortInUse, "is in use"),
]  # fmt: skip


def test_ctrl_c_between_the_bus_and_its_link_shuts_the_bus_down(monkeypatch):
    def interrupted(bus, *_):
        buses.append(bus)
        raise KeyboardInterrupt

    buses = []
    monkeypatch.setattr(opening, "CanLink", interrupted)
    with pytest.raises(KeyboardInterrupt):
        open_link("can:virtual:interrupted", 0)
    (bus,) = buses
    with pytest.raises(can.CanOperationError):
        bus.recv(0.0)


def test_an_interface_that_returns_a_programs_own_frames_is_refused():
    with pytest.raises(PortUnavailable, match="an order would look confirmed"):
        open_link("can:udp_multicast:239.74.163.2", 500_000)


@pytest.mark.parametrize(("port", "error", "kind", "words"), CASES)
def test_driver_errors_are_put_into_words(port, error, kind, words):
    found = can_refusal(CanAddress.parse(port), error)
    assert type(found) is kind
    with pytest.raises(kind, match=words):
        raise found


def test_the_kernel_is_asked_for_the_ids_alone():
    short, long = _filters(frozenset({0x10, 0x12345}))
    assert short == {"can_id": 0x10, "can_mask": 0x7FF, "extended": False}
    assert long == {"can_id": 0x12345, "can_mask": 0x1FFFFFFF, "extended": True}


def test_filters_are_given_to_the_kernel_and_not_to_others(monkeypatch):
    seen = {}

    def bus(**settings):
        seen.update(settings)
        raise OSError(errno.ENODEV, "no")

    monkeypatch.setattr(can, "Bus", bus)
    for interface, filtered in (("socketcan", True), ("gs_usb", False)):
        seen.clear()
        refused(f"can:{interface}:0?ids=1", "CAN|can:")
        assert ("can_filters" in seen) is filtered
    assert seen["interface"] == "gs_usb"


# -- Links -----------------------------------------------------------------------------------------

BUS_OFF = message(0x040, bytes(8), is_error_frame=True)
NO_ACK = message(0x020, bytes(8), is_error_frame=True)


pytestmark = pytest.mark.usefixtures("short_patience", "never_stale")


@pytest.fixture
def pair(request):
    """Two links on one virtual bus of the test's own."""
    links = [open_link(f"can:virtual:{request.node.name}", 0) for _ in range(2)]
    yield links
    for link in links:
        link.close()


class TestFrames:
    def test_frames_pass_both_ways_in_their_order(self, pair):
        one, other = pair
        sent = [Frame(5, b"hello"), Frame(0x1ABCDEF0, b"\r\n", extended=True)]
        sent.append(Frame(7, remote=True))
        one.write(b"".join(map(pack, sent)), 0.0)
        assert frames_of(other, 3) == sent
        other.write(pack(Frame(6)), 0.0)
        assert frames_of(one) == [Frame(6)]
        assert (one.health.received, other.health.received) == (1, 3)

    def test_half_a_frame_is_sent_with_its_other_half(self, pair):
        one, other = pair
        packed = pack(Frame(5, b"abc"))
        one.write(packed[:3], 0.0)
        one.write(packed[3:], 0.0)
        assert frames_of(other) == [Frame(5, b"abc")]

    def test_only_ids_that_are_asked_for_are_heard(self, request):
        where = f"can:virtual:{request.node.name}"
        one, other = open_link(where, 0), open_link(f"{where}?ids=2,0x10", 0)
        one.write(b"".join(pack(Frame(each)) for each in (1, 2, 3, 16, 17)), 0.0)
        assert [each.can_id for each in frames_of(other, 2)] == [2, 16]
        one.close()
        other.close()

    def test_frames_of_another_kind_and_ones_own_are_passed_over(self, failing):
        bus, link = failing
        bus.coming.append(message(1, bytes(12), is_fd=True, dlc=12))
        bus.coming.append(message(2, is_rx=False))
        bus.coming.append(message(3))
        assert frames_of(link) == [Frame(3)]

    def test_of_a_flood_the_oldest_frames_are_dropped_and_counted(self, failing, monkeypatch):
        monkeypatch.setattr(can_link, "MOST_UNREAD_FRAMES", 4)
        bus, link = failing
        bus.coming.extend(message(each) for each in range(10))
        until(lambda: link.health.received == 10)
        assert [each.can_id for each in frames_of(link, 4)] == [6, 7, 8, 9]
        assert link.health.overrun == 6

    def test_waking_ends_a_wait(self, failing):
        _, link = failing
        soon(link.wake)
        returns(lambda: link.wait(FOREVER_S))

    def test_a_closed_link_says_so_and_its_threads_are_gone(self, request):
        link = open_link(f"can:virtual:{request.node.name}", 0)
        link.close()
        link.close()
        for use in (lambda: link.write(b"", 0.0), lambda: link.read(0.0)):
            with pytest.raises(LinkLost, match="closed"):
                use()
        assert not [each for each in threading.enumerate() if each.name.startswith("armdrive-can")]

    def test_an_engine_may_close_a_link_that_was_lost(self, failing):
        bus, link = failing
        bus.coming.append(BUS_OFF)
        until_lost(link)
        link.close()
        assert bus._is_shutdown


class TestReader:
    def test_errors_of_the_bus_are_survived(self, patient, failing):
        bus, link = failing
        bus.coming.extend([can.CanOperationError("error warning limit"), ValueError("odd")])
        bus.coming.append(message(1))
        assert frames_of(link) == [Frame(1)]
        assert link.health.read_errors == 2

    def test_errors_that_never_end_are_a_loss(self, failing):
        bus, link = failing
        bus.always = can.CanOperationError("error warning limit exceeded")
        assert "error warning limit exceeded" in until_lost(link)

    @pytest.mark.parametrize("number", [errno.ENODEV, errno.ENETDOWN, errno.EIO])
    def test_an_adapter_that_has_gone_is_a_loss_at_once(self, failing, number):
        bus, link = failing
        bus.coming.append(can.CanOperationError("failed to receive", number))
        assert "gone" in until_lost(link)
        assert link.health.read_errors == 1

    def test_frames_received_before_the_loss_come_first(self, failing):
        bus, link = failing
        bus.coming.extend([message(1), BUS_OFF])
        until(lambda: link.health.error_frames)
        assert link.read(0.0) == pack(Frame(1))
        assert "has left the bus" in until_lost(link)


class TestState:
    def test_bus_off_is_a_loss_at_once(self, failing):
        bus, link = failing
        bus.coming.append(BUS_OFF)
        lost = until_lost(link)
        assert "bus-off" in lost
        assert "120 ohm" in lost
        assert link.health.state is BusState.OFF
        with pytest.raises(LinkLost, match="bus-off"):
            link.write(pack(Frame(1)), 0.0)

    def test_a_driver_that_knows_of_bus_off_is_believed(self, failing):
        bus, link = failing
        bus.broken = can.BusState.ERROR
        assert "its driver reports so" in until_lost(link)

    def test_error_passive_that_lasts_is_a_loss(self, failing):
        bus, link = failing
        bus.coming.append(NO_ACK)
        assert "no node acknowledged" in until_lost(link)
        assert link.health.state is BusState.PASSIVE

    def test_error_passive_is_forgiven_once_a_frame_is_heard(self, patient, failing, monkeypatch):
        bus, link = failing
        bus.coming.extend([NO_ACK, message(1)])
        assert frames_of(link) == [Frame(1)]
        monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", 0.0)
        link.wait(0.2)
        assert link.read(0.0) == b""
        assert link.health.state is BusState.PASSIVE
        assert link.health.error_frames == 1
        assert "acknowledged" in link.health.last_trouble
