"""One program holds an arm at a time, and answers the others about it."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from multiprocessing.connection import Connection

import pytest
from waiting import looks, soon

from armdrive.connect.control_socket import serve, serve_stop
from armdrive.errors import ArmError, ArmInUse, HolderError
from armdrive.storage import arm_lock
from armdrive.storage import files as places
from armdrive.storage import lock_client as holder
from armdrive.storage.arm_lock import MOST_WATCHERS, hold
from armdrive.storage.lock_client import (
    ask_holder,
    held_arms,
    name_held,
    notice_of,
    watch_holder,
)


def test_a_held_arm_is_refused_to_others_by_each_of_its_names(holding, monkeypatch):
    for name in ("bench", "/dev/ttyUSB0"):
        with pytest.raises(ArmInUse, match=f"{name} is held by this program: use that conn"):
            hold(name)
    notice = {"program": "first.py", "pid": 0}
    for module in (arm_lock, holder):
        monkeypatch.setattr(module, "notice_of", lambda name: notice)
    with pytest.raises(ArmInUse, match=r"held by the program first\.py \(process 0\): .* end that"):
        hold("bench")


def test_an_arm_that_is_locked_without_a_socket_is_not_said_to_be_free():
    with hold("bench", "/dev/ttyUSB0"):
        for name in ("bench", "/dev/ttyUSB0"):
            with pytest.raises(ArmInUse, match=f"{name} is held by a program that takes no req"):
                ask_holder(name, "stop")
    with pytest.raises(ArmError, match="no program holds bench: nothing moves it"):
        ask_holder("bench", "stop")
    assert not holder.notice_path("never", "lock").exists()
    with pytest.raises(ArmError, match="no program holds never"):
        ask_holder("never", "stop")
    assert not holder.notice_path("never", "lock").exists()


def test_the_next_holder_is_not_taken_for_one_that_was_killed():
    notice = {"arm": "bench", "pid": 1, "program": "dead", "address": "/nowhere"}
    path = holder.notice_path("bench", "holder")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(notice))
    with hold("bench"), pytest.raises(ArmInUse, match="takes no requests"):
        ask_holder("bench", "stop")


def leave_notice(name):
    """Leave the notice of a program that was killed while it held an arm of this name."""
    path = holder.notice_path(name, "holder")
    path.parent.mkdir(parents=True, exist_ok=True)
    notice = {"arm": name, "pid": 1, "program": "dead", "address": "/nowhere"}
    path.write_text(json.dumps(notice))


def test_a_killed_program_does_not_hide_the_one_that_holds_the_arm_by_another_name(tmp_path):
    before, after, link = tmp_path / "ttyUSB0", tmp_path / "ttyUSB1", tmp_path / "by-id"
    before.touch()
    link.symlink_to(before)
    leave_notice(str(after))
    with hold(str(link)) as lock:
        serve_stop(lock, "drives")
        link.unlink()
        link.symlink_to(after)  # the cable was pulled and plugged in again
        assert notice_of(str(link))["pid"] == os.getpid()
        assert "can only be stopped" in ask_holder(str(link), "pause")["error"]
        assert held_arms() == [str(link)]
        with pytest.raises(ArmInUse, match="is held by this program"):
            hold(str(link))
    with pytest.raises(HolderError, match="killed before it could release"):
        ask_holder(str(link), "stop")


@pytest.mark.parametrize("was_killed", [False, True])
def test_an_arm_is_found_by_the_port_when_a_program_was_started_with_that(was_killed):
    if was_killed:
        leave_notice("bench")
    names = ("bench", "/dev/ttyUSB0")
    assert name_held(*names) == "bench"
    with hold("/dev/ttyUSB0") as lock:
        serve_stop(lock, "drives")
        assert name_held(*names) == "/dev/ttyUSB0"
    assert name_held("sim:teachmover", "") == "sim:teachmover"


def test_a_suspended_program_whose_queue_is_full_still_holds_its_arm(holding, monkeypatch):
    def busy(_address):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    with monkeypatch.context() as patched:
        patched.setattr(holder, "called", busy)
        assert held_arms() == ["bench"]


def test_a_program_without_a_connected_arm_is_stopped_as_by_ctrl_c():
    interrupted = threading.Event()
    before = signal.signal(signal.SIGINT, lambda *_: interrupted.set())
    try:
        with hold("bench") as lock:
            serve_stop(lock, "sets its drives up")
            for request in ("status", "pause", "no such thing"):
                said = ask_holder("bench", request)
                assert said == {"error": said["error"]}
                assert "sets its drives up: it can only be stopped" in said["error"]
            assert not interrupted.is_set()
            assert ask_holder("bench", "stop") == {"done": "stop"}
            assert interrupted.is_set()  # the signal was sent before the answer
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_refused_holder_leaves_none_of_the_names_locked(holding):
    with pytest.raises(ArmInUse):
        hold("another", "/dev/ttyUSB0")
    hold("another").release()


def test_two_names_of_one_port_are_one_port(tmp_path):
    port, link = tmp_path / "ttyUSB0", tmp_path / "by-id"
    port.touch()
    link.symlink_to(port)
    first = hold("bench", str(port))
    try:
        with pytest.raises(ArmInUse):
            hold("other", str(link))
    finally:
        first.release()


def test_an_arm_is_found_by_its_link_after_the_link_leads_to_another_port(tmp_path):
    before, after, link = tmp_path / "ttyUSB0", tmp_path / "ttyUSB1", tmp_path / "by-id"
    before.touch()
    link.symlink_to(before)
    with hold(str(link)) as lock:
        serve_stop(lock, "drives")
        link.unlink()  # the cable is pulled
        for _ in range(2):
            with pytest.raises(ArmInUse):
                hold("other", str(link))
            assert held_arms() == [str(link)]
            assert notice_of(str(link))
            after.touch()  # it is plugged in again, and the system counts on
            link.unlink(missing_ok=True)
            link.symlink_to(after)
    assert notice_of(str(before)) is None
    assert not holder.notice_path(str(link), "holder").exists()


def test_an_arm_that_was_given_back_even_twice_can_be_taken_again(holding):
    holding.release()
    holding.release()
    hold("bench").release()
    assert held_arms() == []


def test_an_arm_with_two_names_is_one_held_arm_and_answers_to_either(holding):
    assert held_arms() == ["bench"]
    for name in ("bench", "/dev/ttyUSB0"):
        view = ask_holder(name, "status")
        assert view["state"] == "standby"
        assert view["simulated"] is True


def test_a_stop_comes_in(arm, holding):
    with arm.parts.pace.lock:
        assert ask_holder("bench", "stop") == {"done": "stop"}
        assert arm.parts.engine.stop_asked


def test_a_pause_a_resume_and_a_slower_speed_come_in(arm, holding):
    assert ask_holder("bench", "pause") == {"done": "pause"}
    assert ask_holder("bench", "status")["paused"] is True
    assert ask_holder("bench", "resume") == {"done": "resume"}
    assert ask_holder("bench", "slow", percent=25) == {"done": "slow", "percent": 25}
    view = ask_holder("bench", "status")
    assert view["paused"] is False
    assert view["speed_override"] == 0.25


def test_a_watcher_sees_each_change_and_the_end(arm, holding):
    views = watch_holder("bench", 0.02)
    assert next(views)["paused"] is False
    arm.pause()
    assert next(views)["paused"] is True
    arm.close()
    holding.release()
    assert [view["state"] for view in views][-1] == "disconnected"


def test_a_watcher_of_a_standing_arm_gets_one_status(arm, holding):
    views = watch_holder("bench", 0.02)
    assert next(views)["state"] == "standby"
    arm.sleep(1.0)  # simulated: what is believed grows older by that
    soon(arm.pause)
    assert next(views)["paused"] is True
    views.close()


def test_a_watcher_gets_the_progress_of_a_long_act_but_not_every_moment(arm, holding):
    program = {"file": "stack.arm", "line": 2, "percent": 3.1, "left_s": 60.2}
    arm.program = lambda: program
    views = watch_holder("bench", 0.02)
    assert next(views)["program"]["percent"] == 3.1
    program = {**program, "percent": 3.2, "left_s": 59.9}
    soon(program.update, {"percent": 3.9, "left_s": 59.2})
    assert next(views)["program"] == {
        "file": "stack.arm",
        "line": 2,
        "percent": 3.9,
        "left_s": 59.2,
    }
    views.close()


def test_watchers_that_went_away_make_room_for_others(arm, holding):
    for _ in range(MOST_WATCHERS + 4):
        for _ in looks("no room was made"):
            views = watch_holder("bench", 0.02)
            with contextlib.suppress(HolderError), contextlib.closing(views):  # no room yet
                assert "state" in next(views)
                break


def test_a_damaged_notice_is_ignored():
    places.states().mkdir(parents=True)
    for text in ("", "{", "[]", "{}", '{"address": 7}'):
        (places.states() / "bench.holder").write_text(text)
        with pytest.raises(ArmError):
            ask_holder("bench", "stop")
        assert held_arms() == []


@pytest.mark.skipif(os.name != "posix", reason="a Windows pipe has no path that could be too long")
def test_a_long_port_name_in_a_deep_folder_is_still_served(arm, tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path / ("deep" * 20)))
    name = "/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0"
    holding = hold(name)
    try:
        serve(holding, arm.parts.connection)
        assert ask_holder(name, "status")["state"] == "standby"
        assert len(held_arms()) == 1
    finally:
        holding.release()


def test_the_leftovers_of_a_killed_program_are_recognised(arm):
    program = (
        "import os, signal\n"
        "from armdrive import Arm\n"
        "from armdrive.connect.control_socket import serve\n"
        "from armdrive.connect.parts import connect_simulated\n"
        "from armdrive.connect.target import simulated_config\n"
        "from armdrive.storage.arm_lock import hold\n"
        "arm = Arm(connect_simulated(simulated_config('teachmover')))\n"
        "holding = hold('bench'); serve(holding, arm.parts.connection)\n"
        "print('holding', flush=True)\n"
        "input()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout.readline() == "holding\n"
        assert held_arms() == ["bench"]
        with pytest.raises(ArmInUse, match=str(holder.pid)):
            hold("bench")
        holder.kill()
    assert held_arms() == []
    with pytest.raises(ArmError, match="killed before it could release"):
        ask_holder("bench", "stop")
    holding = hold("bench")
    serve(holding, arm.parts.connection)
    assert ask_holder("bench", "status")["state"] == "standby"
    holding.release()


class HungUp(Connection):
    """A connection whose other end hangs up without reading what it was sent."""

    other: socket.socket

    def send_bytes(self, *data):
        super().send_bytes(*data)
        self.other.close()


@pytest.mark.skipif(os.name != "posix", reason="a Windows pipe ends in one way alone")
def test_a_holder_that_ends_without_reading_has_given_its_arm_back(monkeypatch):
    @contextlib.contextmanager
    def called(_name):
        ours, theirs = socket.socketpair(socket.AF_UNIX)
        connection = HungUp(ours.detach())
        connection.other = theirs
        yield connection
        connection.close()

    monkeypatch.setattr(holder, "_called", called)
    assert list(watch_holder("bench", 0.1)) == []
