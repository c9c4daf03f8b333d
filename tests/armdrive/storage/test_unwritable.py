"""A state folder that cannot be written: one sentence from every command, and nothing moves."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

import pytest
from served import Served

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.errors import StateFileError
from armdrive.registry import simulate
from armdrive.status import Trust
from armdrive.storage import files as places
from armdrive.storage.files import UNFINISHED, StateFiles
from armdrive.storage.record import FileRecorder

DRIVING = [
    ("status",),
    ("status", "--json"),
    ("home",),
    ("home", "--fresh"),
    ("move", "--z", "60"),
    ("reset",),
    ("verify",),
    ("shell",),
    ("points", "save", "pick"),
]
"""Commands that hold the arm: without the lock nobody may, not even to look."""

WRITING = [
    ("config", "new", "lab", "--yes", "--template", "teachmover"),
    ("config", "new", "lab", "--yes", "--template", "teachmover", "--json"),
]
HOLDING_NOTHING = [
    ("stop",),
    ("pause",),
    ("points", "list"),
    ("config", "list"),
    ("log",),
    ("teach", "follow", "pick"),
]
"""Commands that hold no arm, and do what they can, or say a sentence."""


def a_file_in_its_place(monkeypatch, tmp_path):
    (tmp_path / "home").write_text("")
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path / "home"))


def a_place_where_nothing_is_made(monkeypatch, tmp_path):
    if not Path("/proc/self").exists():
        pytest.skip("there is no /proc")
    monkeypatch.setenv("ARMDRIVE_HOME", "/proc/self/armdrive")


def a_read_only_disk(monkeypatch, tmp_path):
    """Root ignores modes, so the system's own answer is given here."""

    def refused(*words, **named):
        raise OSError(30, "Read-only file system", str(words[-1]))

    places.states().mkdir(parents=True, exist_ok=True)
    for name in ("create", "make_folder", "replace", "remove"):
        monkeypatch.setattr(StateFiles, name, refused)
    monkeypatch.setattr(StateFiles, "may_change", lambda files, folder: False)
    monkeypatch.setattr(Path, "unlink", refused)


@pytest.fixture(
    params=[a_file_in_its_place, a_place_where_nothing_is_made, a_read_only_disk],
    ids=lambda make: make.__name__,
)
def unwritable(request, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with monkeypatch.context() as patched:
        request.param(patched, tmp_path)
        yield


@pytest.mark.parametrize("words", [*DRIVING, *WRITING], ids=" ".join)
def test_a_command_that_needs_the_folder_fails_with_one_sentence(call, unwritable, words):
    said = call.refused(*words, code=1)
    assert "Errno" not in said
    assert os.environ["ARMDRIVE_HOME"] in said
    assert "writable" in said
    assert "no arm can be locked" in said or words in WRITING or "--fresh" in words


@pytest.mark.parametrize("words", [("home",), ("points", "save", "pick")], ids=" ".join)
@pytest.mark.parametrize("operation", ["create", "write"])
def test_a_command_on_a_full_disk_names_the_file_that_has_no_room(
    call, monkeypatch, operation, words
):
    create = StateFiles.create

    def no_room(files, what, *_) -> int:
        if operation == "create" and not what.name.endswith(UNFINISHED):
            return create(files, what)  # an empty file still fits
        raise OSError(28, "No space left on device", *([what] if operation == "create" else []))

    monkeypatch.setattr(StateFiles, operation, no_room)
    said = call.refused(*words, code=1)
    assert "Errno" not in said
    assert f"{os.environ['ARMDRIVE_HOME']}{os.sep}" in said
    assert UNFINISHED not in said
    assert "(No space left on device): free some space" in said


@pytest.mark.parametrize("words", HOLDING_NOTHING, ids=" ".join)
def test_a_command_that_holds_no_arm_does_what_it_can(call, unwritable, words):
    called = call(*words)
    assert called.err.count("\n") <= 1
    assert "Errno" not in called.err


def test_the_demo_needs_no_folder(call, unwritable):
    assert call("demo", code=0).err == ""


def test_a_connection_is_refused_before_its_port_is_opened(unwritable, tmp_path):
    with pytest.raises(StateFileError, match="no arm can be locked"):
        Arm.connect(str(tmp_path / "no-port"), dialect="teachmover")


def test_without_a_writable_folder_the_position_is_unknown_and_nothing_moves(monkeypatch, tmp_path):
    """What docs/background/trust.md promises of an arm that is connected all the same."""
    path = state_file("bench")
    config = simulated_config("teachmover")
    with Arm(connect_simulated(config, recorder=FileRecorder(path))) as arm:
        arm.confirm_reference()
        world = arm.twin.save()
    before = path.read_bytes()
    with monkeypatch.context() as patched:
        a_read_only_disk(patched, tmp_path)
        with Arm(
            connect_simulated(config, twin=simulate(config, world), recorder=FileRecorder(path))
        ) as arm:
            assert arm.status.trust is Trust.UNKNOWN
            assert "make the folder writable" in arm.status.trust_reason
            motors = arm.twin.world.motors
            with pytest.raises(StateFileError, match="free some disk space or make the folder"):
                arm.jog_j(base_deg=1.0)
            assert arm.twin.world.motors == motors
    assert path.read_bytes() == before


@pytest.mark.skipif(
    os.name != "posix" or os.geteuid() == 0, reason="root writes whatever the modes say"
)
def test_a_folder_whose_mode_forbids_it(call):
    places.states().mkdir(parents=True)
    places.states().chmod(0o500)
    try:
        for words in DRIVING:
            assert "writable" in call.refused(*words, code=1)
    finally:
        places.states().chmod(0o700)


# -- a disk that is full when an arm is locked ----------------------------------------------------


@pytest.fixture
def full(monkeypatch):
    create = StateFiles.create

    def created(files, path):
        if ".holder" in path.name:
            raise OSError(28, "No space left on device")
        return create(files, path)

    monkeypatch.setattr(StateFiles, "create", created)
    return monkeypatch


def test_a_command_says_which_file_cannot_be_written(call, full):
    said = call.refused("enable", code=1)
    assert ".holder cannot be written (No space left on device); free disk space" in said
    full.undo()
    call("enable", code=0)


def test_a_real_arm_can_be_read_with_a_full_disk(call, full, tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as served:
        port = ("--port", served.port, "--dialect", "teachmover")
        assert "motors" in call("status", *port, code=0).out
        assert ".holder cannot be written" in call.refused("enable", *port, code=1)
        full.undo()
        call("enable", *port, code=0)  # the lock was given back


def test_the_port_and_the_lock_are_given_back(full, tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as served:
        with pytest.raises(StateFileError, match="cannot be written"):
            Arm.connect(served.port, dialect="teachmover")
        full.undo()
        with Arm.connect(served.port, dialect="teachmover") as arm:
            assert not arm.simulated
