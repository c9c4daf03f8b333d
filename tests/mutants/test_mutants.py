"""The table of mutants fits the code, and the command tells a killed mutant from a survivor."""

import json
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from . import copies
from .command import ROOT, main
from .copies import CopyError, project_files, require_imported
from .mutant import Mutant
from .table import MUTANTS

KILLED = Path(__file__).with_name("killed.txt")


@cache
def text_of(path: str) -> str:
    """Return the text of a file of the project."""
    return (ROOT / path).read_text(encoding="utf-8")


# -- the table ------------------------------------------------------------------------------------


def test_each_mutant_changes_one_place_of_the_product_and_compiles():
    for mutant in MUTANTS:
        assert mutant.path.partition("/")[0] in (
            "armdrive",
            "firmware_protocol",
            "kinematics",
            "tui",
        )
        compile(mutant.mutated(text_of(mutant.path)), mutant.name, "exec")


def test_each_mutant_says_what_it_breaks_and_which_tests_notice():
    for mutant in MUTANTS:
        assert mutant.name
        assert mutant.promise, mutant.name
        assert mutant.tests, f"{mutant.name} would run the whole suite"
        for test in mutant.tests:
            path, _, name = test.partition("::")
            function = name.partition("[")[0].rpartition("::")[2]
            assert path.startswith("tests/")
            assert f"def {function}(" in text_of(path), test


def test_no_two_mutants_share_a_name():
    names = [mutant.name for mutant in MUTANTS]
    assert len(set(names)) == len(names)


def test_the_list_of_killed_mutants_is_complete():
    """`killed.txt` may grow. A name leaves it only with the code that it was a fault of."""
    recorded = KILLED.read_text(encoding="utf-8").splitlines()
    killed = sorted(mutant.name for mutant in MUTANTS if not mutant.survives)
    assert recorded == killed


# -- the command, on a project of a few lines ------------------------------------------------------


SUM, PRODUCT = "    return a + b", "    return a * b"
CODE = f"""def add(a, b):
{SUM}


def multiply(a, b):
{PRODUCT}


def forgotten(a, b):
    return a / b
"""
IMPORTS = "from .sums import add, multiply\n"
"""Of the package, which is imported before the module in it is changed."""
TESTS = """from toy import add, multiply


def test_add():
    assert add(2, 3) == 5


def test_add_nothing():
    assert add(7, 0) == 7


def test_multiply():
    assert multiply(2, 3) == 6
"""
ADDS, ADDS_NOTHING, MULTIPLIES = (
    f"test_toy.py::test_{name}" for name in ("add", "add_nothing", "multiply")
)


def mutant(name, old, new, *tests, survives=""):
    return Mutant(name, "the toy does sums", "toy/sums.py", old, new, tests, survives)


@pytest.fixture
def toy(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # a quicker start
    monkeypatch.setenv("PYTEST_PLUGINS", "xdist.plugin")  # the only plugin that is needed: for `-n`
    monkeypatch.setattr(copies, "LIBRARIES", ())
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "__init__.py").write_text(IMPORTS, encoding="utf-8")
    (tmp_path / "toy" / "sums.py").write_text(CODE, encoding="utf-8")
    (tmp_path / "test_toy.py").write_text(TESTS, encoding="utf-8")
    return tmp_path


@pytest.fixture
def tried(toy, capsys):
    """Return a function that tries mutants of the toy, and returns exit code and verdicts."""

    def run(*mutants, words=()):
        code = main(["--jobs", "1", "--json", *words], mutants=mutants, root=toy, packages=("toy",))
        said = capsys.readouterr()
        return code, json.loads(said.out) if said.out else said.err

    return run


LESS, TIMES = "    return a - b", "    return a * b"
WHY = "no code calls it"
QUOTIENT = "    return a / b", "    return b / a"


def test_each_mutant_gets_its_verdict(tried, toy):
    code, trials = tried(
        mutant("subtracts", SUM, LESS, ADDS_NOTHING, ADDS),
        # of the same size, and noticed by another test: no old bytecode is used
        mutant("multiplies", SUM, TIMES, ADDS_NOTHING, ADDS),
        mutant("unnoticed", *QUOTIENT, ADDS),
        mutant("unnoticeable", *QUOTIENT, ADDS, survives=WHY),
        mutant("expected to survive", SUM, LESS, ADDS, survives=WHY),
        mutant("no Python", SUM, "    return a +", ADDS),
        mutant("no such text", LESS, SUM, ADDS),
        mutant("a text that is there twice", "    return a", "    return 0", ADDS),
        mutant("nothing changed", SUM, SUM, ADDS),
        mutant("no such test", SUM, LESS, "test_toy.py::test_nothing"),
        mutant("noticed by another test", SUM, LESS, MULTIPLIES),
        words=["--everything"],
    )
    found = {trial["name"]: trial["verdict"] for trial in trials}
    assert found == {
        "subtracts": "killed",
        "multiplies": "killed",
        "unnoticed": "survived",
        "unnoticeable": "explained",
        "expected to survive": "broken",
        "no Python": "broken",
        "no such text": "broken",
        "a text that is there twice": "broken",
        "nothing changed": "broken",
        "no such test": "broken",
        "noticed by another test": "killed",
    }
    said = {trial["name"]: trial["words"] for trial in trials}
    assert (said["subtracts"], said["multiplies"]) == (ADDS, ADDS_NOTHING)
    assert said["noticed by another test"] == ADDS
    assert "test_nothing" in said["no such test"]
    assert code == 1
    assert (toy / "toy" / "sums.py").read_text(encoding="utf-8") == CODE


def test_tests_that_fail_without_a_mutant_prove_nothing(tried, toy):
    (toy / "test_toy.py").write_text(TESTS.replace("== 5", "== 6"), encoding="utf-8")
    code, words = tried(mutant("subtracts", SUM, LESS, ADDS))
    assert code == 2
    assert ADDS in words


def test_mutants_are_listed_and_chosen_by_a_text(toy, capsys):
    rows = [
        mutant("subtracts", SUM, LESS, ADDS),
        mutant("divides", PRODUCT, "    return a / b", MULTIPLIES, survives="a reason"),
    ]
    assert main(["--list"], mutants=rows, root=toy, packages=("toy",)) == 0
    listed = capsys.readouterr().out
    assert all(part in listed for part in ("subtracts", ADDS, "divides", "a reason"))
    assert main(["--list", "--only", "divi"], mutants=rows, root=toy, packages=("toy",)) == 0
    assert "subtracts" not in capsys.readouterr().out
    assert main(["--only", "nothing"], mutants=rows, root=toy, packages=("toy",)) == 2


def test_a_package_from_elsewhere_is_not_taken_for_the_copy(toy):
    with pytest.raises(CopyError, match="would be tested instead"):
        require_imported(toy, ["toy", "json"])
    with pytest.raises(CopyError, match="cannot be imported"):
        require_imported(toy, ["no_such_package"])


@pytest.mark.skipif(shutil.which("git") is None, reason="there is no git here")
def test_a_project_in_git_is_copied_without_what_git_ignores(toy):
    subprocess.run(["git", "init", "-q"], cwd=toy, check=True)
    (toy / ".gitignore").write_text("rubbish/\n", encoding="utf-8")
    (toy / "rubbish").mkdir()
    (toy / "rubbish" / "big").write_text("big", encoding="utf-8")
    named = {str(path) for path in project_files(toy)}
    modules = {str(Path("toy") / name) for name in ("__init__.py", "sums.py")}
    assert named == {".gitignore", "test_toy.py", *modules}
