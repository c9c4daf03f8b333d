"""The list of serial ports: what people choose from, without opening anything."""

import os
import sys
from types import SimpleNamespace

import pytest
import serial
from serial.tools import list_ports as pyserial

from armdrive.errors import NoSuchPort
from armdrive.transports import ports
from armdrive.transports.ports import PortHolder, PortInfo, device_names, list_ports, owning_group
from armdrive.transports.serial_port import SerialLink

USB = {
    "description": "USB2.0-Serial",
    "vid": 0x1A86,
    "pid": 0x7523,
    "serial_number": None,
    "manufacturer": "QinHeng",
}
BARE = {
    "description": "n/a",
    "vid": None,
    "pid": None,
    "serial_number": None,
    "manufacturer": None,
}


@pytest.fixture
def adapter(tmp_path, monkeypatch):
    """Pretend that there are two ports; files stand in for their devices."""
    devices = [tmp_path / "ttyUSB0", tmp_path / "ttyS0"]
    for device in devices:
        device.touch()
    found = [
        SimpleNamespace(device=str(devices[0]), **USB),
        SimpleNamespace(device=str(devices[1]), **BARE),
        SimpleNamespace(device=str(devices[0]), **USB),
    ]
    monkeypatch.setattr(pyserial, "comports", lambda: found)
    return devices


def test_ports_are_listed_by_name_with_what_is_known(adapter):
    bare, usb = list_ports()
    assert bare == PortInfo(str(adapter[1]), group=owning_group(str(adapter[1])))
    assert (usb.device, usb.description) == (str(adapter[0]), "USB2.0-Serial")
    assert (usb.vid, usb.pid, usb.manufacturer) == (0x1A86, 0x7523, "QinHeng")
    assert usb.readable
    assert usb.holder is None


def test_nothing_is_opened_to_list_them(adapter, monkeypatch):
    def opened(*args, **kwargs):
        pytest.fail("a port was opened")

    monkeypatch.setattr(serial, "Serial", opened)
    monkeypatch.setattr(os, "open", opened)
    assert len(list_ports()) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_who_has_a_port_open_is_named(adapter):
    with adapter[0].open():
        held = {info.device: info.holder for info in list_ports()}
    assert isinstance(held[str(adapter[0])], PortHolder)
    assert held[str(adapter[0])].pid == os.getpid()
    assert held[str(adapter[1])] is None


def test_the_name_that_stays_is_found(adapter, tmp_path, monkeypatch):
    folder = tmp_path / "by-id"
    folder.mkdir()
    (folder / "usb-QinHeng-if00").symlink_to(adapter[0])
    monkeypatch.setattr(ports, "BY_ID", folder)
    stable = {info.device: info.stable_name for info in list_ports()}
    assert stable == {
        str(adapter[0]): str(folder / "usb-QinHeng-if00"),
        str(adapter[1]): None,
    }
    monkeypatch.setattr(ports, "BY_ID", tmp_path / "nowhere")
    assert {info.stable_name for info in list_ports()} == {None}


@pytest.mark.skipif(sys.platform == "win32", reason="needs file permissions")
def test_a_port_that_this_user_may_not_open_is_told(adapter, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: path != str(adapter[0]))
    assert [info.readable for info in list_ports()] == [True, False]


def test_a_missing_port_is_met_with_those_that_are_there(adapter):
    assert device_names() == (str(adapter[1]), str(adapter[0]))
    missing = "/dev/ttyUSB77"
    with pytest.raises(NoSuchPort, match="check the cable and the name") as error:
        SerialLink(missing, 9600)
    assert f"present: {adapter[1]}, {adapter[0]}" in str(error.value)


def test_a_computer_without_ports_says_so(monkeypatch):
    monkeypatch.setattr(pyserial, "comports", list)
    assert list_ports() == ()
    with pytest.raises(NoSuchPort, match="there is no serial port at all"):
        SerialLink("/dev/ttyUSB77", 9600)


def test_the_real_list_of_this_computer_can_be_made():
    assert all(isinstance(info, PortInfo) for info in list_ports())
