"""A model file for the commands that read one, and maps of the reach that are made quickly."""

import pytest
from chain_files import shown_links

from armdrive.render import sketch


@pytest.fixture
def own(tmp_path):
    """Return the path of a file with the link table that the docs show."""
    path = tmp_path / "mine.toml"
    path.write_text(shown_links(), encoding="utf-8")
    return str(path)


@pytest.fixture(autouse=True)
def sparse_maps(monkeypatch):
    """Sample a fifteenth of the postures: a terminal shows no gaps between so many."""
    monkeypatch.setattr(sketch, "_MAPPED", sketch._MAPPED // 15)
