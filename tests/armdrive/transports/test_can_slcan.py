"""A serial CAN adapter on a pseudo-terminal: opened, spoken to, broken, lost and found again."""

import contextlib
import re
import sys
import threading
from pathlib import Path

import can
import pytest
from waiting import soon, until

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

from can_bench import LONG_S, frames_of, until_lost
from can_served import Served

from armdrive.errors import NoConnection, NoSuchPort, PortInUse, PortUnavailable
from armdrive.sim.serving.servers import PtyServer
from armdrive.transports import can_link, can_slcan
from armdrive.transports.can_health import BusState
from armdrive.transports.link import Bell
from armdrive.transports.opening import open_link
from firmware_protocol.frames import Frame, pack


@pytest.fixture(autouse=True)
def short_patience(monkeypatch):
    monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", 0.1)
    monkeypatch.setattr(can_link, "RECV_S", 0.01)


@pytest.fixture
def served(tmp_path):
    made = Served(tmp_path / "adapter")
    yield made
    made.end()


@pytest.fixture
def opened(served):
    link = open_link(served.server.can_addresses[0], 0)
    yield link
    link.close()


def test_frames_pass_and_are_answered(served, opened, monkeypatch):
    monkeypatch.setattr(can_slcan, "MOST_LINES", 10)
    assert opened.description == f"can:slcan:{served.server.address} at 500 kbit/s"
    sent = [Frame(each, bytes(range(each))) for each in range(9)]
    opened.write(b"".join(map(pack, sent)), 0.0)
    assert frames_of(opened, 9) == [Frame(each.can_id + 1, each.data) for each in sent]
    assert (opened.health.received, opened.health.refused) == (9, 0)
    assert len(opened._bus._received_lines) <= 10


def test_closing_while_the_interpreter_ends_starts_no_thread(opened, monkeypatch):
    started = []
    monkeypatch.setattr(sys, "is_finalizing", lambda: True)
    monkeypatch.setattr(threading.Thread, "start", started.append)
    opened.close()
    monkeypatch.undo()
    assert not started
    opened._shut_down()


class TestOpening:
    def test_a_second_program_is_turned_away_and_disturbs_nobody(self, served, opened):
        with pytest.raises(PortInUse):
            open_link(served.server.can_addresses[0], 0)
        opened.write(pack(Frame(1)), 0.0)
        assert frames_of(opened) == [Frame(2)]

    def test_an_adapter_that_sleeps_at_first_is_waited_for(self, served, monkeypatch):
        monkeypatch.setattr(can_slcan, "GREETING_S", 0.1)
        monkeypatch.setattr(can_slcan, "GREETINGS", 1000)  # however busy the computer is
        served.server.adapters[0].faults.dead = True
        soon(setattr, served.server.adapters[0].faults, "dead", False)
        with contextlib.closing(open_link(served.server.can_addresses[0], 0)) as link:
            link.write(pack(Frame(1)), 0.0)
            assert frames_of(link) == [Frame(2)]
            assert link.health.refused == 0

    def test_an_adapter_of_few_words_is_understood(self, served, monkeypatch):
        monkeypatch.setattr(can_slcan, "GREETING_S", 0.1)
        served.server.adapters[0].faults.mute = True
        with contextlib.closing(open_link(served.server.can_addresses[0], 0)) as link:
            link.write(pack(Frame(1)), 0.0)
            assert frames_of(link) == [Frame(2)]

    @pytest.mark.parametrize("reply", [b"\r", b"\a", b"z\r"])
    def test_an_adapter_without_a_version_is_known_by_its_other_replies(
        self, tmp_path, monkeypatch, reply
    ):
        monkeypatch.setattr(can_slcan, "GREETING_S", 0.1)
        with contextlib.closing(PtyServer(tmp_path / "plain")) as port:
            answering = threading.Thread(target=answer_once, args=(port, reply))
            answering.start()
            open_link(f"can:slcan:{port.address}?bitrate=500000", 0).close()
            answering.join(LONG_S)

    def test_a_device_that_is_no_adapter_is_recognised(self, tmp_path, monkeypatch):
        monkeypatch.setattr(can_slcan, "GREETING_S", 0.02)
        port = PtyServer(tmp_path / "other")
        where = f"can:slcan:{port.address}?bitrate=500000"
        with pytest.raises(NoConnection, match=r"sends nothing.*candleLight"):
            open_link(where, 0)
        for words in (b"Grbl 1.1f ['$' for help]\r\n", b"C\rS6\r\rO\rO\rV\r"):
            port.read()  # what was asked before
            answering = threading.Thread(target=answer_once, args=(port, words))
            answering.start()
            with pytest.raises(NoConnection, match="which no slcan adapter does"):
                open_link(where, 0)
            answering.join(LONG_S)
        with (
            contextlib.closing(open_link(f"{where}&sleep_after_open=0", 0)) as link,
            pytest.raises(can.CanTimeoutError),  # nobody reads it
        ):
            link._bus._put(bytes(1_000_000), 0.05)
        port.close()

    def test_a_port_that_is_not_there_and_a_bit_rate_that_none_has(self, served):
        with pytest.raises(NoSuchPort, match="candleLight"):
            open_link("can:slcan:/dev/no-such-adapter?bitrate=500000", 0)
        with pytest.raises(PortUnavailable, match="choose one of"):
            open_link(f"can:slcan:{served.server.address}?bitrate=123", 0)
        plain = f"can:slcan:{served.server.address}"
        for options in ("", "?listen_only=true", "?ids=1,2"):
            wanted = re.escape(f"{plain} names no bit rate") + f".*{re.escape(plain)}[?]bitrate"
            with pytest.raises(PortUnavailable, match=wanted):
                open_link(f"{plain}{options}", 0)
        with pytest.raises(PortUnavailable, match="check its channel"):
            open_link("can:slcan:?bitrate=500000", 0)


class TestLosses:
    def test_at_a_wrong_bit_rate_the_first_frame_tells(self, served):
        where = f"can:slcan:{served.server.address}?bitrate=250000"
        with contextlib.closing(open_link(where, 0)) as link:
            link.write(pack(Frame(1)), 0.0)
            assert "all have one bit rate" in until_lost(link)
            assert link.health.refused >= 1
        assert served.drive.heard == []

    def test_an_adapter_that_refused_a_frame_and_takes_the_next_is_no_loss(
        self, opened, monkeypatch
    ):
        monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", LONG_S)
        for line, state in ((b"\a", BusState.PASSIVE), (b"z", BusState.ACTIVE)):
            opened._bus._take(line)
            until(lambda state=state: opened.health.state is state)

    def test_bus_off_is_told_and_reopening_mends_it(self, served, opened):
        served.server.adapters[0].faults.bus_off = True
        opened.write(pack(Frame(1)), 0.0)
        until_lost(opened)
        opened.close()
        with contextlib.closing(open_link(served.server.can_addresses[0], 0)) as link:
            link.write(pack(Frame(3)), 0.0)
            assert frames_of(link) == [Frame(4)]
            assert link.health.state is BusState.ACTIVE

    def test_an_unplugged_adapter_is_lost_at_once_and_found_under_another_name(
        self, served, opened, tmp_path
    ):
        served.unplug()
        assert "gone" in until_lost(opened)
        opened.close()
        assert not opened._bus.serialPortOrig.is_open
        with pytest.raises(NoSuchPort):
            open_link(served.server.can_addresses[0], 0)
        served.replug(tmp_path / "elsewhere")
        with contextlib.closing(open_link(served.server.can_addresses[0], 0)) as link:
            link.write(pack(Frame(1)), 0.0)
            assert frames_of(link) == [Frame(2)]

    def test_nothing_is_left_open_after_all_of_that(self, served):
        with pytest.raises(PortUnavailable):
            open_link(f"can:slcan:{served.server.address}?bitrate=123", 0)
        open_link(served.server.can_addresses[0], 0).close()
        before = open_files()
        for _ in range(3):
            with contextlib.closing(open_link(served.server.can_addresses[0], 0)):
                for _ in range(3):
                    with pytest.raises(PortInUse):
                        open_link(served.server.can_addresses[0], 0)
        assert open_files() == before


def answer_once(port: PtyServer, words: bytes) -> None:
    """Answer the first question after its version with other words."""
    bell, heard = Bell(), b""
    while b"V" not in heard:
        bell.wait(LONG_S, *port.filenos())
        heard += port.read()
    port.write(words)
    bell.close()


def open_files() -> int:
    folder = Path("/proc/self/fd")
    return sum(1 for _ in folder.iterdir()) if folder.is_dir() else 0
