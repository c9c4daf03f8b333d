"""The link to a serial port: bytes, waking, loss, who may open it, and what closing leaves."""

import errno
import os
import pty
import subprocess
import sys
import termios
import tty

import pytest
import serial
from amounts import every_row
from waiting import FOREVER_S, LONG_S, returns, soon, until

from armdrive.errors import LinkLost, NoSuchPort, PortForbidden, PortInUse, PortUnavailable
from armdrive.transports import ports
from armdrive.transports.link import Bell
from armdrive.transports.opening import open_link
from armdrive.transports.ports import PortHolder, holder, holders, refusal, terminal_user
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


def test_bytes_go_both_ways(ends, link):
    link.write(b"@READ\r", 0.0)
    assert os.read(ends[0], 100) == b"@READ\r"
    assert link.read(0.0) == b""
    os.write(ends[0], b"1\r")
    link.wait(LONG_S)
    assert link.read(0.0) == b"1\r"
    assert ends[1] in link.description
    assert "9600" in link.description
    assert link.next_s() == float("inf")


def test_a_wait_ends_with_bytes_with_a_wake_and_with_its_time(ends, link):
    link.wake()
    returns(lambda: link.wait(FOREVER_S))
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    soon(os.write, ends[0], b"x")
    returns(lambda: link.wait(FOREVER_S))
    assert link.read(0.0) == b"x"
    returns(lambda: link.wait(0.02))


def test_a_port_that_goes_away_is_told_in_words(ends, link):
    os.close(ends[2].pop())
    returns(lambda: link.wait(FOREVER_S))
    with pytest.raises(LinkLost, match="was lost") as lost:
        link.read(0.0)
    assert "Errno" not in str(lost.value)
    with pytest.raises(LinkLost):
        link.write(b"@READ\r", 0.0)


def test_a_port_that_is_not_there_is_said_so():
    with pytest.raises(PortUnavailable, match="there is no port"):
        SerialLink("/dev/no-such-port", 9600)


def test_a_link_may_be_closed_and_woken_twice(ends):
    link = SerialLink(ends[1], 9600)
    link.close()
    link.close()
    link.wake()


def test_a_reader_that_takes_nothing_is_a_lost_wire_and_no_hang(ends, link):
    link._port.write_timeout = 0.05
    with pytest.raises(LinkLost):
        link.write(b"x" * 1_000_000, 0.0)


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


@on_linux
def test_a_port_in_use_names_who_has_it(ends, monkeypatch):
    link = SerialLink(ends[1], 9600)
    with pytest.raises(PortInUse, match=rf"this one \(pid {os.getpid()}\): close the connection"):
        SerialLink(ends[1], 9600)
    monkeypatch.setattr(ports, "holder", lambda device: PortHolder(4711, "miniterm"))
    with pytest.raises(PortInUse, match=r"miniterm \(pid 4711\): end that program first"):
        SerialLink(ends[1], 9600)
    link.close()


def test_a_name_that_is_no_serial_port_is_refused(tmp_path):
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(NoSuchPort, match="is not a serial port"):
        SerialLink(str(file), 9600)


@every_row("address", ["telnet://host:23", "spy:///dev/ttyS0?file=log"])
def test_an_unknown_scheme_is_met_with_the_known_ones(address):
    with pytest.raises(PortUnavailable, match="socket://, rfc2217:// or udp://"):
        SerialLink(address, 9600)


def pyserial_error(number: int) -> serial.SerialException:
    text = os.strerror(number)
    return serial.SerialException(number, f"could not open port: [Errno {number}] {text}")


@pytest.mark.parametrize(
    ("group", "advice"),
    [
        ("dialout", "`sudo usermod -aG dialout $USER`, then log in again"),
        ("uucp", "`sudo usermod -aG uucp $USER`"),
        ("root", "udev rule"),
        (None, "udev rule"),
    ],
)
def test_a_forbidden_port_names_the_group_to_join(monkeypatch, group, advice):
    monkeypatch.setattr(ports, "owning_group", lambda device: group)
    error = refusal("/dev/ttyUSB0", pyserial_error(errno.EACCES))
    assert isinstance(error, PortForbidden)
    assert "no permission to open /dev/ttyUSB0" in str(error)
    assert advice in str(error)


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (pyserial_error(errno.ENOENT), NoSuchPort),
        (pyserial_error(errno.ENXIO), NoSuchPort),
        (pyserial_error(errno.EBUSY), PortInUse),
        (pyserial_error(errno.EAGAIN), PortInUse),
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
    assert ": " in str(made) or ". " in str(made)


def hangs_up(name: str) -> bool:
    fileno = os.open(name, os.O_RDWR | os.O_NOCTTY)
    try:
        return bool(termios.tcgetattr(fileno)[2] & termios.HUPCL)
    finally:
        os.close(fileno)


@on_linux
def test_a_port_can_be_told_to_keep_dtr_when_it_is_closed(ends):
    master, name, _ = ends
    settings = termios.tcgetattr(master)
    settings[2] |= termios.HUPCL
    termios.tcsetattr(master, termios.TCSANOW, settings)
    SerialLink(name, 9600).close()
    assert hangs_up(name)  # nobody asked
    link = SerialLink(name, 9600, raise_dtr=True, keep_dtr_on_close=True)
    link.close()
    assert not hangs_up(name)
    SerialLink(name, 9600).close()
    assert not hangs_up(name)  # it lasts
    assert not link.keep_dtr_on_close()  # closed: nothing to tell it to


def test_a_file_that_is_no_terminal_has_no_dtr(tmp_path):
    with (tmp_path / "file").open("w") as file:
        assert not clear_hupcl(file.fileno())


@on_linux
def test_the_holder_of_an_open_device_is_found_by_its_links(ends, tmp_path):
    _, name, _ = ends
    link = tmp_path / "arm"
    link.symlink_to(name)
    assert holder(name) is None
    fileno = os.open(name, os.O_RDWR | os.O_NOCTTY)
    try:
        found = holders([name, str(link), "/dev/no-such-port"])
    finally:
        os.close(fileno)
    assert set(found) == {name, str(link)}
    assert found[name].pid == os.getpid()
    assert found[name].program


@on_linux
@pytest.mark.parametrize("address", ["{}", "can:slcan:{}?bitrate=500000"])
def test_the_terminal_of_another_program_is_not_opened(ends, tmp_path, address):
    """The link of a killed simulator leads to the next terminal that takes the same number."""
    _, name, _ = ends
    link = tmp_path / "arm"
    link.symlink_to(name)
    shell = subprocess.Popen(["sh", "-c", f"exec cat < {name}"], start_new_session=True)
    try:
        until(lambda: terminal_user(name) is not None)
        with pytest.raises(PortInUse, match=rf"arm is the terminal .* \(pid {shell.pid}\): remove"):
            open_link(address.format(link), 9600)
        assert terminal_user(name).pid == shell.pid
    finally:
        shell.kill()
        shell.wait()
    assert terminal_user(name) is None
    SerialLink(str(link), 9600).close()


@on_linux
@pytest.mark.parametrize("address", ["{}", "can:slcan:{}?bitrate=500000"])
def test_the_link_of_a_killed_simulator_leads_to_no_other_simulator(ends, tmp_path, address):
    _, name, _ = ends
    link = tmp_path / "arm"
    link.symlink_to(name)
    os.utime(link, ns=(0, 0), follow_symlinks=False)  # made before this pseudo-terminal was
    with pytest.raises(PortUnavailable, match=f"arm is a link that .* {name} now belongs to"):
        open_link(address.format(link), 9600)
    link.unlink()
    link.symlink_to(name)
    SerialLink(str(link), 9600).close()


def test_processes_that_cannot_be_looked_at_are_passed_over(monkeypatch, tmp_path):
    monkeypatch.setattr(ports, "PROC", tmp_path)
    for pid, target in (("12", "/dev/other"), ("7", "/dev/arm"), ("9", "/dev/arm")):
        (tmp_path / pid / "fd").mkdir(parents=True)
        (tmp_path / pid / "fd" / "3").symlink_to(target)
    (tmp_path / "7" / "comm").write_text("miniterm\n")
    (tmp_path / "5").mkdir()  # no fd: somebody else's
    (tmp_path / "self").mkdir()
    assert holders(["/dev/arm"]) == {"/dev/arm": PortHolder(7, "miniterm")}
    assert holders(["/dev/other"]) == {"/dev/other": PortHolder(12, "unknown")}
    monkeypatch.setattr(ports, "PROC", tmp_path / "nowhere")
    assert holders(["/dev/arm"]) == {}
