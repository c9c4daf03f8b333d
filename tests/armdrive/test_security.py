"""Who may reach an arm, and what is never done with what a file or a program says."""

import ast
import os
import re
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from amounts import every_row

import armdrive
from armdrive.errors import PortUnavailable
from armdrive.sim import serving
from armdrive.sim.serving.servers import TcpServer, UdpServer, beyond_this_computer
from armdrive.storage import files as places

ROOTS = [Path(armdrive.__file__).parent, Path(armdrive.__file__).parents[1] / "tui"]
SOURCES = sorted(path for root in ROOTS for path in root.rglob("*.py"))
PICKLES = {"pickle", "cPickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}
EXECUTE = {"subprocess", "pty", "runpy", "code", "codeop", "imp", "commands", "popen2"}
ALLOWED = {
    ("sim/serving/servers.py", "pty"),
    ("transports/ports.py", "subprocess"),
    ("programs/scripts.py", "runpy"),
}
"""`pty.openpty` starts nothing; `pty.spawn` would. Drivers of CAN adapters are asked by a program
that is written out in the source, whole, and takes no name from any file. A Python script is run
where a person names it behind `armdrive run`, and nowhere else."""
EVALUATE = {"eval", "exec", "compile", "__import__", "execfile"}
SYSTEM = {"system", "popen", "execv", "execve", "execvp", "execl", "spawnv", "spawnl", "startfile"}
UNPICKLING = {"recv", "send"}
SUSPICIOUS = re.compile(
    rf"import.*\b({'|'.join(PICKLES | EXECUTE)})\b|from\s+({'|'.join(PICKLES | EXECUTE)})\b"
    rf"|\b({'|'.join(EVALUATE)})\s*\(|\bos\s*\.\s*({'|'.join(SYSTEM)})\b"
    rf"|connection\s*\.\s*({'|'.join(UNPICKLING)})\b|\bshell\s*="
)
"""Found in every source that does what is forbidden, and in some others."""
posix = pytest.mark.skipif(os.name != "posix", reason="files have modes and owners on POSIX")


# -- the simulator's doors ------------------------------------------------------------------------


@pytest.mark.parametrize("server", [TcpServer, UdpServer])
def test_a_door_is_open_to_this_computer_alone_unless_a_host_is_named(server):
    made = server()
    try:
        assert made.address.startswith(f"{server.scheme}127.0.0.1:")
    finally:
        made.close()


@every_row("address", ["7410", ":7410", "127.0.0.1:7410", "localhost:1", "[::1]:1"])
def test_an_address_of_this_computer_needs_no_warning(address):
    assert beyond_this_computer(address) == ""


@every_row("address", ["0.0.0.0:1", "192.168.1.7:1", "[::]:1", "bench.local:1"])
def test_an_address_that_others_reach_comes_with_a_warning(address):
    assert "anyone who reaches" in beyond_this_computer(address)


def test_no_address_at_all_is_refused():
    with pytest.raises(PortUnavailable):
        beyond_this_computer("0.0.0.0")


def test_the_simulator_says_the_warning_where_a_person_sees_it(call, monkeypatch):
    monkeypatch.setattr(serving, "run_device", lambda _, server, *__, **___: server.close())
    with Path(os.devnull).open(encoding="utf-8") as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        err = call("sim", "teachmover", "--tcp", "0.0.0.0:0", code=0).err
    assert err.startswith("armdrive: WARNING: anyone who reaches 0.0.0.0")


# -- the holder's socket --------------------------------------------------------------------------


@posix
def test_the_socket_is_this_users_alone(holding):
    address = Path(str(holding._listener.address))
    assert stat.S_IMODE(address.stat().st_mode) == 0o600
    assert stat.S_IMODE(address.parent.stat().st_mode) == 0o700
    assert address.parent == places.states()


# -- what is never done ---------------------------------------------------------------------------


def offences(path: Path) -> Iterator[str]:
    """Name what a source would do with somebody else's bytes that it should not."""
    root = next(root for root in ROOTS if path.is_relative_to(root))
    inside, text = path.relative_to(root), path.read_text(encoding="utf-8")
    if not SUSPICIOUS.search(text):  # parsing every source would take seconds
        return
    for node in ast.walk(ast.parse(text)):
        where = f"{inside}:{getattr(node, 'lineno', 0)}"
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in {each.split(".")[0] for each in names} & (PICKLES | EXECUTE):
                if (inside.as_posix(), name) not in ALLOWED:
                    yield f"{where} imports {name}"
        elif isinstance(node, ast.Call):
            called = node.func
            if isinstance(called, ast.Name) and called.id in EVALUATE:
                yield f"{where} calls {called.id}"
            if isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name):
                if called.value.id == "os" and called.attr in SYSTEM:
                    yield f"{where} calls os.{called.attr}"
                if called.value.id == "connection" and called.attr in UNPICKLING:
                    yield f"{where} unpickles"
            if any(word.arg == "shell" for word in node.keywords):
                yield f"{where} asks for a shell"


def test_nothing_that_is_read_is_unpickled_evaluated_or_started():
    assert len(SOURCES) > 200
    assert [offence for path in SOURCES for offence in offences(path)] == []


@pytest.mark.parametrize(
    "text",
    [
        "import pickle",
        "from subprocess import run",
        "eval(line)",
        "import os\nos.system(name)",
        "connection.recv()",
        "run(line, shell=True)",
    ],
)
def test_the_test_itself_sees_each_of_them(tmp_path, monkeypatch, text):
    root = tmp_path / "armdrive"
    root.mkdir()
    (root / "a.py").write_text(text)
    monkeypatch.setattr(sys.modules[__name__], "ROOTS", [root])
    assert list(offences(root / "a.py"))


@pytest.mark.parametrize("package", ["armdrive", "firmware_protocol", "kinematics", "tui"])
def test_a_program_named_in_an_arm_file_is_never_started(package):
    """No module is loaded by a name in a string, where neither readers nor walls see the import."""
    sources = [*(Path(armdrive.__file__).parents[1] / package).rglob("*.py")]
    assert len(sources) > 20
    loaders = ("import_module", "__import__", "importlib.util", "importlib.machinery")
    texts = {path: path.read_text(encoding="utf-8") for path in sources}
    assert [path for path, text in texts.items() if any(word in text for word in loaders)] == []
