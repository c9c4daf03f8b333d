"""An arm that its program has lost without closing it is stopped and closed, as a lost file is."""

import gc
import subprocess
import sys
import threading
import warnings

import pytest
from amounts import amount
from served import Served
from waiting import looks

from armdrive import Arm, AsyncArm
from armdrive.connect.connection import ClosingThread
from armdrive.errors import ArmInUse
from armdrive.status import State
from armdrive.storage.lock_client import ask_holder, held_arms, watch_holder
from armdrive.transports import opening
from armdrive.transports.link import AbsentLink

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)


@pytest.fixture
def there(tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as served:
        yield served
        gc.collect()
        closed()


def connect(there):
    arm = Arm.connect(there.port, dialect="teachmover")
    arm.enable()
    arm.reference.confirm()
    return arm


def closed():
    """Wait until no lost arm is being closed."""
    for each in threading.enumerate():
        if isinstance(each, ClosingThread):
            each.join()


def begin(there):
    """Begin a long motion; return what a program may keep of its arm."""
    arm = connect(there)
    handle = arm.move_j(base_deg=60, speed=0.2, wait=False)
    there.watch.moves_by(10)
    return arm, handle


def test_a_lost_arm_is_stopped_and_closed_at_once_with_a_warning(there):
    arm, handle = begin(there)
    bound_s = arm.status.stop_time_s
    del handle
    with pytest.warns(ResourceWarning, match="was not closed, and is stopped and closed now: use"):
        del arm
    there.watch.stands_within(bound_s)
    closed()
    assert held_arms() == []
    with connect(there) as again:
        assert again.status.trust.value == "referenced"


@pytest.mark.parametrize(
    "part",
    amount(
        ["reference", "points"], ["gripper", "io", "reference", "jogging", "points", "recorder"]
    ),
)
def test_an_arm_of_which_a_part_is_kept_stays_open(there, part):
    arm = connect(there)
    kept = getattr(arm, part)
    del arm
    assert held_arms() == [there.port]
    assert ask_holder(there.port, "status")["state"] == "standby"
    with pytest.warns(ResourceWarning):
        del kept
    closed()
    assert held_arms() == []


def test_a_handle_keeps_the_arm_open_and_within_reach_of_others(there):
    arm, handle = begin(there)
    del arm
    there.watch.moves_by(10)
    assert ask_holder(there.port, "status")["state"] == "moving"
    assert ask_holder(there.port, "stop") == {"done": "stop"}
    for _ in looks("the stop did not reach the arm"):
        if handle.done:
            break
    with pytest.warns(ResourceWarning):
        del handle
    closed()
    assert held_arms() == []


LOSES = """
import sys
from armdrive import Arm

def begin():
    arm = Arm.connect(sys.argv[1], dialect="teachmover")
    arm.reference.confirm()
    arm.move_j(base_deg=60, speed=0.5, wait=False)
    while arm.joints.base_deg < 1.0:
        pass

begin()
"""


def test_a_program_that_ends_just_after_losing_an_arm_saves_its_position(there):
    program = [sys.executable, "-c", LOSES, there.port]
    ended = subprocess.run(program, capture_output=True, text=True, check=True)
    assert ended.stderr == ""
    with Arm.connect(there.port, dialect="teachmover", allow_restored=True) as again:
        assert again.status.trust.value == "restored"
        assert 1.0 <= again.joints.base_deg < 30.0


UNCONFIRMED = """
import sys
from armdrive import Arm, NoAnswer
from armdrive.connect.runner import TaskRunner

async def unconfirmed(runner):
    raise NoAnswer("the arm did not confirm that it has stopped: look at it")

TaskRunner.stop = unconfirmed
arm = Arm.connect(sys.argv[1], dialect="teachmover")
if sys.argv[2] == "loses it":
    del arm
"""


@pytest.mark.parametrize("program", ["loses it", "ends with it"])
def test_a_stop_that_an_unclosed_arm_does_not_confirm_is_told_in_one_sentence(there, program):
    words = [sys.executable, "-c", UNCONFIRMED, there.port, program]
    ended = subprocess.run(words, capture_output=True, text=True, check=True)
    did_not = "the arm did not confirm that it has stopped: look at it"
    assert ended.stderr == f"armdrive: closing {there.port}: {did_not}\n"


def test_connecting_waits_for_a_lost_arm_to_be_closed(there):
    arm = connect(there)
    with pytest.warns(ResourceWarning):
        del arm
    Arm.connect(there.port, dialect="teachmover").close()


def test_an_arm_in_the_traceback_of_an_error_is_found_when_it_is_wanted_again(there):
    def fails():
        arm, cycle = connect(there), []
        cycle.append((cycle, arm))
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fails()
    with pytest.warns(ResourceWarning):
        Arm.connect(there.port, dialect="teachmover").close()


def test_an_arm_that_is_still_used_is_not_taken_from_its_user(there):
    with connect(there), pytest.raises(ArmInUse, match="held by this program"):
        Arm.connect(there.port, dialect="teachmover")


def test_a_watcher_does_not_keep_a_lost_arm_open(there):
    arm = connect(there)
    views = watch_holder(there.port, 0.02)
    assert next(views)["state"] == "standby"
    with pytest.warns(ResourceWarning):
        del arm
    for _ in looks("the watcher was not told"):
        if next(views, {"state": "disconnected"}).get("state") == "disconnected":
            break
    closed()
    assert held_arms() == []


def test_a_lost_arm_whose_link_is_gone_is_given_back(there):
    arm = connect(there)
    there.tell("fault unplug")
    for _ in looks("the loss was not seen"):
        if arm.status.state is State.DISCONNECTED:
            break
    with pytest.warns(ResourceWarning):
        del arm
    closed()
    assert held_arms() == []


def test_a_lost_simulated_arm_in_real_time_ends_its_thread():
    before = set(threading.enumerate())
    arm = Arm.connect("sim:teachmover", pace="real")
    begun = [each for each in threading.enumerate() if each not in before]
    with pytest.warns(ResourceWarning, match="sim:teachmover was not closed"):
        del arm
    closed()
    assert begun
    assert not any(each.is_alive() for each in begun)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("ended", [lambda arm: arm.close(), lambda arm: arm.__exit__(*[None] * 3)])
def test_a_closed_arm_is_lost_without_a_word(there, ended):
    arm = connect(there)
    ended(arm)
    del arm
    gc.collect()


async def test_a_lost_async_arm_is_closed_too(there):
    arm = await AsyncArm.connect(there.port, dialect="teachmover")
    await arm.enable()
    for each in threading.enumerate():
        if each.name == "armdrive call":  # the end of the thread that has connected
            each.join()
    with pytest.warns(ResourceWarning):
        del arm
    closed()
    assert held_arms() == []


GAPS = ("armdrive.arm.made_of", "armdrive.connect.parts.ExitStack.pop_all")
"""What is called between the open port and the arm, where no statement could close the port."""


@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("gap", GAPS)
def test_ctrl_c_between_the_open_port_and_the_arm_closes_the_port(there, monkeypatch, gap):
    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(gap, interrupted)
        try:
            Arm.connect(there.port, dialect="teachmover")
        except KeyboardInterrupt:
            pass
        else:
            pytest.fail("it was not interrupted")
    Arm.connect(there.port, dialect="teachmover").close()


@pytest.mark.parametrize("gap", ["parts.assemble", "parts.Core", "port.ports.serial_number_of"])
def test_ctrl_c_after_the_opening_of_a_link_leaves_none_open(monkeypatch, gap):
    opened, closed = [], []
    link = AbsentLink("a link")
    monkeypatch.setattr(link, "close", lambda: closed.append(link))
    monkeypatch.setattr(opening, "open_link", lambda *_, **__: opened.append(link) or link)

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"armdrive.connect.{gap}", interrupted)
    with pytest.raises(KeyboardInterrupt):
        Arm.connect("/dev/none", dialect="teachmover")
    assert closed == opened


def test_a_warning_that_raises_closes_a_lost_arm_nevertheless(there, monkeypatch):
    seen = []
    monkeypatch.setattr(sys, "unraisablehook", seen.append)
    arm = connect(there)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        del arm
    closed()
    assert [each.exc_type for each in seen] == [ResourceWarning]
    assert held_arms() == []
