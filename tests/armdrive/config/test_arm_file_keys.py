"""The page that lists an arm file's keys is what the schema says, and each key has a meaning."""

import re
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from armdrive.config.sections import Connection
from armdrive.config.write import complete
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import preset_arm
from armdrive.text.toml import rule_of

DOCS = Path(__file__).parents[3] / "docs"
sys.path.append(str(DOCS))
import arm_file_keys  # noqa: E402

sys.path.remove(str(DOCS))

SECTIONS = {
    **dict(arm_file_keys.SECTIONS),
    **dict(arm_file_keys.MODEL_SECTIONS),
    **{row.name: row.settings() for row in DIALECTS.values()},
}
KEYS = [(name, key) for name, kind in SECTIONS.items() for key in fields(kind)]


def test_the_page_is_as_the_schema_is():
    kept = arm_file_keys.PAGE.read_text(encoding="utf-8")
    assert kept == arm_file_keys.page(), "write it again: python docs/generated.py"


@pytest.mark.parametrize(("section", "key"), KEYS, ids=lambda it: getattr(it, "name", it))
def test_every_key_has_a_meaning_and_is_on_the_page(section, key):
    assert rule_of(key).help
    _, _, table = arm_file_keys.page().partition(f"## `[{section}]`")
    assert f"| `{key.name}` |" in table.partition("\n## ")[0]


@pytest.mark.parametrize("row", DIALECTS.values(), ids=DIALECTS)
def test_a_whole_file_says_what_the_keys_of_its_dialect_mean(row):
    config = preset_arm(row.preset, name="bench", connection=Connection(row.name))
    _, _, section = complete(config, config.source.table).partition(f"\n[{row.name}]")
    written = section.partition("\n\n")[0]
    for key in fields(row.settings()):
        if getattr(config.device, key.name) is not None:
            (line,) = re.findall(rf"(?m)^{key.name} = .*$", written)
            assert line.endswith(f"# {rule_of(key).help}")
