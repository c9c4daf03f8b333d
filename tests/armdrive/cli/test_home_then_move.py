"""`home` and the commands after it, each a program of its own, on an arm behind a wire."""

from __future__ import annotations

import io
import sys

import pytest
from cli_calls import write_arm_file
from served import ServedDevice

from armdrive.connect.target import simulated_config
from armdrive.registry import DIALECTS
from armdrive.registry.simulate import simulate_device
from armdrive.sim.serving.loop import make_server

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


class Terminal(io.StringIO):
    """A terminal at which a person types these lines."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(params=DIALECTS)
def served(request, tmp_path):
    """Serve a simulated arm of each dialect, with an arm file that leads to it."""
    row, wire = DIALECTS[request.param], tmp_path / "wire"
    server = make_server(slcan=wire) if row.can else make_server(pty=wire)
    device = ServedDevice(server, simulate_device(simulated_config(row.name)))
    port = server.can_address if row.can else server.address
    wire_keys = f'dialect = "{row.name}"\nport = "{port}"\n'
    write_arm_file("bench", f'model = "{row.preset}"\n[connection]\n{wire_keys}')
    yield device.device
    device.end()


def test_the_next_command_goes_on_from_where_home_left_the_arm(call, served, monkeypatch):
    home = call("home", "--arm", "bench", "--yes", code=0).out
    assert "--allow-restored" in home
    move = ("move", "--arm", "bench", "--shoulder", "29", "--speed", "1")
    refused = call.refused(*move, code=3)
    assert "answer its question, or add `--allow-restored`" in refused
    assert "armdrive home" not in refused  # the next command would be refused again
    before = tuple(served.world.joints)
    call(*move, "--allow-restored", code=0)
    moved = served.world.joints.deg["shoulder"]
    assert tuple(served.world.joints) != before
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    asked = call("move", "--arm", "bench", "--shoulder", "31", "--speed", "1", code=0).out
    assert "Does the arm stand like this?" in asked
    assert served.world.joints.deg["shoulder"] > moved + 1.0
