"""Serial ports: bytes, waking, loss, who may open one, and the list of those that are there."""

import errno
import os
import pty
import subprocess
import sys
import termios
import tty
from types import SimpleNamespace

import pytest
import serial
from amounts import every_row
from serial.tools import list_ports as pyserial
from waiting import FOREVER_S, LONG_S, returns, soon, until

from armdrive.errors import LinkLost, NoSuchPort, PortForbidden, PortInUse, PortUnavailable
from armdrive.transports import ports, serial_port
from armdrive.transports.link import Bell
from armdrive.transports.opening import open_link
from armdrive.transports.ports import PortHolder, PortInfo, holders, list_ports, refusal
from armdrive.transports.serial_port import SerialLink, clear_hupcl

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
on_linux = pytest.mark.skipif(sys.platform != "linux", reason="tried on Linux alone")


@pytest.fixture
def ends():
    master, slave = pty.openpty()
    tty.setraw(slave)
    name = os.ttyname(slave)
    os.close(slave)
    open_ends = [master]
    yield master, name, open_ends
    for end in open_ends:
        os.close(end)


@pytest.fixture
def link(ends):
    made = SerialLink(ends[1], 9600)
    yield made
    made.close()
    made.close()
    made.wake()


def test_bytes_go_both_ways_and_a_wait_ends_with_them_with_a_wake_and_with_its_time(ends, link):
    link.write(b"@READ\r", 0.0)
    assert os.read(ends[0], 100) == b"@READ\r"
    assert link.read(0.0) == b""
    os.write(ends[0], b"1\r")
    link.wait(LONG_S)
    assert link.read(0.0) == b"1\r"
    assert link.description == f"{ends[1]} at 9600 baud"
    assert link.next_s() == float("inf")
    link.wake()
    returns(lambda: link.wait(FOREVER_S))
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    returns(lambda: link.wait(0.02))


def test_a_port_that_goes_away_or_takes_nothing_is_lost_in_words(ends, link):
    assert link._port.write_timeout == serial_port.WRITE_PATIENCE_S
    link._port.write_timeout = 0.05
    with pytest.raises(LinkLost):
        link.write(b"x" * 1_000_000, 0.0)
    os.close(ends[2].pop())
    returns(lambda: link.wait(FOREVER_S))
    with pytest.raises(LinkLost, match="was lost") as lost:
        link.read(0.0)
    assert "Errno" not in str(lost.value)


def test_a_bell_ends_the_present_sleep_and_the_next_one():
    bell = Bell()
    bell.ring()
    returns(lambda: bell.wait(FOREVER_S))  # rung before anybody slept
    ringing = soon(bell.ring)
    returns(lambda: bell.wait(FOREVER_S))
    bell.wait(0.001)
    bell.close()
    bell.ring()
    returns(lambda: bell.wait(FOREVER_S))
    bell.close()
    ringing.join()


# -- Who may open one ------------------------------------------------------------------------------


@on_linux
def test_a_port_in_use_names_who_has_it(ends, link, monkeypatch):
    with pytest.raises(PortInUse, match=rf"\(pid {os.getpid()}\): end .* or close its connection"):
        SerialLink(ends[1], 9600)
    monkeypatch.setattr(ports, "holder", lambda device: PortHolder(4711, "miniterm"))
    with pytest.raises(PortInUse, match=r"miniterm \(pid 4711\): end that program"):
        SerialLink(ends[1], 9600)


def test_a_name_that_is_no_serial_port_is_refused(tmp_path):
    file = tmp_path / "file"
    file.touch()
    refusals = [
        ("/dev/no-such-port", NoSuchPort, "there is no port"),
        (str(file), NoSuchPort, "is not a serial port"),
        ("telnet://host:23", PortUnavailable, "socket://, rfc2217:// or udp://"),
        ("spy:///dev/ttyS0?file=log", PortUnavailable, "socket://, rfc2217:// or udp://"),
    ]
    for name, kind, words in refusals:
        with pytest.raises(kind, match=words):
            SerialLink(name, 9600)


def pyserial_error(number: int) -> serial.SerialException:
    text = os.strerror(number)
    return serial.SerialException(number, f"could not open port: [Errno {number}] {text}")


@every_row(
    "error, kind",
    [
        (pyserial_error(errno.ENOENT), NoSuchPort),
        (pyserial_error(errno.EBUSY), PortInUse),
        (pyserial_error(errno.EPERM), PortForbidden),
        # as Windows words them
        (serial.SerialException("PermissionError(13, 'Access is denied.', None, 5)"), PortInUse),
        (serial.SerialException("FileNotFoundError(2, 'not found', None, 2)"), NoSuchPort),
        (serial.SerialException("Could not configure port: (5, 'I/O error')"), NoSuchPort),
        (ValueError("Failed to set custom baud rate (7)"), PortUnavailable),
    ],
)
def test_each_failure_has_its_kind_and_says_what_to_do(error, kind):
    made = refusal("/dev/ttyUSB77", error)
    assert type(made) is kind
    assert "/dev/ttyUSB77" in str(made)
    assert ": " in str(made)


@every_row(
    "group, advice",
    [
        ("dialout", "`sudo usermod -aG dialout $USER`, then log in again"),
        ("root", "udev rule"),
        (None, "udev rule"),
    ],
)
def test_a_forbidden_port_names_the_group_to_join(monkeypatch, group, advice):
    monkeypatch.setattr(ports, "owning_group", lambda device: group)
    assert advice in str(refusal("/dev/ttyUSB0", pyserial_error(errno.EACCES)))


@on_linux
@pytest.mark.parametrize("address", ["{}", "can:slcan:{}?bitrate=500000"])
def test_the_terminal_of_another_program_is_not_opened(ends, tmp_path, address):
    """The link of a killed simulator leads to the next terminal that takes the same number."""
    _, name, _ = ends
    link = tmp_path / "arm"
    link.symlink_to(name)
    shell = subprocess.Popen(["sh", "-c", f"exec cat < {name}"], start_new_session=True)
    try:
        until(lambda: ports.terminal_user(name) is not None)
        with pytest.raises(PortInUse, match=rf"arm is the terminal .* \(pid {shell.pid}\): remove"):
            open_link(address.format(link), 9600)
    finally:
        shell.kill()
        shell.wait()
    SerialLink(str(link), 9600).close()
    os.utime(link, ns=(0, 0), follow_symlinks=False)  # made before this pseudo-terminal was
    with pytest.raises(PortUnavailable, match=f"arm is a link that .* {name} now belongs to"):
        open_link(address.format(link), 9600)


# -- DTR -------------------------------------------------------------------------------------------


def hangs_up(name: str) -> bool:
    fileno = os.open(name, os.O_RDWR | os.O_NOCTTY)
    try:
        return bool(termios.tcgetattr(fileno)[2] & termios.HUPCL)
    finally:
        os.close(fileno)


def test_dtr_and_rts_are_set_before_a_port_is_opened(monkeypatch):
    def gone():
        raise OSError(errno.ENODEV, "no such device")

    made = SimpleNamespace(open=gone)
    monkeypatch.setattr(serial_port, "_made", lambda *_: made)
    for up in (False, True):
        with pytest.raises(NoSuchPort):
            SerialLink("/dev/none", 9600, raise_dtr=up)
        assert (made.dtr, made.rts) == (up, up)


@on_linux
def test_a_port_can_be_told_to_keep_dtr_when_it_is_closed(ends, tmp_path):
    master, name, _ = ends
    settings = termios.tcgetattr(master)
    settings[2] |= termios.HUPCL
    termios.tcsetattr(master, termios.TCSANOW, settings)
    SerialLink(name, 9600).close()
    assert hangs_up(name)  # nobody asked
    SerialLink(name, 9600, raise_dtr=True, keep_dtr_on_close=True).close()
    assert not hangs_up(name)
    SerialLink(name, 9600).close()
    assert not hangs_up(name)  # it lasts
    with (tmp_path / "file").open("w") as file:
        clear_hupcl(file.fileno())  # no terminal: nothing to clear


# -- The ports that are there ----------------------------------------------------------------------

USB = {"description": "USB2.0-Serial", "vid": 0x1A86, "pid": 0x7523, "manufacturer": "QinHeng"}
BARE = {"description": "n/a", "vid": None, "pid": None, "manufacturer": None}


def test_ports_are_listed_by_name_with_what_is_known(tmp_path, monkeypatch):
    assert all(isinstance(info, PortInfo) for info in list_ports())  # those of this computer
    usb, bare = tmp_path / "ttyUSB0", tmp_path / "ttyS0"
    rows = [(usb, USB), (bare, BARE), (usb, USB)]
    found = [SimpleNamespace(device=str(each), serial_number=None, **known) for each, known in rows]
    usb.touch()
    bare.touch()
    monkeypatch.setattr(pyserial, "comports", lambda: found)
    plain, known = list_ports()
    assert plain == PortInfo(str(bare))
    assert (known.device, known.description, known.usb_id) == (
        str(usb),
        "USB2.0-Serial",
        "1a86:7523",
    )
    with pytest.raises(NoSuchPort, match=f"present: {bare}, {usb}"):
        SerialLink("/dev/ttyUSB77", 9600)
    monkeypatch.setattr(pyserial, "comports", list)
    with pytest.raises(NoSuchPort, match="there is no serial port at all"):
        SerialLink("/dev/ttyUSB77", 9600)


def test_the_program_that_has_a_device_open_is_found(monkeypatch, tmp_path):
    device, link = tmp_path / "ttyUSB0", tmp_path / "arm"
    device.touch()
    link.symlink_to(device)
    for pid, target in (("12", "/dev/other"), ("7", device), ("9", device)):
        (tmp_path / pid / "fd").mkdir(parents=True)
        (tmp_path / pid / "fd" / "3").symlink_to(target)
    (tmp_path / "7" / "comm").write_text("miniterm\n")
    (tmp_path / "5").mkdir()  # no fd: somebody else's
    (tmp_path / "self").mkdir()
    monkeypatch.setattr(ports, "PROC", tmp_path)
    assert holders([str(link)]) == {str(device): PortHolder(7, "miniterm")}
    assert ports.holder("/dev/other") == PortHolder(12, "unknown")
    monkeypatch.setattr(ports, "PROC", tmp_path / "nowhere")
    assert holders([str(link)]) == {}
