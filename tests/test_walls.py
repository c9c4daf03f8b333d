"""The walls between packages (pyproject.toml, tool.importlinter), and that no import is a cycle."""

from collections.abc import Iterator

import grimp
from importlinter.cli import lint_imports

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
