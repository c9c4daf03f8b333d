"""An arm on drives behind a real wire: what it listens to, how it is found, what ends it."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial

import pytest
from served import Served
from waiting import looks

from armdrive import Arm
from armdrive.connect.port import PortOpening
from armdrive.connect.target import find
from armdrive.dialects.bus import tools
from armdrive.dialects.bus.tools import listen
from armdrive.errors import ArmError
from armdrive.status import State, Trust
from armdrive.transports import opening as url
from firmware_protocol.canopen import STATUSWORD, SdoServer
from firmware_protocol.canopen import Host as CanopenHost
from firmware_protocol.frames import Unpacker, pack

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
PORT = "can:slcan:/dev/ttyACM0?bitrate=500000"


RIVAL = 0x700 + 127
"""Another program that beats as this one."""
CIA402_IDS = sorted((*(0x80 + node + base for node in (3, 10) for base in (0, 0x100, 0x500, 0x680)),
                     RIVAL))  # fmt: skip


@pytest.mark.parametrize(
    ("dialect", "ids", "port", "heard"),
    [
        ("cia402", (3, 10), PORT, f"{PORT}&ids={','.join(map(str, CIA402_IDS))}"),
        ("mks", (1, 2, 3, 4, 5, 9), PORT, f"{PORT}&ids=1,2,3,4,5,9"),
        ("mks", (1, 2, 3, 4, 5, 9), f"{PORT}&ids=1,2", f"{PORT}&ids=1,2"),
        ("mks", (1, 2, 3, 4, 5, 9), "/dev/ttyACM0", "/dev/ttyACM0"),
    ],
)
def test_only_frames_from_the_drives_of_the_arm_are_received(
    dialect, ids, port, heard, monkeypatch
):
    opened = []
    monkeypatch.setattr(url, "open_link", lambda name, *_words, **_named: opened.append(name))
    config = find(PORT, dialect_name=dialect).config
    device = replace(config.device, ids=ids)
    connection = replace(config.connection, port=port)
    PortOpening(replace(config, device=device, connection=connection)).open()
    assert opened == [heard]


def test_an_unfetched_answer_is_given_up_with_its_transfer():
    bus, server = CanopenHost((4,)), SdoServer(4, lambda _place: b"\x40\x02", lambda *_: None)
    for _ in range(2):  # the first answer has come, and is not looked at before its time is over
        (asked,) = Unpacker().feed(bus.upload(4, STATUSWORD))
        bus.receive_data(pack(server.receive_frame(asked)))
        last, given_up = bus.abandon(4), bus.next_event()
        assert (last, given_up) == (b"", None)


@needs_pty
def test_a_bus_is_looked_at_and_connected_to_and_nothing_changes(call, tmp_path, monkeypatch):
    monkeypatch.setattr(tools, "listen", partial(listen, seconds=0.1))
    path = tmp_path / "can0"
    port = f"can:slcan:{path}?bitrate=500000"
    with Served("cia402", pty=path) as bus:
        before = bus.look()[1]
        for _ in looks("its drives never answered in time"):  # a busy computer delays them
            called = call("doctor", "--can", port, "--ids", "1-7", "--json")
            if called.code == 0 and len(called.json["drives"]) == 6:
                break
        assert [each["id"] for each in called.json["drives"]] == [1, 2, 3, 4, 5, 6]
        assert {each["protocol"] for each in called.json["drives"]} == {"canopen"}
        assert "--template minimover5-cia402" in called.json["next"][0]
        assert bus.look()[1] == before
        with Arm.connect(port, dialect="cia402") as arm:
            assert arm.status.state is State.STANDBY
        assert bus.look()[1]["motors"] == before["motors"]


def read_often(arm, times):
    """Look at an arm again and again."""
    for _ in range(times):
        arm.sleep(0.05)
        arm.parts.look()


@needs_pty
def test_an_adapter_that_left_the_bus_comes_back_within_the_same_program(tmp_path):
    path = tmp_path / "can0"
    with Served("mks", pty=path) as bus, Arm.connect(bus.port, dialect="mks") as arm:
        before = bus.watch.motors
        bus.tell("fault bus-off")
        with pytest.raises(ArmError):
            read_often(arm, 200)
        assert arm.status.trust is not Trust.REFERENCED
        bus.tell("fault off")
        if arm.status.state is State.DISCONNECTED:  # at once: the adapter is let go of before
            arm.reconnect()
        arm.reset()
        arm.enable()
        assert arm.status.state is State.STANDBY
        assert bus.watch.motors == before
