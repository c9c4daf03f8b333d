"""How a CAN address is read, what python-can's own configuration adds, and refusals in words."""

from __future__ import annotations

import contextlib
import errno
import sys

import can
import pytest
from can_bench import frames_of
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import BadRequest, NoSuchPort, PortForbidden, PortInUse, PortUnavailable
from armdrive.transports import ports as can_refusals
from armdrive.transports.address import CanAddress, is_can, scheme
from armdrive.transports.can_link import _filters
from armdrive.transports.opening import open_link
from armdrive.transports.ports import can_refusal, is_down
from firmware_protocol.frames import Frame, pack

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
        (tmp_path / "can7").mkdir()
        (tmp_path / "can7" / "type").write_text("280")
        (tmp_path / "can7" / "flags").write_text("0x40080")
        found = is_down(CanAddress.parse("can:socketcan:can7?bitrate=250000"), tmp_path)
        assert "`sudo ip link set can7 up type can bitrate 250000 restart-ms 100`" in str(found)
        assert is_down(CanAddress.parse("can:socketcan:can8"), tmp_path) is None
        assert is_down(CanAddress.parse("can:pcan:can7"), tmp_path) is None
        assert can_refusals.bring_up("vcan0") == "sudo ip link set vcan0 up"


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


@pytest.mark.parametrize(("port", "error", "kind", "words"), CASES)
def test_what_a_driver_says_is_put_into_words(port, error, kind, words, tmp_path):
    found = can_refusal(CanAddress.parse(port), error, tmp_path)
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
