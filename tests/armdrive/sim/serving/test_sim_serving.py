"""Simulated devices that are served in real time, and their console."""

import contextlib
import json
import os
import select
import signal
import socket
import sys
import threading

import pytest
import serial
from served import ServedDevice
from waiting import LONG_S, until

from armdrive.errors import PortUnavailable
from armdrive.sim.device import SimDevice
from armdrive.sim.serving import MOST_BACKLOG, ServeLoop, make_server, run_device
from armdrive.sim.serving.console import COMMANDS, Console
from armdrive.sim.serving.servers import PtyServer, TcpServer, UdpServer
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.wire import DeviceLine
from armdrive.transports.link import Bell

needs_pty = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no pseudo-terminals; TCP is the way there"
)
needs_signals = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows cannot send itself these signals"
)


@pytest.fixture
def serve():
    running = []

    def start(server, *faults):
        running.append(ServedDevice(server, SimDevice(TeachMoverBoard()), *faults))
        return running[-1]

    yield start
    for each in running:
        each.end()


NOTHING = b"@STEP 0,0,0,0,0,0,0\r"


def dial(server):
    """Connect to a TCP server."""
    return socket.create_connection(("127.0.0.1", server.port), LONG_S)


def said(client, request):
    """Send a request and return its first answer."""
    client.sendall(request)
    return read_line(client)


def read_line(client):
    """Read until CR from a socket."""
    said = b""
    while not said.endswith(b"\r"):
        data = client.recv(100)
        assert data, "the device hung up"
        said += data
    return said


def _end_once(seen, number=signal.SIGTERM):
    """Send this process a signal once something is seen."""
    until(seen)
    os.kill(os.getpid(), number)


class TestTcp:
    def test_a_motion_is_made_and_answered(self, serve):
        running = serve(TcpServer())
        with dial(running.server) as client:
            began_s = json.loads(running.tell("state --json"))["time_s"]
            assert said(client, b"@STEP 240, 40,0,0,0,0,0\r") == b"1\r"
            ended_s = json.loads(running.tell("state --json"))["time_s"]
            assert ended_s - began_s >= 40 / 470 + 26 * 10 / 9600
        assert running.device.registers == (40, 0, 0, 0, 0, 0)

    def test_one_client_at_a_time_and_then_the_next(self, serve):
        server = serve(TcpServer()).server
        with dial(server) as first:
            assert said(first, NOTHING) == b"1\r"
            with dial(server) as second:
                assert second.recv(10) == b""
            assert said(first, NOTHING) == b"1\r"
        with dial(server) as third:
            assert said(third, NOTHING) == b"1\r"

    def test_unplugged_and_plugged_in_again(self, serve):
        running = serve(TcpServer())
        address = f"socket://127.0.0.1:{running.server.port}"
        with dial(running.server) as client:
            assert said(client, NOTHING) == b"1\r"
            running.tell("unplug")
            assert client.recv(10) == b""
        running.tell("replug")
        assert running.server.address == address
        with dial(running.server) as client:
            assert said(client, NOTHING) == b"1\r"

    @pytest.mark.parametrize("kind", ["tcp", "udp"])
    def test_a_port_that_is_taken_is_refused_in_words(self, kind):
        taken = make_server(**{kind: "0"})
        with pytest.raises(PortUnavailable, match="choose another port"):
            make_server(**{kind: f":{taken.port}"})
        taken.close()

    @pytest.mark.parametrize("address", ["", "host", "1.2.3.4:", "localhost:x", ":-1"])
    def test_an_address_without_a_port_is_refused(self, address):
        with pytest.raises(PortUnavailable, match="HOST:PORT"):
            make_server(tcp=address)


class TestUdp:
    def test_each_datagram_is_answered_by_one_to_whoever_spoke_last(self, serve):
        running = serve(UdpServer())
        where = ("127.0.0.1", running.server.port)
        for _ in range(2):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
                client.settimeout(LONG_S)
                client.sendto(b"@STEP 240,40,0,0,0,0,0\r", where)
                assert client.recv(100) == b"1\r"
                client.sendto(b"@READ\r", where)
                assert client.recv(100).startswith(b"1\r")
        assert running.device.registers == (80, 0, 0, 0, 0, 0)


class TestFaults:
    def test_a_fault_of_the_command_line_befalls_a_served_arm(self, serve):
        running = serve(TcpServer(), "drop:#3,from=host", "stall:1")
        with dial(running.server) as client:
            assert said(client, b"@READ\r") == b"0\r"
            before = running.device.world.motors
            assert said(client, b"@STEP 240,40,0,0,0,0,0\r") == b"1\r"
        assert running.device.world.motors == before

    @needs_pty
    def test_the_cable_comes_back_as_another_port(self, serve, tmp_path):
        running = serve(PtyServer(tmp_path / "arm"))
        running.tell("unplug")
        running.tell(f"fault replug {tmp_path / 'arm2'} @0.05")
        until((tmp_path / "arm2").is_symlink)
        assert not (tmp_path / "arm").is_symlink()


class TestConsole:
    @needs_signals
    def test_the_end_of_the_commands_ends_nothing_but_their_last_line_counts(self):
        ear, mouth = os.pipe()
        os.write(mouth, b"state\nput A 200 0")
        os.close(mouth)
        device, replies = SimDevice(TeachMoverBoard()), []
        put = lambda: "A" in device.world.scene.blocks  # noqa: E731
        ending = threading.Thread(target=_end_once, args=(put,))
        ending.start()
        run_device(device, TcpServer(), ear, replies.append)
        ending.join()
        os.close(ear)
        assert "A" in device.world.scene.blocks
        assert len(replies) == 2

    @needs_signals
    @pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
    def test_a_signal_ends_it_cleanly(self, number, tmp_path):
        link = tmp_path / "arm"
        server = PtyServer(link)
        before = signal.getsignal(number)
        taken = lambda: signal.getsignal(number) is not before  # noqa: E731
        ending = threading.Thread(target=_end_once, args=(taken, number))
        ending.start()
        run_device(SimDevice(TeachMoverBoard()), server, None, print)
        ending.join()
        assert not link.is_symlink()
        assert signal.getsignal(number) is before


@needs_pty
class TestPty:
    def test_a_program_for_the_real_arm_runs_against_it(self, serve, tmp_path):
        link = tmp_path / "arm"
        running = serve(PtyServer(link))
        with serial.Serial(str(link), 9600, timeout=LONG_S) as port:
            port.write(b"@STEP 240, 100,0,0,0,0,0\r")
            assert port.read_until(b"\r") == b"1\r"
            port.write(b"@READ\r")
            assert port.read_until(b"\r") == b"1\r"
            assert port.read_until(b"\r") == b"100,0,0,0,0,0,0\r"
        assert running.device.registers == (100, 0, 0, 0, 0, 0)

    def test_bytes_go_through_raw(self, serve, tmp_path):
        running = serve(PtyServer(tmp_path / "arm"))
        client = os.open(running.server.address, os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(client, b"@BAD\x03\x04\r")
            said = b""
            while not said.endswith(b"\r"):
                assert select.select([client], [], [], LONG_S)[0]
                said += os.read(client, 10)
            assert said == b"0\r"
        finally:
            os.close(client)

    def test_pulled_out_its_other_end_breaks_and_the_link_is_gone(self, serve, tmp_path):
        link = tmp_path / "arm"
        running = serve(PtyServer(link))
        client = os.open(link, os.O_RDWR | os.O_NOCTTY)
        try:
            running.tell("unplug")
            assert not link.is_symlink()
            with pytest.raises(OSError, match="Input/output"):
                os.read(client, 1) or os.write(client, b"x")
        finally:
            os.close(client)
        running.tell("replug")
        assert str(link.readlink()).startswith("/dev/")

    def test_it_replaces_the_link_of_a_killed_one_that_leads_to_another_simulation(self, tmp_path):
        other = PtyServer()
        link = tmp_path / "arm"
        link.symlink_to(other.address)
        os.utime(link, ns=(0, 0), follow_symlinks=False)  # from before the other one began
        server = PtyServer(link)
        assert str(link.readlink()) != other.address
        server.close()
        other.close()

    @pytest.mark.parametrize("kind", ["file", "elsewhere", "alive"])
    def test_it_replaces_nothing_else(self, tmp_path, kind):
        link, other = tmp_path / "arm", None
        if kind == "file":
            link.write_text("mine")
        elif kind == "elsewhere":
            link.symlink_to(tmp_path / "nowhere")
        else:
            other = PtyServer(link)
        with pytest.raises(PortUnavailable, match="choose another path"):
            PtyServer(link)
        assert os.path.lexists(link)
        if other:
            other.close()

    def test_bytes_that_nobody_reads_are_dropped(self, tmp_path):
        server = PtyServer()
        for _ in range(100):
            server.write(bytes(4096))
        assert server.read() == b""
        server.close()
        server.close()
        assert server.filenos() == ()


# -- The console -----------------------------------------------------------------------------------


class Wire:
    """A server that only remembers whether it is offered."""

    address = "here"

    def __init__(self):
        self.is_open = True

    def open(self, address=None):
        self.is_open = True
        self.address = address or self.address

    def close(self):
        self.is_open = False

    def filenos(self):
        return ()

    def read(self):
        return b""

    def write(self, data):
        pass


class Flood(Wire):
    """A server whose client always has more to say."""

    paced, taken = True, 0

    def read(self):
        self.taken += MOST_BACKLOG
        return bytes(MOST_BACKLOG)


def test_a_client_that_floods_the_line_has_to_wait_for_it():
    flood = Flood()
    with contextlib.closing(Bell()) as bell:
        loop = ServeLoop(SimDevice(TeachMoverBoard()), flood, print, bell)
        loop.begin(())
        for _ in range(100):
            loop.turn()
    assert 0 < flood.taken < 50 * MOST_BACKLOG  # each of them takes four seconds on the line


@pytest.fixture
def console():
    device = SimDevice(TeachMoverBoard())
    return Console(device, Wire(), DeviceLine(device, device.board.baud))


def state(console):
    return json.loads(console.answer("state --json"))


def test_state_tells_the_physical_arm_in_words_and_as_data(console):
    line = console.answer("state")
    assert "power on" in line
    assert "still" in line
    told = state(console)
    assert told["motors"] == list(console.device.world.motors)
    assert told["registers"] == [0] * 6
    assert told["pose"]["x_mm"] == pytest.approx(console.device.world.pose.x_mm, abs=0.001)
    assert told["joints_deg"]["shoulder"] == pytest.approx(70, abs=0.05)


def test_somebody_guides_the_arm_to_its_reference_posture(console):
    before = console.device.registers
    assert "reference posture" in console.answer("guide")
    world = console.device.world
    assert world.pose.x_mm == pytest.approx(127.0, abs=0.3)
    assert world.pose.z_mm == pytest.approx(0.0, abs=0.3)
    assert console.device.registers != before  # the pendant's moves are counted


def test_blocks_are_put_and_taken(console):
    assert "z 0.0" in console.answer("put A 200 10 30 20")
    assert "z 20.0" in console.answer("put B 200 10")
    assert [block["name"] for block in state(console)["blocks"]] == ["A", "B"]
    assert console.device.world.scene.blocks["A"].height_mm == 20
    assert console.device.world.scene.blocks["B"].width_mm == 25
    console.answer("take A")
    assert console.device.world.scene.blocks["B"].z_mm == 0
    assert "there are: B" in console.answer("take A")


@pytest.mark.parametrize(("line", "where"), [("replug", "here"), ("replug as there", "there")])
def test_the_cable_is_pulled_and_put_back_perhaps_under_another_name(console, line, where):
    assert console.answer("unplug") == "unplug: the cable is pulled"
    assert not console.server.is_open
    assert console.answer("fault") == "unplug"
    console.answer(line)
    assert console.server.is_open
    assert console.server.address == where
    assert console.answer("fault") == "no faults"


def test_faults_are_begun_listed_and_ended(console):
    assert console.answer("fault") == "no faults"
    assert console.answer("fault stall 2") == "stall 2: a motor no longer follows"
    for words in ("", "fault "):
        answer = console.answer(f"{words}drop 0.5 from=host for=2 seed=3 @60")
        assert answer == "drop 0.5 in 60 s: bytes, or frames of a bus, are lost"
    console.answer("mute")
    assert state(console)["stalled"] == [2]
    assert json.loads(console.answer("fault --json")) == {"faults": ["stall 2", "mute"]}
    assert console.answer("fault off stall") == "ended: stall 2"
    assert console.answer("fault") == "mute"
    assert state(console)["stalled"] == []
    assert console.answer("fault off") == "ended: mute"
    assert console.answer("fault off") == "ended: nothing"


def test_inputs_and_pushes(console):
    console.answer("input 4 1")
    assert state(console)["inputs"] == 8
    console.answer("input 4 off")
    assert state(console)["inputs"] == 0
    before = console.device.world.motors
    console.answer("push 2 -15")
    assert console.device.world.motors - before == (0, -15, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sate", "did you mean 'state'?"),
        ("xyzzy", "help"),
        ("put A 1", "put NAME X Y [WIDTH [HEIGHT]]"),
        ("put A one 2", "'one' is not a number"),
        ("put A nan 2", "finite"),
        ("put A 1 2 -3", "wider"),
        ("push 7 10", "1 to 6 or base, shoulder, elbow, right_wrist"),
        ("push 1 half", "not a whole number"),
        ("input 1 1", "grip switch"),
        ("input 9 1", "numbered 1 to 8"),
        ("input 0 1", "numbered 1 to 8"),
        ("power maybe", "neither on nor off"),
        ("return", "no control"),
        ("fault flood", "there is no fault 'flood'"),
        ("fault no-done 1", "has no drives on a bus"),
        ("fault drive-foo", "there are drop, corrupt, duplicate, delay, mute, garbage, unplug"),
        ("fault reset", "no reset"),
        ("quit now", "write it like this: quit"),
    ],
)
def test_a_wrong_line_is_answered_by_one_sentence(console, line, said):
    before = state(console)
    answer = console.answer(line)
    assert said in answer
    assert "\n" not in answer
    assert json.loads(console.answer(line + " --json")) == {"ok": False, "error": answer}
    assert state(console) == before


def test_every_command_is_in_the_help(console):
    told = json.loads(console.answer("help --json"))
    board = console.device.board
    there = {each.name for each in COMMANDS.values() if isinstance(board, each.needs)}
    assert [usage.split()[0] for usage in told] == [name for name in COMMANDS if name in there]
    assert set(COMMANDS) - there == {"plug"}
    rows = console.answer("help").splitlines()
    for row, (usage, summary) in zip(rows, told.items(), strict=True):
        assert row.split() == [*usage.split(), *summary.split()]
