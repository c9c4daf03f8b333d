"""`armdrive ports`: it lists ports with their holders and arm files, and opens none."""

import os
import sys
from dataclasses import replace

import pytest
import serial
from chain_files import shown_links
from cli_calls import write_arm_file, write_bench
from doctor_bench import NUMBER, plug
from serial.tools import list_ports as pyserial

from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import simulated_config
from armdrive.transports import ports


@pytest.fixture
def adapter(tmp_path, monkeypatch):
    """Pretend that there is one port; a file stands in for its device."""
    device = tmp_path / "ttyUSB0"
    plug(monkeypatch, {device: NUMBER})
    monkeypatch.setattr(ports, "BY_ID", tmp_path / "by-id")
    return device


def test_a_port_is_listed_with_all_that_is_known_and_is_not_opened(
    call, adapter, tmp_path, monkeypatch
):
    def opened(*args, **kwargs):
        pytest.fail("a port was opened")

    monkeypatch.setattr(serial, "Serial", opened)
    (tmp_path / "by-id").mkdir()
    (tmp_path / "by-id" / "usb-FTDI-if00").symlink_to(adapter)
    write_bench(tmp_path / "by-id" / "usb-FTDI-if00")
    (seen,) = call("ports", "--json", code=0).json["ports"]
    assert seen["port"] == str(adapter)
    assert (seen["description"], seen["usb"]) == ("FT232R USB UART", "0403:6001")
    assert (seen["serial_number"], seen["manufacturer"]) == ("A50285BI", "FTDI")
    assert seen["stable_name"] == str(tmp_path / "by-id" / "usb-FTDI-if00")
    assert seen["arm_files"] == ["bench"]
    assert (seen["holder"], seen["allowed"], seen["fix"]) == (None, True, "")
    said = call("ports", code=0).out
    for word in ("FT232R USB UART", "0403:6001", "A50285BI", "usb-FTDI-if00", "arm file bench"):
        assert word in said
    assert "armdrive doctor PORT" in said
    monkeypatch.setattr(pyserial, "comports", list)
    assert "there is no serial port" in call("ports", code=0).out


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_an_arm_that_armdrive_drives_on_a_port_is_named(call, adapter):
    write_bench(adapter)
    config = replace(simulated_config("teachmover"), name="bench")
    with adapter.open(), connect_remembered(config, pace="real"):
        (seen,) = call("ports", "--json", code=0).json["ports"]
        assert seen["holder"]["arm"] == "bench"
        assert seen["holder"]["pid"] == os.getpid()
        said = call("ports", code=0).out
    assert "an armdrive program drives bench on it" in said
    assert "`armdrive status --arm bench` asks it" in said
    # a program that was given the port itself is not asked by an arm's name
    with adapter.open(), connect_remembered(replace(config, name=str(adapter)), pace="real"):
        said = call("ports", code=0).out
    assert "an armdrive program drives an arm on it" in said
    assert "--arm" not in said


@pytest.mark.skipif(os.name != "posix", reason="needs file permissions")
def test_a_forbidden_port_is_listed_with_its_remedy(call, adapter, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    monkeypatch.setattr("armdrive.transports.ports.owning_group", lambda port: "dialout")
    (seen,) = call("ports", "--json", code=0).json["ports"]
    assert not seen["allowed"]
    assert "sudo usermod -aG dialout $USER" in seen["fix"]
    said = call("ports", code=0).out
    assert "sudo usermod -aG dialout $USER" in said
    assert "FT232R USB UART" in said


def test_arm_files_that_are_broken_or_lack_their_port_are_listed(call, adapter):
    write_bench("/dev/ttyNOWHERE")
    write_bench("socket://127.0.0.1:4001", "network")
    write_arm_file("broken", "model = 7\n")
    write_arm_file("links", shown_links())  # a model file is no arm
    connection = '[connection]\ndialect = "mks"\nport = "can:slcan:/dev/x?bitrate500000"\n'
    write_arm_file("bus", f'model = "minimover5-mks"\n{connection}')
    seen = call("ports", "--json", code=0).json
    assert [(each["arm"], each["port"]) for each in seen["absent"]] == [
        ("bench", "/dev/ttyNOWHERE")
    ]
    assert [each["arm"] for each in seen["unusable_arm_files"]] == ["broken"]
    said = call("ports", code=0).out
    assert "bench: its port /dev/ttyNOWHERE is missing" in said
    assert "broken cannot be used" in said


@pytest.mark.parametrize("named", ["", "/dev/ttyUSB9"], ids=["no name", "its name of yesterday"])
def test_an_arm_file_with_a_usb_number_has_the_port_of_that_adapter(call, adapter, named):
    write_bench(named, usb_serial=NUMBER)
    seen = call("ports", "--json", code=0).json
    assert seen["ports"][0]["arm_files"] == ["bench"]
    assert seen["absent"] == []
    said = call("ports", code=0).out
    assert f"belongs to the arm file bench (by the USB serial number {NUMBER})" in said
    assert "not there" not in said


def test_a_port_with_the_name_and_another_number_is_not_the_arms(call, adapter):
    write_bench(adapter, usb_serial="OTHER")
    seen = call("ports", "--json", code=0).json
    (there,) = seen["ports"]
    assert there["arm_files"] == []
    (absent,) = seen["absent"]
    assert (absent["arm"], absent["usb_serial"]) == ("bench", "OTHER")
    said = call("ports", code=0).out
    assert "the arm file bench: no port has the USB serial number OTHER" in said
    assert "plug the adapter in" in said
