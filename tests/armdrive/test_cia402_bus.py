"""An arm on CiA 402 drives behind a real wire: what it listens to, and that it connects."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from armdrive import Arm
from armdrive.connecting import find
from armdrive.status import State
from armdrive.transports import url
from armdrive.wiring import Wiring

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from sim_process import SimProcess

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
PORT = "can:slcan:/dev/ttyACM0?bitrate=500000"


def test_what_the_drives_of_the_arm_say_is_listened_to_and_no_more(monkeypatch):
    opened = []
    monkeypatch.setattr(url, "open_link", lambda name, *_words, **_named: opened.append(name))
    config = find(PORT, dialect_name="cia402").config
    device = replace(config.device, ids=(3, 10))
    Wiring(replace(config, device=device)).open()
    heard = [0x80 + node + base for node in (3, 10) for base in (0, 0x100, 0x500, 0x680)]
    rival = 0x700 + device.master_id  # another program that beats as this one
    assert opened == [f"{PORT}&ids={','.join(map(str, sorted((*heard, rival))))}"]


@needs_pty
def test_an_arm_on_a_bus_of_another_process_is_found_and_moves_nothing(tmp_path):
    path = tmp_path / "can0"
    with SimProcess(path, "cia402") as bus:
        with Arm.connect(f"can:slcan:{path}?bitrate=500000", dialect="cia402") as arm:
            assert arm.status.state is State.STANDBY
        assert not bus.state()["moving"]
