"""A model file for the commands that read one."""

import pytest
from chain_files import shown_links


@pytest.fixture
def own(tmp_path):
    """Return the path of a file with the link table that the docs show."""
    path = tmp_path / "mine.toml"
    path.write_text(shown_links(), encoding="utf-8")
    return str(path)
