"""The walls between packages: imports go down, in no cycle, and dialects stay at home."""

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest
from amounts import every_row
from importlinter.cli import lint_imports

from armdrive.registry import DIALECTS

ROOT = Path(__file__).parents[1]
PACKAGES = ("armdrive", "firmware_protocol", "kinematics", "tui")


def test_no_package_imports_what_its_walls_forbid(capsys):
    assert lint_imports(no_cache=True) == 0, capsys.readouterr().out


def test_no_two_files_import_each_other():
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    TopologicalSorter(imports).prepare()  # raises an error that names the modules of a cycle


# A dialect is three subpackages and a row of the registry: no other file names one.


HOMES = ("firmware_protocol", "armdrive/dialects", "armdrive/sim")
CODECS = {path.name for path in (ROOT / "firmware_protocol").iterdir() if path.is_dir()}
NAMES = {*DIALECTS, *CODECS} - {"__pycache__"}
WORD = re.compile(rf"(?<![\w/-])(?:{'|'.join(sorted(NAMES))})(?![\w-])(?!\.md)")
"""A name by itself: not the preset `minimover5-mks`, the firmware `grbl-Mega-5X` or a page."""

NAME = re.compile("|".join(sorted(NAMES)))
"""In a text without this nothing can name a dialect: most files need no parsing."""

PRESET = "the default model is a preset of kinematics, which has an arm's name"
EXAMPLE = "shown to a person as an example of what to type"

EXCEPTIONS: Mapping[str, str] = {
    "armdrive/cli/learn/arguments.py": PRESET,
    "armdrive/config/arm.py": EXAMPLE,
    "armdrive/setup/templates.py": "templates are presets of whole arms, each with its controller",
    "armdrive/sim/world/__init__.py": PRESET,
    "armdrive/testing/plugin.py": EXAMPLE,
    "tui/setup/__init__.py": EXAMPLE,
}
"""What names a dialect for now, and why. A line is taken out with its reason; none is added."""


def names_in(path: Path) -> Iterator[str]:
    """Give each place of a file that names a dialect which is not its own."""
    text = path.read_text(encoding="utf-8")
    if not NAME.search(text):
        return
    own = home(path)
    nodes = [*ast.walk(ast.parse(text))]
    prose = {
        id(line.value)
        for node in nodes
        if isinstance(body := getattr(node, "body", None), list)
        for line in body
        if isinstance(line, ast.Expr)
    }
    for node in nodes:
        for module in imported(node):
            found = set(module.split(".")) & NAMES
            if is_of_a_dialect(module) and not found & own:
                yield f"line {node.lineno} imports {module}"
        if own or id(node) in prose or not isinstance(node, ast.Constant):
            continue
        if isinstance(node.value, str) and WORD.search(node.value):
            yield f"line {node.lineno} says {node.value!r:.60}"


def imported(node: ast.AST) -> Iterator[str]:
    """Give the modules that an import statement may name."""
    if isinstance(node, ast.Import):
        yield from (each.name for each in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        yield from (f"{node.module}.{each.name}" for each in node.names)


def is_of_a_dialect(module: str) -> bool:
    path = module.replace(".", "/")
    return any(path.startswith(f"{package}/{name}") for package in HOMES for name in NAMES)


def home(path: Path) -> set[str]:
    """Return whose subpackage or module a file is, the codec of a dialect with it."""
    for package in HOMES:
        if path.is_relative_to(ROOT / package):
            name = path.relative_to(ROOT / package).parts[0].removesuffix(".py")
            if name in NAMES:
                return {name, CODEC_OF.get(name, name)}
    return set()


CODEC_OF = {"cia402": "canopen"}
"""Dialects that share a codec with a name of its own."""


@cache
def naming() -> dict[str, list[str]]:
    """Return the places of every file that names a dialect."""
    files = [path for package in ("armdrive", "tui") for path in (ROOT / package).rglob("*.py")]
    told = {path.relative_to(ROOT).as_posix(): list(names_in(path)) for path in files}
    return {
        path: found
        for path, found in told.items()
        if found and not path.startswith("armdrive/registry/")
    }


def test_no_other_file_names_a_dialect():
    found = naming()
    told = [f"{path}: {each}" for path in found if path not in EXCEPTIONS for each in found[path]]
    assert not told, "\n".join(told)


def test_every_exception_is_needed():
    assert not set(EXCEPTIONS) - set(naming()), "take these lines out"


@pytest.mark.parametrize(
    ("source", "caught"),
    [
        ('x = "mks"', True),
        ('x = f"sim:{0}" if y == "grbl" else ""', True),
        ('x = "teachmover.grip_bit"', True),
        ("from armdrive.dialects.mks import words", True),
        ("from armdrive.sim import grbl", True),
        ("import firmware_protocol.canopen.services", True),
        ('x = "minimover5-mks"', False),
        ('x = "put grbl-Mega-5X on it (docs/controllers/grbl.md)"', False),
        ('"""About the mks dialect."""', False),
        ("from armdrive.dialects.words import plain", False),
    ],
)
def test_what_counts_as_naming_one(tmp_path, monkeypatch, source, caught):
    monkeypatch.setattr(f"{__name__}.ROOT", tmp_path)
    path = tmp_path / "module.py"
    path.write_text(source, encoding="utf-8")
    assert bool(list(names_in(path))) == caught


# -- maps: a package's docstring says what each of its files decides ------------------------------

MAPPED = re.compile(r"^    ([a-z_][\w/., ]*?)  +\S", re.MULTILINE)
"""A line of a map: names, two spaces or more, and what is decided there."""


def map_of(package: Path) -> str:
    """Return the docstring of a package if it has a map, else nothing."""
    text = ast.get_docstring(ast.parse((package / "__init__.py").read_text("utf-8"))) or ""
    return text if MAPPED.search(text) else ""


FILES = sorted(path for name in PACKAGES for path in (ROOT / name).rglob("__init__.py"))
WITH_A_MAP = {
    file.parent.relative_to(ROOT).as_posix(): file.parent for file in FILES if map_of(file.parent)
}


@every_row("package", WITH_A_MAP.values(), ids=WITH_A_MAP)
def test_a_map_names_every_file_of_its_package_and_no_other(package):
    text, files = map_of(package), {path.stem for path in package.glob("*.py")}
    inside = files | {path.parent.name for path in package.glob("*/__init__.py")}
    for name in {each for line in MAPPED.findall(text) for each in re.split(r",\s*", line)}:
        assert (package / name).exists() or name.rstrip("/") in inside, f"there is no {name}"
    unnamed = {name for name in files if not re.search(rf"\b{name}\b", text)}
    assert unnamed <= {"__init__", "__main__", *DIALECTS}


def test_the_packages_that_a_reader_enters_by_have_a_map():
    entered = {"kinematics", "firmware_protocol", "tui", "armdrive/motion", "armdrive/runtime"}
    assert entered <= WITH_A_MAP.keys()
    assert len(WITH_A_MAP) > 30
