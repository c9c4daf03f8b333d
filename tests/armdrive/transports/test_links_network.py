"""Links over the network, and the serial ports of a computer."""

import socket
import sys
import threading
from types import SimpleNamespace

import pytest
import serial
from amounts import every_row
from serial.rfc2217 import PortManager
from serial.tools import list_ports as pyserial
from waiting import FOREVER_S, LONG_S, looks, returns, soon

from armdrive.errors import BadRequest, LinkLost, NoConnection, NoSuchPort
from armdrive.transports import udp
from armdrive.transports.address import host_and_port, scheme
from armdrive.transports.link import AbsentLink
from armdrive.transports.opening import open_link
from armdrive.transports.ports import PortInfo, device_names, list_ports
from armdrive.transports.serial_port import SerialLink
from armdrive.transports.udp import UdpLink

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


def unused_port() -> int:
    with socket.create_server((LOOPBACK, 0)) as server:
        return server.getsockname()[1]


def test_a_tcp_link_carries_bytes_both_ways_and_wakes(listener):
    url = f"socket://{LOOPBACK}:{listener.getsockname()[1]}"
    link = open_link(url, 9600)
    client, _ = listener.accept()
    client.settimeout(LONG_S)
    assert link.description == url
    link.write(b"@READ\r", 0.0)
    assert client.recv(100) == b"@READ\r"
    assert link.read(0.0) == b""
    soon(client.sendall, b"x" * 1000)
    assert heard(link, 1000) == b"x" * 1000
    client.sendall(b"y" * 200)
    link.wait(LONG_S)
    assert link.read(0.0) == b"y" * 200  # all in one read
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    assert link.next_s() == float("inf")
    client.close()
    link.wait(LONG_S)
    with pytest.raises(LinkLost, match=r"check the network, then call `reconnect\(\)`"):
        link.read(0.0)
    link.close()
    link.close()


def test_a_refused_connection_says_what_to_do():
    url = f"socket://{LOOPBACK}:{unused_port()}"
    with pytest.raises(NoConnection, match="refused the connection: start the program") as error:
        open_link(url, 9600)
    assert url in str(error.value)


def test_other_failures_to_connect_say_what_to_do(monkeypatch):
    failures = [
        (TimeoutError("timed out"), "check that the host is on"),
        (socket.gaierror(-2, "Name or service not known"), "correct the name"),
        (OSError(101, "Network is unreachable"), "check the address and the network"),
    ]
    for failure, advice in failures:

        def fail(*args, failure=failure, **kwargs):
            raise failure

        monkeypatch.setattr(socket, "create_connection", fail)
        for kind in ("socket", "rfc2217"):
            with pytest.raises(NoConnection, match=advice):
                open_link(f"{kind}://arm.example:2217", 9600)


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
    assert not link.keep_dtr_on_close()
    link.close()
    server.join(LONG_S)


def test_a_udp_link_sends_one_datagram_a_write_and_appends_what_comes(peer):
    link = open_link(f"udp://{LOOPBACK}:{peer.getsockname()[1]}", 9600)
    link.write(b"@STEP 200,1", 0.0)
    link.write(b"", 0.0)
    link.write(b",2\r", 0.0)
    first, address = peer.recvfrom(100)
    assert (first, peer.recv(100)) == (b"@STEP 200,1", b",2\r")
    assert link.read(0.0) == b""
    for datagram in (b"off", b"", b"sets\r"):
        peer.sendto(datagram, address)
    assert heard(link, 8) == b"offsets\r"
    assert link.next_s() == float("inf")
    assert link.description == f"udp://{LOOPBACK}:{peer.getsockname()[1]}"
    link.close()
    link.close()
    returns(lambda: link.wait(FOREVER_S))  # of a closed link: at once
    link.wake()


def test_a_udp_link_sleeps_until_a_datagram_a_wake_or_its_time(peer):
    link = UdpLink(LOOPBACK, peer.getsockname()[1])
    link.write(b"?", 0.0)
    _, address = peer.recvfrom(100)
    link.wait(0.01)
    soon(peer.sendto, b"x", address)
    returns(lambda: link.wait(FOREVER_S))
    assert link.read(0.0) == b"x"
    soon(link.wake)
    returns(lambda: link.wait(FOREVER_S))
    link.close()


def test_a_link_that_is_gone_sleeps_until_its_time_or_a_wake():
    link = AbsentLink("/dev/ttyGONE")
    returns(lambda: link.wait(0.01))
    sleeping = threading.Thread(target=link.wait, args=(FOREVER_S,))
    sleeping.start()
    sleeping.join(0.02)
    assert sleeping.is_alive()
    link.wake()
    sleeping.join(LONG_S)
    assert not sleeping.is_alive()
    link.close()


def test_a_udp_link_hears_its_own_peer_alone(peer):
    link = UdpLink(LOOPBACK, peer.getsockname()[1])
    link.write(b"?", 0.0)
    _, address = peer.recvfrom(100)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"stray", address)
    peer.sendto(b"mine", address)
    assert heard(link, 4) == b"mine"
    link.close()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems may not tell")
def test_a_udp_peer_that_does_not_listen_is_a_lost_link(peer):
    link = UdpLink(LOOPBACK, peer.getsockname()[1])
    peer.close()
    link.write(b"?", 0.0)
    link.wait(LONG_S)
    with pytest.raises(LinkLost, match="no program listens there"):
        link.read(0.0)
    with pytest.raises(LinkLost, match="Message too long"):
        link.write(b"x" * (udp.LONGEST_BYTES + 1), 0.0)
    link.close()


def test_a_udp_host_that_is_not_known_is_refused(monkeypatch):
    def fail(*args, **kwargs):
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", fail)
    with pytest.raises(NoConnection, match="correct the name"):
        open_link("udp://arm.example:2217", 9600)


# -- Ports -----------------------------------------------------------------------------------------

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
    assert bare == PortInfo(str(adapter[1]))
    assert (usb.device, usb.description) == (str(adapter[0]), "USB2.0-Serial")
    assert (usb.vid, usb.pid, usb.manufacturer) == (0x1A86, 0x7523, "QinHeng")
    assert usb.readable
    assert usb.holder is None


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
