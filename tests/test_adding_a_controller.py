"""Everything on the page about adding a controller works: its files, its row, its commands."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pages import ROOT, page

PAGE = page("adding-a-controller")
TUTOR = ROOT / "examples" / "tutor"
TEST_HELPERS = (ROOT / "tests", ROOT / "tests" / "armdrive")
FILES = [
    (path.relative_to(TUTOR).as_posix(), path.read_text(encoding="utf-8"))
    for path in sorted(TUTOR.rglob("*.py"))
]
DIFFS = re.findall(r"^```diff\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
COPY, *COMMANDS = "".join(
    re.findall(r"^```sh\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
).splitlines()
SCRIPT = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)[-1]


def put(tree: Path, path: str, text: str) -> None:
    """Write a file into a tree of links, whose folders on the way to it become real ones."""
    folder = tree
    for part in Path(path).parent.parts:
        inner, source = folder / part, ROOT / (folder / part).relative_to(tree)
        if inner.is_symlink():
            inner.unlink()
        if not inner.exists():
            inner.mkdir()
            for each in source.iterdir() if source.exists() else ():
                if each.name != "__pycache__":
                    (inner / each.name).symlink_to(each)
        folder = inner
    (tree / path).unlink(missing_ok=True)
    (tree / path).write_text(text, encoding="utf-8")


def patched(text: str, diff: str) -> str:
    before = "".join(line[1:] for line in diff.splitlines(True) if not line.startswith("+"))
    after = "".join(line[1:] for line in diff.splitlines(True))
    assert text.count(before) == 1, f"this is not in the registry once:\n{before}"
    return text.replace(before, after)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The project as it is, with the page's dialect in it."""
    tree = tmp_path_factory.mktemp("project")
    for package in ("armdrive", "firmware_protocol", "kinematics"):
        (tree / package).symlink_to(ROOT / package)
    for path, text in FILES:
        assert not (ROOT / path).exists()
        put(tree, path, text)
    registry = (ROOT / "armdrive" / "registry" / "__init__.py").read_text(encoding="utf-8")
    for diff in DIFFS:
        registry = patched(registry, diff)
    put(tree, "armdrive/registry/__init__.py", registry)
    return tree


def run(tree: Path, words: list[str]) -> str:
    own = {
        "PYTHONPATH": os.pathsep.join(map(str, (tree, *TEST_HELPERS))),
        "HOME": str(tree / "home"),
        "XDG_STATE_HOME": str(tree / "state"),
    }
    ended = subprocess.run(
        [sys.executable, *words],
        cwd=tree,
        env=os.environ | own,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_the_page_copies_the_files_and_names_each():
    assert COPY == "cp -r examples/tutor/. ."
    assert len(FILES) == 5
    for path, _ in FILES:
        assert f"`{path}`" in PAGE, path


def test_the_page_changes_no_line_of_the_registry():
    assert DIFFS
    assert not any(line.startswith("-") for diff in DIFFS for line in diff.splitlines())


def test_its_commands_run_one_after_another(tree):
    program = (
        "import shlex, sys\n"
        "from armdrive.cli import main\n"
        "for command in sys.argv[1:]:\n"
        "    print(command, main(shlex.split(command)[1:]), sep=': ')\n"
    )
    told = run(tree, ["-c", program, *COMMANDS])
    assert all(command.startswith("armdrive ") for command in COMMANDS)
    assert all(f"{command}: 0\n" in told for command in COMMANDS), told


def test_its_script_homes_moves_and_stops(tree):
    told = run(tree, ["-c", SCRIPT])
    joints, state = told.splitlines()
    assert "shoulder 40.0°, elbow -60.0°" in joints
    assert "standby" in state.lower()
    assert 0.0 < float(state.split()[-1]) < 1.0


def test_its_device_is_recognised_described_found_and_connected_although_it_holds_half_a_line(tree):
    program = (
        "from doctor_bench import SimPort, made\n"
        "from armdrive import Arm\n"
        "from armdrive.connect.parts import connect_simulated\n"
        "from armdrive.connect.port import recogniser\n"
        "from armdrive.connect.target import simulated_config\n"
        "from armdrive.registry import simulate\n"
        "from armdrive.trace.log import describer\n"
        "known, row = recogniser(), describer('tutor')\n"
        "print(known.own_probe('tutor').data, known.recognise(b'p 1 2 3 4 5 6\\n').dialect)\n"
        "print(row.words(b'M 250 10 0 0 0 0 0', row.sent))\n"
        "print(SimPort(made('tutor')).examine().identity.dialect)\n"
        "config = simulated_config('tutor')\n"
        "twin = simulate(config)\n"
        "twin.link.write(b'M 250 10', 0.0)\n"
        "with Arm(connect_simulated(config, twin=twin)) as arm:\n"
        "    print(arm.status.state.value)\n"
    )
    assert run(tree, ["-c", program]).splitlines() == [
        "b'P\\n' tutor",
        "move at 250 steps/s: base +10",
        "tutor",
        "standby",
    ]
