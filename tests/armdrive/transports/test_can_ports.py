"""Which CAN adapters are listed, by which line, and what it costs those who have none."""

from __future__ import annotations

from functools import partial

import pytest
from cli_calls import write_arm_file
from doctor_bench import plug

from armdrive.cli.set_up import ports as ports_command
from armdrive.errors import LinkError, NoSuchPort
from armdrive.transports import ports
from armdrive.transports import ports as can_ports
from armdrive.transports.ports import (
    CanPort,
    PortInfo,
    ask_drivers,
    device_of,
    list_can_ports,
    serial_number_of,
)

NUMBER = "A50285BI"
BUS = "can:slcan:/dev/ttyACM7?bitrate=500000"


@pytest.fixture
def computer(tmp_path):
    """A computer with two CAN interfaces, one of them down, and a network card."""
    net, usb = tmp_path / "net", tmp_path / "usb"
    for name, kind, flags in (("can0", 280, 0x80), ("eth0", 1, 0x1003), ("vcan0", 280, 0xC1)):
        (net / name).mkdir(parents=True)
        (net / name / "type").write_text(f"{kind}\n")
        (net / name / "flags").write_text(f"{flags:#x}\n")
    usb.mkdir()
    return net, usb


def usb_device(usb, name, vendor, product):
    (usb / name).mkdir()
    (usb / name / "idVendor").write_text(f"{vendor:04x}\n")
    (usb / name / "idProduct").write_text(f"{product:04x}\n")
    return usb / name


def test_interfaces_of_the_kernel_are_listed_and_how_to_bring_them_up(computer):
    down, up = list_can_ports([], *computer)
    assert (down.port, up.port) == ("can:socketcan:can0", "can:socketcan:vcan0")
    assert "sudo ip link set can0 up type can bitrate 500000" in down.todo
    assert up.todo == ""


def test_a_serial_adapter_is_known_by_its_usb_numbers(computer):
    adapters = [
        PortInfo("/dev/ttyACM0", vid=0xAD50, pid=0x60C4),
        PortInfo("/dev/ttyUSB0", vid=0x0403, pid=0x6001),
        PortInfo("/dev/ttyS0"),
    ]
    (found,) = (each for each in list_can_ports(adapters, *computer) if "slcan" in each.port)
    assert found.port == "can:slcan:/dev/ttyACM0?bitrate=500000"
    assert "slcan firmware" in found.description


def test_an_adapter_with_candlelight_firmware_is_listed_while_no_interface_is_its_own(computer):
    net, usb = computer
    device = usb_device(usb, "1-2", 0x1D50, 0x606F)
    usb_device(usb, "1-3", 0x046D, 0xC077)
    (found,) = (each for each in list_can_ports([], net, usb) if "gs_usb" in each.port)
    assert found.port == "can:gs_usb:0?bitrate=500000"
    assert "modprobe gs_usb" in found.todo
    (device / "1-2:1.0").mkdir()
    (net / "can0" / "device").symlink_to(device / "1-2:1.0")
    assert not [each for each in list_can_ports([], net, usb) if "gs_usb" in each.port]


def test_without_linux_there_is_nothing_to_list(tmp_path):
    assert list_can_ports([], tmp_path / "none", tmp_path / "neither") == []


def test_drivers_that_hang_or_die_end_as_an_error(monkeypatch):
    monkeypatch.setattr(can_ports, "_DETECT", "import time; time.sleep(60)")
    with pytest.raises(LinkError, match="did not answer within"):
        ask_drivers(0.2)
    monkeypatch.setattr(can_ports, "_DETECT", "import os; os.abort()")
    with pytest.raises(LinkError, match="cannot be queried"):
        ask_drivers()


def test_what_drivers_find_is_written_as_a_port(monkeypatch):
    monkeypatch.setattr(can_ports, "_DETECT", """print('[["pcan", "PCAN_USBBUS1"]]')""")
    assert ask_drivers() == [CanPort("can:pcan:PCAN_USBBUS1", "python-can's pcan")]


def test_the_command_lists_them_in_words_and_as_json(call, computer, monkeypatch):
    net, usb = computer
    monkeypatch.setattr(ports_command, "list_can_ports", partial(list_can_ports, net=net, usb=usb))
    monkeypatch.setattr(can_ports, "_DETECT", """print('[["socketcan", "can0"], ["x", "1"]]')""")
    seen = call("ports", "--json", code=0).json["can"]
    assert [each["port"] for each in seen] == ["can:socketcan:vcan0", "can:socketcan:can0"]
    said = call("ports", "--can", code=0).out
    assert "can:x:1" in said
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
