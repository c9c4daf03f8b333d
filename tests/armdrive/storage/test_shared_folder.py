"""The state folder: nothing in it is believed or written where other users may change it."""

import os
import stat

import pytest

from armdrive import Arm
from armdrive.cli import arm_files
from armdrive.errors import PointsFileError, StateFileError
from armdrive.storage import files as places
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import DISK, replace_durably, replace_file
from armdrive.storage.lock_client import notice_path
from armdrive.storage.point_file import Points
from armdrive.storage.record import RecordFile

pytestmark = pytest.mark.skipif(os.name != "posix", reason="files have owners and modes on POSIX")

ROOT = os.name == "posix" and os.geteuid() == 0
NOBODY = 65534


@pytest.fixture
def state(tmp_path):
    folder = places.states()
    folder.mkdir(parents=True)
    return folder


@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777])
def test_a_folder_that_others_may_change_is_not_used_at_all(state, call, mode):
    state.chmod(mode)
    with pytest.raises(StateFileError, match=f"other users can change the files in {state}"):
        Arm.connect("/dev/no-such-port", dialect="teachmover")
    for words in (("status",), ("stop",), ("config", "list"), ("points", "save", "here")):
        called = call(*words)
        if called.code:
            assert f"`chmod 700 {state}`" in called.err
            assert called.err.count("\n") == 1
    assert list(state.iterdir()) == []
    state.chmod(0o755)  # others may look
    call("status", code=0)


@pytest.mark.skipif(not ROOT, reason="only root can give a folder to somebody else")
def test_another_users_folder_is_not_used(state):
    os.chown(state, NOBODY, NOBODY)
    with pytest.raises(StateFileError, match="other users can change"):
        hold("bench")
    assert list(state.iterdir()) == []


@pytest.mark.parametrize("mask", [0o000, 0o002, 0o077])
def test_folders_and_files_that_are_made_are_this_users_alone(mask):
    before = os.umask(mask)
    try:
        replace_file(places.recordings() / "file", "text")
        hold("bench").release()
    finally:
        os.umask(before)
    for folder in (places.states(), places.recordings()):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    files = (places.recordings() / "file", notice_path("bench", "lock"))
    for path in files:
        assert stat.S_IMODE(path.stat().st_mode) == 0o600, path


def test_two_writers_of_one_file_never_write_into_the_same(tmp_path):
    path = tmp_path / "file"

    def meanwhile():
        replace_durably(DISK, path, b"the other's")
        return True

    replace_durably(DISK, path, b"the first one's", wanted=meanwhile)
    assert path.read_bytes() == b"the first one's"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_was_there_is_never_written_into(tmp_path, monkeypatch):
    monkeypatch.setattr("armdrive.storage.files.os.urandom", bytes)
    there = tmp_path / f"file.{'00' * 8}.new"
    there.write_text("another's")
    with pytest.raises(FileExistsError):
        replace_durably(DISK, tmp_path / "file", b"text")
    assert there.read_text() == "another's"
    assert list(tmp_path.iterdir()) == [there]


def test_a_pipe_is_not_waited_for(tmp_path, state):
    points = Points(tmp_path / "points", "bench", ("base",), lambda joints: None, lambda: None)
    for path in (state / "record", points.path, arm_files._default_path()):
        path.parent.mkdir(parents=True, exist_ok=True)
        os.mkfifo(path)
    with pytest.raises(StateFileError, match="not a regular file"):
        RecordFile(state / "record").load()
    with pytest.raises(PointsFileError, match="not a regular file"):
        points.read()
    assert arm_files.chosen_default() is None
