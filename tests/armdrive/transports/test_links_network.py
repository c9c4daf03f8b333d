"""Links over the network: TCP, a serial port at another computer, and UDP."""

import socket
import sys
import threading

import pytest
import serial
from amounts import every_row
from serial.rfc2217 import PortManager
from waiting import FOREVER_S, LONG_S, looks, returns, soon

from armdrive.errors import BadRequest, LinkLost, NoConnection
from armdrive.transports import udp
from armdrive.transports.address import host_and_port, scheme
from armdrive.transports.link import AbsentLink
from armdrive.transports.opening import open_link

LOOPBACK = "127.0.0.1"


@pytest.fixture
def listener():
    made = socket.create_server((LOOPBACK, 0))
    yield made
    made.close()


@pytest.fixture
def peer():
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind((LOOPBACK, 0))
    made.settimeout(LONG_S)
    yield made
    made.close()


def heard(link, enough: int) -> bytes:
    """Read as the engine does: sleep on the link, then take what is there."""
    data = b""
    for _ in looks("the bytes never came"):
        data += link.read(0.0)
        if len(data) >= enough:
            break
        link.wait(LONG_S)
    return data


def test_a_tcp_link_carries_bytes_both_ways_and_wakes(listener):
    url = f"socket://{LOOPBACK}:{listener.getsockname()[1]}"
    link = open_link(url, 9600)
    client, _ = listener.accept()
    client.settimeout(LONG_S)
    assert link.description == url
    link.write(b"@READ\r", 0.0)
    assert client.recv(100) == b"@READ\r"
    soon(client.sendall, b"x" * 1000)
    assert heard(link, 1000) == b"x" * 1000
    client.sendall(b"y" * 200)
    link.wait(LONG_S)
    assert link.read(0.0) == b"y" * 200  # all in one read
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    client.close()
    link.wait(LONG_S)
    with pytest.raises(LinkLost, match=r"check the network, then call `reconnect\(\)`"):
        link.read(0.0)
    link.close()
    link.close()


def test_a_host_that_cannot_be_reached_says_what_to_do(monkeypatch):
    def fail(*args, **kwargs):
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "create_connection", fail)
    monkeypatch.setattr(socket, "getaddrinfo", fail)
    for kind in ("socket", "rfc2217", "udp"):
        url = f"{kind}://arm.example:2217"
        with pytest.raises(NoConnection, match=rf"{url} .*service not known\): check the address"):
            open_link(url, 9600)


@every_row("url", ["socket://host", "rfc2217://:23", "udp://host:0", "udp://h:x"])
def test_an_address_without_host_and_port_is_refused_before_anything_is_opened(url):
    with pytest.raises(BadRequest, match="write host and port number"):
        open_link(url, 9600)


def test_addresses_are_read():
    assert host_and_port("udp://192.168.4.1:2217") == ("192.168.4.1", 2217)
    assert host_and_port("socket://[::1]:23") == ("::1", 23)
    assert [scheme(name) for name in ("COM3", "/dev/ttyUSB0", "UDP://h:1")] == ["", "", "udp"]


def serve_rfc2217(listener: socket.socket, ready: threading.Event) -> None:
    """Be a serial port at another computer whose wire sends everything back."""
    client, _ = listener.accept()
    client.settimeout(LONG_S)
    wire = serial.serial_for_url("loop://", timeout=0)

    class Connection:
        def write(self, data):
            client.sendall(data)

    manager = PortManager(wire, Connection())
    ready.set()
    while data := client.recv(1024):
        wire.write(b"".join(manager.filter(data)))
        client.sendall(b"".join(manager.escape(wire.read(wire.in_waiting))))
    wire.close()
    client.close()


def test_an_rfc2217_link_carries_bytes_and_its_baud_rate(listener):
    ready = threading.Event()
    server = threading.Thread(target=serve_rfc2217, args=(listener, ready))
    server.start()
    link = open_link(f"rfc2217://{LOOPBACK}:{listener.getsockname()[1]}", 19200)
    assert ready.is_set()
    assert "19200 baud" in link.description
    link.write(b"\xff1,2,3\r", 0.0)  # 255 is telnet's own sign and has to be doubled on the way
    assert heard(link, 7) == b"\xff1,2,3\r"
    returns(lambda: link.wait(FOREVER_S))  # polled: it returns soon, with or without bytes
    link.close()
    server.join(LONG_S)


def test_a_udp_link_sends_one_datagram_a_write_and_hears_its_own_peer_alone(peer):
    link = open_link(f"udp://{LOOPBACK}:{peer.getsockname()[1]}", 9600)
    link.write(b"@STEP 200,1", 0.0)
    link.write(b"", 0.0)
    link.write(b",2\r", 0.0)
    first, address = peer.recvfrom(100)
    assert (first, peer.recv(100)) == (b"@STEP 200,1", b",2\r")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"stray", address)
    for datagram in (b"off", b"", b"sets\r"):
        peer.sendto(datagram, address)
    assert heard(link, 8) == b"offsets\r"
    assert link.description == f"udp://{LOOPBACK}:{peer.getsockname()[1]}"
    link.wait(0.01)
    soon(peer.sendto, b"x", address)
    returns(lambda: link.wait(FOREVER_S))
    assert link.read(0.0) == b"x"
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    link.close()
    link.close()
    returns(lambda: link.wait(FOREVER_S))  # of a closed link: at once
    link.wake()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems may not tell")
def test_a_udp_peer_that_does_not_listen_is_a_lost_link(peer):
    link = open_link(f"udp://{LOOPBACK}:{peer.getsockname()[1]}", 9600)
    peer.close()
    link.write(b"?", 0.0)
    link.wait(LONG_S)
    with pytest.raises(LinkLost, match="no program listens there"):
        link.read(0.0)
    with pytest.raises(LinkLost, match="Message too long"):
        link.write(b"x" * (udp.LONGEST_BYTES + 1), 0.0)
    link.close()


def test_a_link_that_is_gone_sleeps_until_its_time_or_a_wake():
    link = AbsentLink("/dev/ttyGONE")
    returns(lambda: link.wait(0.01))
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    with pytest.raises(LinkLost):
        link.read(0.0)
    link.close()
