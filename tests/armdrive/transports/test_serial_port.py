"""The real port's link, against a pseudo-terminal: bytes, waking, loss, and who may open it."""

import os
import pty
import sys
import tty

import pytest
from waiting import FOREVER_S, LONG_S, returns, soon

from armdrive.errors import LinkLost, PortUnavailable
from armdrive.transports.link import Bell
from armdrive.transports.serial_port import SerialLink

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")


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
    with pytest.raises(LinkLost, match="was lost"):
        link.read(0.0)
    with pytest.raises(LinkLost):
        link.write(b"@READ\r", 0.0)


def test_a_port_is_opened_by_one_program_alone(ends, link):
    with pytest.raises(PortUnavailable, match="in use by another program"):
        SerialLink(ends[1], 9600)


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
