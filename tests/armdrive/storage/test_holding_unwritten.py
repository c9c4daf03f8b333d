"""A disk that is full when an arm is locked: a typed error, and the arm is released."""

import pytest
from served import Served

from armdrive import Arm
from armdrive.errors import StateFileError
from armdrive.storage.files import StateFiles


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
    said = call.refused("status", code=1)
    assert ".holder cannot be written (No space left on device); free disk space" in said
    full.undo()
    call("status", code=0)


def test_the_port_and_the_lock_are_given_back(full, tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as served:
        with pytest.raises(StateFileError, match="cannot be written"):
            Arm.connect(served.port, dialect="teachmover")
        full.undo()
        with Arm.connect(served.port, dialect="teachmover") as arm:
            assert not arm.simulated
