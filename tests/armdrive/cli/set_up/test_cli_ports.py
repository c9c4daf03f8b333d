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


def test_a_port_is_listed_with_all_that_is_known(call, adapter, tmp_path):
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


def test_nothing_is_opened(call, adapter, monkeypatch):
    def opened(*args, **kwargs):
        pytest.fail("a port was opened")

    monkeypatch.setattr(serial, "Serial", opened)
    assert len(call("ports", "--json", code=0).json["ports"]) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_the_holder_of_a_port_is_named(call, adapter):
    with adapter.open():
        (seen,) = call("ports", "--json", code=0).json["ports"]
        assert seen["holder"]["pid"] == os.getpid()
        assert seen["holder"]["arm"] is None
        said = call("ports", code=0).out
        assert f"(pid {os.getpid()})" in said
        assert "FT232R USB UART" in said


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_an_arm_that_armdrive_drives_on_a_port_is_named(call, adapter):
    write_bench(adapter)
    config = replace(simulated_config("teachmover"), name="bench")
    with adapter.open(), connect_remembered(config, pace="real"):
        (seen,) = call("ports", "--json", code=0).json["ports"]
        assert seen["holder"]["arm"] == "bench"
        said = call("ports", code=0).out
    assert "an armdrive program drives bench on it" in said
    assert "`armdrive status --arm bench` asks it" in said


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_a_program_that_was_given_the_port_itself_is_not_asked_by_an_arms_name(call, adapter):
    config = replace(simulated_config("teachmover"), name=str(adapter))
    with adapter.open(), connect_remembered(config, pace="real"):
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
    seen = call("ports", "--json", code=0).json
    assert [(each["arm"], each["port"]) for each in seen["absent"]] == [
        ("bench", "/dev/ttyNOWHERE")
    ]
    assert [each["arm"] for each in seen["unusable_arm_files"]] == ["broken"]
    said = call("ports", code=0).out
    assert "bench: its port /dev/ttyNOWHERE is missing" in said
    assert "broken cannot be used" in said


def test_an_address_that_makes_no_sense_hides_no_other_port(call, adapter):
    write_bench(adapter)
    connection = '[connection]\ndialect = "mks"\nport = "can:slcan:/dev/x?bitrate500000"\n'
    write_arm_file("bus", f'model = "minimover5-mks"\n{connection}')
    (seen,) = call("ports", "--json", code=0).json["ports"]
    assert seen["arm_files"] == ["bench"]


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


def test_two_adapters_with_one_number_are_distinguished_by_name_if_at_all(
    call, adapter, tmp_path, monkeypatch
):
    other = tmp_path / "ttyUSB1"
    plug(monkeypatch, {adapter: NUMBER, other: NUMBER})
    write_bench(other, usb_serial=NUMBER)
    write_bench("", "vague", usb_serial=NUMBER)
    seen = call("ports", "--json", code=0).json
    assert [each["arm_files"] for each in seen["ports"]] == [[], ["bench"]]
    (absent,) = seen["absent"]
    assert absent["arm"] == "vague"
    assert "give the port" in absent["why"]


def test_a_computer_without_ports_says_so(call, monkeypatch):
    monkeypatch.setattr(pyserial, "comports", list)
    assert "there is no serial port" in call("ports", code=0).out
    assert call("ports", "--json", code=0).json["ports"] == []
