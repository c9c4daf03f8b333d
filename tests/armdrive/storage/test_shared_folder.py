"""State files in a folder that others may write into: their links, pipes and files are not ours."""

import contextlib
import json
import os
import socket
import stat
from pathlib import Path

import pytest

from armdrive import Arm
from armdrive.cli import arm_files, chosen_arm
from armdrive.cli.program import shell
from armdrive.connect.control_socket import serve
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.errors import ArmError, PointsFileError, StateFileError
from armdrive.programs.journal import interrupted, journal_file
from armdrive.storage import files as places
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import DISK, append_line, create_lock, replace_durably, replace_file
from armdrive.storage.lock_client import ask_holder, held_arms, notice_of, notice_path
from armdrive.storage.point_file import Points
from armdrive.storage.points import Point
from armdrive.storage.record import RecordFile, last_entry, logbook_file
from armdrive.trace.files import Header, write_recording
from kinematics import Joints
from tui.settings import DeskMemory, memory_file, recall, remember

pytestmark = pytest.mark.skipif(os.name != "posix", reason="files have owners and modes on POSIX")

ROOT = os.name == "posix" and os.geteuid() == 0
NOBODY = 65534
PRECIOUS = "somebody's own words\n"


@pytest.fixture(autouse=True)
def shared():
    """The state folder, into which everybody may write."""
    folder = places.states()
    folder.mkdir(parents=True)
    for each in (folder.parent, folder):
        each.chmod(0o777)
    return folder


@pytest.fixture
def precious(tmp_path):
    """Another user's file, which must never change."""
    path = tmp_path / "precious"
    path.write_text(PRECIOUS)
    path.chmod(0o644)
    yield path
    assert path.read_text() == PRECIOUS
    assert stat.S_IMODE(path.stat().st_mode) == 0o644


class Lines:
    """As much of readline as a history needs."""

    def get_current_history_length(self):
        return 2

    def get_history_item(self, number):
        return f"line {number}"


HEADER = Header(**dict.fromkeys(Header.__dataclass_fields__, "") | {"began_s": 0.0})


def a_record():
    path = state_file("bench")
    config = simulated_config("teachmover")
    with Arm(connect_simulated(config, record_store=RecordFile(path))) as arm:
        arm.reference.confirm()
    return path


def a_world():
    path = chosen_arm.world_file("bench")
    replace_file(path, "{}")
    return path


def a_journal():
    path = journal_file("bench")
    replace_file(path, "{}")
    return path


def a_memory():
    remember(memory_file(), DeskMemory())
    return memory_file()


def a_history():
    shell._write_history(Lines())
    return places.states() / shell.HISTORY


def a_recording():
    path = places.states() / "bench.jsonl"
    write_recording(path, HEADER, [])
    return path


def a_notice():
    with Arm(connect_simulated(simulated_config("teachmover"))) as arm:
        holding = hold("bench")
        serve(holding, arm.parts.connection)
        path = notice_path("bench", "holder")
        seen = path.lstat()
        holding.release()
    replace_file(path, "{}")
    assert stat.S_ISREG(seen.st_mode)
    assert stat.S_IMODE(seen.st_mode) == 0o600
    return path


def a_default():
    arm_files.choose_default("bench")
    return arm_files._default_path()


WRITERS = {
    "position": (a_record, state_file),
    "world": (a_world, chosen_arm.world_file),
    "journal": (a_journal, journal_file),
    "memory": (a_memory, lambda _: memory_file()),
    "history": (a_history, lambda _: places.states() / shell.HISTORY),
    "recording": (a_recording, lambda _: places.states() / "bench.jsonl"),
    "notice": (a_notice, lambda _: notice_path("bench", "holder")),
    "default arm": (a_default, lambda _: arm_files._default_path()),
}
every_writer = pytest.mark.parametrize("what", WRITERS)


@every_writer
@pytest.mark.parametrize("exists", [True, False])
def test_a_link_in_the_place_of_a_file_leads_nothing_away(what, exists, precious, tmp_path):
    write, path_of = WRITERS[what]
    path, nowhere = path_of("bench"), tmp_path / "nowhere"
    path.parent.mkdir(parents=True, exist_ok=True)
    for name in (path.name, f"{path.name}.new", f"{path.name}.bad"):
        path.with_name(name).symlink_to(precious if exists else nowhere)
    write()
    assert path.is_file()
    assert not path.is_symlink()
    assert not nowhere.exists()


@contextlib.contextmanager
def umask(mask):
    before = os.umask(mask)
    try:
        yield
    finally:
        os.umask(before)


@every_writer
@pytest.mark.parametrize("mask", [0o000, 0o777])
def test_every_file_is_its_users_alone_whatever_the_umask(what, mask):
    write, _ = WRITERS[what]
    with umask(mask):
        path = write()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize("mask", [0o000, 0o777])
def test_a_folder_or_a_lock_that_is_made_is_its_users_alone(tmp_path, mask):
    with umask(mask):
        replace_file(tmp_path / "one" / "two" / "file", "text")
        hold("bench").release()
    for folder in (tmp_path / "one", tmp_path / "one" / "two"):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(notice_path("bench", "lock").stat().st_mode) == 0o600


GUESSED = "00" * 8
"""The random part of a name, where the random bytes are all zero."""


def test_no_file_is_ever_opened_for_writing_because_it_was_there(tmp_path, monkeypatch, precious):
    """A guess of the random name only leads to a refusal."""
    monkeypatch.setattr("armdrive.storage.files.os.urandom", bytes)
    (tmp_path / f"file.{GUESSED}.new").symlink_to(precious)
    with pytest.raises(FileExistsError):
        replace_durably(DISK, tmp_path / "file", b"text")
    assert (tmp_path / f"file.{GUESSED}.new").is_symlink()
    assert not (tmp_path / "file").exists()


def test_two_writers_of_one_file_never_write_into_the_same(tmp_path):
    path = tmp_path / "file"

    def meanwhile():
        replace_durably(DISK, path, b"the other's")
        return True

    replace_durably(DISK, path, b"the first one's", wanted=meanwhile)
    assert path.read_bytes() == b"the first one's"
    assert list(tmp_path.iterdir()) == [path]


# -- reading --------------------------------------------------------------------------------------


def read_record():
    with pytest.raises(StateFileError, match="cannot be") as found:
        RecordFile(state_file("bench")).load()
    return str(found.value)


def read_world():
    with pytest.raises(StateFileError) as found:
        chosen_arm._load("bench")
    return str(found.value)


def read_journal():
    with pytest.raises(StateFileError) as found:
        interrupted("bench")
    return str(found.value)


def read_memory():
    assert recall(memory_file()) == DeskMemory()


def read_notice():
    assert notice_of("bench") is None
    assert held_arms() == []


def read_logbook():
    assert last_entry(logbook_file("bench"), "1") is None


READERS = {
    "position": (read_record, state_file),
    "world": (read_world, chosen_arm.world_file),
    "journal": (read_journal, journal_file),
    "memory": (read_memory, lambda _: memory_file()),
    "notice": (read_notice, lambda _: notice_path("bench", "holder")),
    "logbook": (read_logbook, logbook_file),
}
every_reader = pytest.mark.parametrize("what", READERS)
GOOD = json.dumps({"address": "/nowhere", "screen": "theory", "calibration": "1", "motors": {}})


def a_link(path, tmp_path):
    (tmp_path / "elsewhere").write_text(GOOD)
    path.symlink_to(tmp_path / "elsewhere")


def a_pipe(path, tmp_path):
    os.mkfifo(path)


def a_folder(path, tmp_path):
    path.mkdir()


def a_socket(path, tmp_path):
    with socket.socket(socket.AF_UNIX) as end:
        before = Path.cwd()
        os.chdir(path.parent)  # a socket's path may not be long
        try:
            end.bind(path.name)
        finally:
            os.chdir(before)


def a_link_to_zeros(path, tmp_path):
    path.symlink_to("/dev/zero")


def a_huge_file(path, tmp_path):
    with path.open("wb") as file:
        file.truncate(2**36)


def a_deep_file(path, tmp_path):
    path.write_text("[" * 60_000)


@every_reader
@pytest.mark.parametrize(
    "put",
    [a_link, a_pipe, a_folder, a_socket, a_link_to_zeros, a_huge_file, a_deep_file],
    ids=lambda put: put.__name__,
)
def test_whatever_stands_in_the_place_of_a_file_is_refused_in_a_sentence(what, put, tmp_path):
    read, path_of = READERS[what]
    put(path_of("bench"), tmp_path)
    said = read()
    if said is not None:
        assert "\n" not in said
        assert "Errno" not in said
        if put in (a_link, a_link_to_zeros):
            assert "it is a link" in said
        elif put not in (a_huge_file, a_deep_file):
            assert "not a regular file" in said


@pytest.mark.skipif(not ROOT, reason="only root can give a file to somebody else")
@every_reader
def test_a_file_of_another_user_is_not_believed(what):
    read, path_of = READERS[what]
    path = path_of("bench")
    path.write_text(GOOD)
    os.chown(path, NOBODY, NOBODY)
    said = read()
    if said is not None:
        assert "another user" in said


def test_a_history_is_neither_waited_for_nor_taken_from_elsewhere(precious):
    class Taken(Lines):
        def __init__(self):
            self.lines = []

        def add_history(self, line):
            self.lines.append(line)

    readline = Taken()
    path = places.states() / shell.HISTORY
    os.mkfifo(path)
    shell._read_history(readline)
    path.unlink()
    path.symlink_to(precious)
    shell._read_history(readline)
    assert readline.lines == []
    shell._write_history(readline)
    shell._read_history(readline)
    assert readline.lines == ["line 1", "line 2"]


# -- the log, locks, sockets ----------------------------------------------------------------------


@pytest.mark.parametrize("link", ["symlink_to", "hardlink_to"])
def test_a_log_is_appended_to_only_if_no_link_stands_in_its_place(link, precious):
    path = logbook_file("bench")
    getattr(path, link)(precious)
    with pytest.raises(OSError, match=r"link"):
        append_line(path, "a line")
    path.unlink()
    append_line(path, "one")
    append_line(path, "two")
    assert path.read_text() == "one\ntwo\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_log_is_not_poured_into_a_pipe():
    os.mkfifo(logbook_file("bench"))
    with pytest.raises(OSError, match="not a regular file"):
        append_line(logbook_file("bench"), "a line")


@pytest.mark.parametrize("put", [a_link, a_pipe, a_folder, a_socket], ids=lambda put: put.__name__)
def test_a_file_that_is_not_a_lock_is_not_used_as_one(put, tmp_path):
    put(notice_path("bench", "lock"), tmp_path)
    with pytest.raises(StateFileError, match="no arm can be locked") as found:
        hold("bench")
    assert "Errno" not in str(found.value)
    if put is a_link:
        assert (tmp_path / "elsewhere").read_text() == GOOD


def test_a_lock_empties_no_file_that_was_there(precious):
    path = notice_path("bench", "lock")
    path.hardlink_to(precious)
    with pytest.raises(StateFileError, match="second name"):
        hold("bench")
    path.unlink()
    path.write_text(PRECIOUS)
    create_lock(path)
    assert path.read_text() == PRECIOUS


def test_nothing_but_a_dead_programs_socket_is_removed_for_a_new_one(shared, arm):
    shared.chmod(0o700)
    with hold("bench") as first:
        serve(first, arm.parts.connection)
        address = Path(str(first._listener.address))
    address.write_text(PRECIOUS)
    with hold("bench") as second:
        serve(second, arm.parts.connection)
        assert ask_holder("bench", "status")["state"] == "standby"
    assert address.read_text() == PRECIOUS


def test_another_users_program_is_asked_nothing(monkeypatch, holding):
    monkeypatch.setattr("armdrive.storage.lock_client.is_ours", lambda fileno: False)
    with pytest.raises(ArmError, match="another user's program"):
        ask_holder("bench", "stop")


# -- points, which a person may keep elsewhere ----------------------------------------------------


def a_book(path):
    return Points(path, "bench", ("base",), lambda joints: None, lambda: None)


@pytest.mark.skipif(not ROOT, reason="only root can give a link to somebody else")
@pytest.mark.parametrize("exists", [True, False])
def test_a_link_of_another_user_leads_points_nowhere(tmp_path, shared, exists):
    target = tmp_path / "target.toml"
    if exists:
        target.write_text("")
    path = shared / "bench.toml"
    path.symlink_to(target)
    os.lchown(path, NOBODY, NOBODY)
    with pytest.raises(PointsFileError, match="another user's link"):
        a_book(path).read()
    with pytest.raises(PointsFileError, match="another user's link"):
        a_book(path)["pick"] = Point(Joints((0.0,), ("base",)), None)
    assert target.exists() is exists


@pytest.mark.skipif(not ROOT, reason="only root can give a link to somebody else")
def test_a_folder_that_is_another_users_link_gets_no_file(tmp_path, shared):
    target = tmp_path / "target"
    target.mkdir()
    (shared / "recordings").symlink_to(target)
    os.lchown(shared / "recordings", NOBODY, NOBODY)
    with pytest.raises(StateFileError, match="another user's link"):
        write_recording(shared / "recordings" / "bench.jsonl", HEADER, [])
    assert list(target.iterdir()) == []


def test_points_are_not_waited_for(shared):
    os.mkfifo(shared / "bench.toml")
    with pytest.raises(PointsFileError, match="not a regular file"):
        a_book(shared / "bench.toml").read()


def test_the_default_arm_is_not_waited_for(shared):
    path = arm_files._default_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    os.mkfifo(path)
    assert arm_files.chosen_default() is None


def test_where_a_system_cannot_refuse_links_they_are_seen_first(monkeypatch, tmp_path):
    """Windows has no `O_NOFOLLOW`."""
    monkeypatch.setattr("armdrive.text.reading.CAREFULLY", 0)
    a_link(state_file("bench"), tmp_path)
    assert "it is a link" in read_record()


def test_a_link_that_comes_between_the_look_and_the_open_is_refused(monkeypatch, precious):
    path, opened = logbook_file("bench"), os.open
    append_line(path, "a line")

    def late(name, flags, *mode):
        Path(name).unlink()
        Path(name).symlink_to(precious)
        return opened(name, flags, *mode)

    monkeypatch.setattr("armdrive.storage.files.os.open", late)
    with pytest.raises(OSError, match="symbolic"):
        DISK.read_own(path, 100)
    path.unlink()
    path.write_text("")
    with pytest.raises(OSError, match="symbolic"):
        append_line(path, "another line")
