"""An arm that another program holds: its holder, its status, and a stop from outside."""

import json
import re
import signal
from argparse import Namespace
from itertools import count

import pytest
from cli_calls import write_bench
from waiting import FOREVER_S, soon, until

import tui
from armdrive import Stopped
from armdrive.arm import Arm
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.cli.drive import jog
from armdrive.cli.look import status
from armdrive.cli.look.status import next_step, status_lines
from armdrive.cli.presenter import Inked
from armdrive.connect.control_socket import serve
from armdrive.connect.target import simulated_config
from armdrive.runtime.engine import Engine
from armdrive.status import State, status_view
from armdrive.storage import arm_lock

ARM = "sim:teachmover"


@pytest.fixture
def held(call):
    """The simulated arm of the command line, held by another program, at ten times real speed."""
    with connect_remembered(simulated_config("teachmover"), pace=10.0) as arm:
        arm.reference.confirm()
        yield arm


@pytest.fixture
def held_by_port(arm):
    """The port of the arm file "bench", which another program was given by its name."""
    port = "/dev/ttyACM9"
    write_bench(port)
    with arm_lock.hold(port) as lock:
        serve(lock, arm.parts.connection)
        yield port


def test_every_command_finds_the_program_that_holds_the_port_of_a_named_arm(
    call, held_by_port, monkeypatch
):
    assert f"asked {held_by_port} to stop" in call("stop", "--arm", "bench", code=0).out
    said = call("status", "--arm", "bench", code=0).out
    assert f"is driving {held_by_port} on the port of bench" in said
    watched = []
    monkeypatch.setattr(jog, "require_screen", lambda *_: None)
    monkeypatch.setattr(status, "require_screen", lambda *_: None)
    monkeypatch.setattr(tui, "run_watch", lambda name, *_, **__: watched.append(name) or 0)
    for words in (("jog",), ("watch", "--screen")):
        call(*words, "--arm", "bench", code=0)
    assert watched == [held_by_port, held_by_port]


def test_the_status_of_a_held_arm_comes_from_its_holder(call, held):
    for words in ((), ("--fresh",)):  # the world is not taken from under the holder
        seen = call("status", *words, "--json", code=0).json
        assert (seen["arm"], seen["trust"]) == (ARM, "referenced")
    call.refused("status", "--fresh", "--port", "/dev/none", "--dialect", "teachmover", code=4)
    said = call("status", code=0).out
    assert said.startswith("the program ")
    assert "is driving this arm" in said
    assert "\nposition  referenced: " in said
    assert "\nnext      `armdrive watch` follows the arm" in said
    assert not re.search("armdrive (move|jog|run|reset|home)", said)


def test_a_stop_from_outside_ends_a_motion(call, held):
    handle = held.move_j(base_deg=85, speed=0.05, wait=False)
    until(lambda: held.status.state is State.MOVING)
    said = call("stop", code=0).out
    assert f"asked {ARM} to stop" in said
    with pytest.raises(Stopped):
        handle.wait(FOREVER_S)
    assert held.status.state is State.STANDBY
    assert held.status.joints["base"] < 1.4
    held.move_j(base_deg=0)  # a stop latches nothing
    stopped = call("stop", "--sim", "teachmover", "--json", code=0).json  # by its name
    assert stopped == {"stopped": 1, "failures": []}
    assert call("stop", "--sim", "robko01", "--json", code=1).json["failures"]


def test_a_motion_is_paused_slowed_and_resumed_from_outside(call, held):
    handle = held.move_j(base_deg=60, speed=0.5, wait=False)
    assert f"asked {ARM} to pause" in call("pause", code=0).out
    assert call("pause", "--json", code=0).json == {"paused": 1, "failures": []}
    assert call("status", "--json", code=0).json["paused"] is True
    assert call("slow", "50%", "--json", code=0).json == {"slowed": 1, "failures": []}
    assert held.speed_override == 0.5
    assert "asked" in call("slow", "1", "--sim", "teachmover", code=0).out
    assert call("resume", "--json", code=0).json == {"resumed": 1, "failures": []}
    handle.wait(FOREVER_S)
    assert held.joints.deg["base"] == pytest.approx(60, abs=0.1)


@pytest.mark.parametrize("line", ["watch", "record --sim teachmover"])
def test_an_arm_without_a_holder_is_neither_watched_nor_recorded_and_nothing_was_stopped(
    call, line
):
    told = json.loads(call(*line.split(), "--json", code=1).err.splitlines()[-1])
    assert told["code"] == "E410"
    assert told["message"].startswith("no program")
    assert told["effect"].startswith("None.")


def test_a_held_arm_is_watched_until_it_is_given_back_and_ctrl_c_only_ends_the_watching(
    call, held, monkeypatch
):
    threads, watch_show = [], status.show

    def interrupted(result, options):
        raise KeyboardInterrupt

    def seen(result, options):
        watch_show(result, options)
        if result.document["state"] == "standby":
            threads.append(soon(held.close))

    monkeypatch.setattr(status, "show", interrupted)
    assert call("watch", code=0).err == ""
    assert not held.parts.engine.stop_asked
    monkeypatch.setattr(status, "show", seen)
    views = call("watch", "--every", "0.05", "--json", code=0).json_lines
    assert views[0]["state"] == "standby"
    assert views[-1]["state"] == "disconnected"
    for thread in threads:  # what they release last is free when they have ended
        thread.join()
    assert "no program" in call.refused("watch", code=1)


def test_ctrl_c_in_a_motion_stops_the_arm_and_keeps_the_reference(call, monkeypatch):
    call("home", code=0)
    real, calls = Engine.advance, count()

    def interrupted(engine: Engine, now_s: float) -> float:
        if next(calls) == 20:
            signal.raise_signal(signal.SIGINT)
        return real(engine, now_s)

    with monkeypatch.context() as patched:
        patched.setattr(Engine, "advance", interrupted)
        called = call("move", "--x", "300", "--z", "150", code=130)
    assert "that this command moved was stopped" in called.err
    seen = call("status", "--json", code=0).json
    assert seen["trust"] == "restored"
    assert 127 < seen["pose"]["x_mm"] < 299  # on the way


# The status of an arm as a person reads it, and the lines of `armdrive watch`.


@pytest.fixture(scope="module")
def view():
    """The status of a simulated arm that stands in its reference posture."""
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        return status_view(arm.status)


def plain(line) -> str:
    parts = (line,) if isinstance(line, str) else line
    return "".join(part.text if isinstance(part, Inked) else part for part in parts)


def page(view, **options) -> dict[str, str]:
    """Return the page of a status by its labels; joints by their names."""
    rows = [plain(line) for line in status_lines(view, Namespace(**options), next_step(view))]
    return {row[:10].strip() or row[10:].split("  ")[0]: row[10:] for row in rows[2:] if row}


def test_the_page_has_everything_with_its_unit(view):
    rows = page(view)
    assert rows["state"] == "standby"
    assert rows["position"] == "referenced: referenced in the reference posture"
    assert rows["tip"] == "x 127.0 mm, y 0.0 mm, z 0.0 mm, pitch -90.0°, roll 0.0°"
    assert rows["joints"].split() == ["base", "0.0°"]
    assert rows["wrist pitch"].split()[-1] == "10.7°"
    assert rows["gripper"] == "0.0 mm open"
    assert rows["inputs"] == "all off"
    assert "s and" in rows["stop"]
    assert rows["disable"].startswith("the arm sags")
    assert "`armdrive move`" in rows["next"]
    assert "-508" not in "".join(rows.values())  # motor steps are in the JSON alone
    # a bound is never shown smaller than it is
    bounds = {"stop_time_s": 0.651, "stop_distance_mm": 115.2}
    silent = {"silent_time_s": 0.701, "silent_distance_mm": 120.01}
    shown = page(view | bounds | silent)["stop"]
    assert shown == "takes at most 0.66 s and 116 mm; without this program, 0.71 s and 121 mm"


@pytest.mark.parametrize(
    ("changes", "step"),
    [
        ({"state": "error-stop", "error_code": "E502"}, "then call `reset()`"),
        ({"state": "disconnected", "error_code": "E407"}, "Plug the cable in"),
        ({"trust": "suspect", "trust_code": "E716"}, "Look at the arm, then call `home()`"),
        # after the reset that the remedy of E707 begins with
        ({"trust": "suspect", "trust_code": "E707"}, "Look at the arm, then call `home()`"),
        ({"trust": "unknown", "trust_code": "E701"}, "Call `home()`."),
        ({"trust": "suspect", "notice_code": "E206"}, "`armdrive doctor --fix`"),
        ({"trust": "restored", "trust_code": "E702"}, "a simulated arm confirms its position"),
        (
            {"trust": "restored", "trust_code": "E702", "simulated": False},
            "asks first whether the arm still stands as it was left",
        ),
        ({"paused": True, "state": "moving"}, "`armdrive resume`"),
        ({"state": "moving"}, "`armdrive stop`"),
        ({"state": "disabled"}, "Call `enable()` to switch the motors on."),
        ({}, "`armdrive move`"),
    ],
)
def test_the_page_ends_with_what_to_do_next(view, changes, step):
    assert step in next_step(view | changes)
