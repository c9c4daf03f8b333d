"""The walls between packages (pyproject.toml, tool.importlinter), and that no import is a cycle."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import grimp
import pytest
from importlinter.cli import lint_imports

ROOT = Path(__file__).parents[1]
PACKAGES = ("armdrive", "firmware_protocol", "kinematics", "tui")


def test_no_package_imports_what_its_walls_forbid(capsys):
    assert lint_imports(no_cache=True) == 0, capsys.readouterr().out


def cycles(imports: dict[str, set[str]]) -> Iterator[set[str]]:
    """Give the modules on cycles, and those on the way from one cycle to another.

    A module that imports nothing that is left, or that nothing left imports, is on no cycle: it is
    dropped, until only cycles are left.
    """
    left = dict(imports)
    while True:
        imported = {name for names in left.values() for name in names}
        inside = {
            name: found & left.keys()
            for name, found in left.items()
            if name in imported and found & left.keys()
        }
        if inside == left:
            break
        left = inside
    if left:
        yield set(left)


def test_no_two_files_import_each_other():
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    assert list(cycles(imports)) == []


def test_a_cycle_is_found_and_what_leads_into_it_is_not_part_of_it():
    imports = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": {"e"}, "e": set(), "f": {"a"}}
    assert list(cycles(imports)) == [{"b", "c"}]
    assert list(cycles({"a": {"b"}, "b": {"c"}, "c": set()})) == []


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


@pytest.mark.parametrize("package", WITH_A_MAP.values(), ids=WITH_A_MAP)
def test_a_map_names_every_file_of_its_package_and_no_other(package):
    text, files = map_of(package), {path.stem for path in package.glob("*.py")}
    inside = files | {path.parent.name for path in package.glob("*/__init__.py")}
    for name in {each for line in MAPPED.findall(text) for each in re.split(r",\s*", line)}:
        assert (package / name).exists() or name.rstrip("/") in inside, f"there is no {name}"
    unnamed = {name for name in files if not re.search(rf"\b{name}\b", text)}
    assert unnamed <= {"__init__", "__main__"}


def test_the_packages_that_a_reader_enters_by_have_a_map():
    entered = {"kinematics", "firmware_protocol", "tui", "armdrive/motion", "armdrive/runtime"}
    assert entered <= WITH_A_MAP.keys()
    assert len(WITH_A_MAP) > 30
