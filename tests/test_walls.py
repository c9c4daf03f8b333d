"""The walls of the house: which room may import what (pyproject.toml, tool.importlinter)."""

from importlinter.cli import lint_imports


def test_no_room_imports_what_its_walls_forbid(capsys):
    assert lint_imports(no_cache=True) == 0, capsys.readouterr().out
