"""The docs say what is true: the arm file they show is complete and means the preset itself."""

import dataclasses
import pkgutil
import re
import sys
import tomllib

import pytest
from amounts import every_row
from pages import DOCS, PAGES, ROOT, blocks, page

from armdrive.config import arm as armfile
from armdrive.config import sections as armsections
from armdrive.config.write import complete
from armdrive.dialects.teachmover.settings import TeachMoverSettings
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm, preset_arm
from armdrive.text.toml import rule_of
from kinematics import preset
from kinematics.geometry import Tool

sys.path.append(str(DOCS))
import arm_file_keys
import generated

sys.path.remove(str(DOCS))

PACKAGES = ("armdrive", "firmware_protocol", "kinematics", "tui")


def test_the_shown_arm_file_lists_every_key_and_means_the_preset():
    shown = tomllib.loads(re.search(r"```toml\n(.*?)```", page("arm-file"), re.DOTALL)[1])
    assert {*armfile.PRESET_KEYS, "teachmover"} - {"homing"} == set(shown)
    for name, section in {
        "connection": armsections.Connection,
        "motion": armsections.MotionSettings,
        "gripper": armsections.GripperSettings,
        "teachmover": TeachMoverSettings,
        "reference": armsections.PostureSettings,
        "park": armsections.PostureSettings,
        "tool": Tool,
    }.items():
        assert set(shown[name]) == {field.name for field in dataclasses.fields(section)}, name
    keys = {field.name for field in dataclasses.fields(armsections.FrameSettings)}
    assert set(shown["frames"]["board"]) == keys
    config, model = parse_arm(shown, name="shown"), preset("teachmover")
    assert (config.motion, config.device) == (armsections.MotionSettings(), TeachMoverSettings())
    assert (config.bare.arm, config.bare.guards) == (model.arm, model.guards)  # without the tool


@every_row("path", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere_and_those_of_the_site_stay_within_it(path):
    text = path.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", text):
        if "://" not in target:
            there = path.parent / target
            assert there.exists(), f"{path.name} links to {target}"
            assert DOCS not in path.parents or DOCS in there.resolve().parents, target
    for name, target in re.findall(r"\[`?([\w/]+\.py)`?\]\(([^)#]+)", text):
        assert f"/{target}".endswith(f"/{name}"), f"{path.name} calls {target} {name}"


def pages_in(nav) -> list[str]:
    """Return every page of a table of contents."""
    if isinstance(nav, str):
        return [nav]
    inner = nav.values() if isinstance(nav, dict) else nav
    return [name for each in inner for name in pages_in(each)]


def test_every_page_stands_once_in_the_table_of_contents():
    site = tomllib.loads((ROOT / "zensical.toml").read_text(encoding="utf-8"))
    there = [path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")]
    assert sorted(pages_in(site["project"]["nav"])) == sorted(there)


def test_the_shown_homing_is_read():
    (shown,) = [text for text in blocks(page("arm-file"), "toml") if "[homing]" in text]
    config = parse_arm(tomllib.loads('model = "teachmover"\n' + shown), name="shown")
    assert config.homing.groups == ((2,), (3,), (1, 4, 5))


@pytest.mark.parametrize("package", PACKAGES)
def test_a_page_that_the_program_names_exists(package):
    for path in sorted((ROOT / package).rglob("*.py")):
        for name in re.findall(r"\bdocs/[\w/.-]+\.md", path.read_text(encoding="utf-8")):
            assert (ROOT / name).is_file(), f"{path.relative_to(ROOT)} names {name}"


def suffixes(path: str) -> list[str]:
    parts = path.split("/")
    return ["/".join(parts[i:]) for i in range(len(parts))]


MODULES = {
    part
    for root in (*PACKAGES, "tests", "benchmarks", "docs", "examples")
    for path in (ROOT / root).rglob("*.py")
    for part in suffixes(path.relative_to(ROOT).as_posix())
}
"""Every module of the project, by its path from any folder above it."""

MADE_UP = {"stack.py"}
"""Files that a reader has or makes."""


@pytest.mark.parametrize("package", PACKAGES)
def test_a_module_that_names_another_by_its_file_names_one_that_is_there(package):
    for path in sorted((ROOT / package).rglob("*.py")):
        named = set(re.findall(r"(?<![\w/.])[\w/]+\.py\b", path.read_text(encoding="utf-8")))
        assert named <= MODULES | MADE_UP, f"{path.relative_to(ROOT)}: {named - MODULES}"


@every_row("path", PAGES, ids=lambda p: p.name)
def test_a_page_names_no_module_that_is_not_there(path):
    text = path.read_text(encoding="utf-8")
    named = set(re.findall(rf"(?<![\w/.])(?:{'|'.join(PACKAGES)}|tests)/[\w/]+\.py\b", text))
    made = set(re.findall(r"^`([\w/]+\.py)`:$", text, re.MULTILINE))  # and its text follows
    assert named - made <= MODULES, f"{path.name}: {named - made - MODULES}"


@pytest.mark.parametrize("package", PACKAGES)
def test_a_docstring_names_nothing_of_the_packages_that_is_not_there(package):
    dotted = re.compile(rf"`((?:{'|'.join(PACKAGES)})(?:\.\w+)+)")
    for path in sorted((ROOT / package).rglob("*.py")):
        for name in dotted.findall(path.read_text(encoding="utf-8")):
            try:
                pkgutil.resolve_name(name)
            except (ImportError, AttributeError):
                pytest.fail(f"{path.relative_to(ROOT)} names {name}")


# What is generated.


@every_row("path, text", generated.files(), ids=lambda row: row[0].name)
def test_a_generated_page_is_fresh(path, text):
    assert path.read_text(encoding="utf-8") == text, "run: python docs/generated.py"


def test_every_generated_part_stands_on_one_page():
    text = "".join(path.read_text(encoding="utf-8") for path in PAGES)
    for name in generated.PARTS:
        assert text.count(f"<!-- {name} -->") == 1, name


SECTIONS = {
    **dict(arm_file_keys.SECTIONS),
    **dict(arm_file_keys.MODEL_SECTIONS),
    **{row.name: row.settings() for row in DIALECTS.values()},
}


def test_every_key_of_an_arm_file_has_a_meaning_and_is_on_the_page():
    text = arm_file_keys.page()
    for section, kind in SECTIONS.items():
        table = text.partition(f"## `[{section}]`")[2].partition("\n## ")[0]
        for key in dataclasses.fields(kind):
            assert rule_of(key).help, (section, key.name)
            assert f"| `{key.name}` |" in table, (section, key.name)


@pytest.mark.parametrize("row", DIALECTS.values(), ids=DIALECTS)
def test_a_whole_file_says_what_the_keys_of_its_dialect_mean(row):
    connection = armsections.Connection(row.name)
    config = preset_arm("bench", connection)
    _, _, section = complete(config, config.source.table).partition(f"\n[{row.name}]")
    written = section.partition("\n\n")[0]
    for key in dataclasses.fields(row.settings()):
        if getattr(config.device, key.name) is not None:
            (line,) = re.findall(rf"(?m)^{key.name} = .*$", written)
            assert line.endswith(f"# {rule_of(key).help}")
