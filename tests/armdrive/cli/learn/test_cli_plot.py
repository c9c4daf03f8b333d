"""`armdrive plot`: what an arm reaches, in characters and in files."""

from __future__ import annotations

import sys

import pytest

from armdrive.render.sketch import Sketch, reach_sketches, section_sketch, sketch_rows
from kinematics import PRESETS, preset
from kinematics.textbook.systems import system

WORKSPACE = ("plot", "workspace")


@pytest.mark.parametrize("key", PRESETS)
def test_every_arm_is_drawn(call, key):
    said = call(*WORKSPACE, "--model", key, "--ascii", code=0).out
    assert said.isascii()
    lines = said.splitlines()
    assert "reach of the finger tips at pitch -90 deg" in lines[0]
    assert "distance from the base axis across" in lines[-1]
    assert set("".join(lines[1:-1])) & set("-|/\\")


@pytest.mark.parametrize("name", ["two-link-4", "cartesian", "puma"])
def test_another_system_is_drawn_from_two_sides(call, name):
    lines = call(*WORKSPACE, "--model", name, "--ascii", code=0).out.splitlines()
    assert lines[0].endswith("places that the tool reached")
    assert lines[-2].startswith("x across")
    assert "z up" in lines[-2]
    assert "y up" in lines[-1]
    assert sum(line.count(".") for line in lines[1:-2]) > 10


def test_ones_own_link_table_is_drawn(call, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("title = 'A stick'\n[[links]]\na_mm = 100\n", encoding="utf-8")
    said = call(*WORKSPACE, "--model", str(path), "--ascii", code=0).out
    assert said.startswith("A stick: places")
    assert "y up, -100 to 100 mm" in said


def test_pitch_and_azimuth_choose_the_section(call):
    level = call(*WORKSPACE, "--pitch", "0", "--azimuth", "45", "--json", code=0).json
    assert level["title"].endswith("at pitch 0°, azimuth 45°")
    down = call(*WORKSPACE, "--json", code=0).json
    assert level["views"][0]["box_mm"] != down["views"][0]["box_mm"]
    assert down["views"][0]["curves"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--model", "pumo"), "did you mean 'puma'"),
        (("--model", "puma", "--pitch", "0"), "other arms are drawn whole"),
        (("--output", "reach.jpg"), "should end in .png or .svg"),
    ],
)
def test_a_wrong_word_is_named(call, words, said):
    assert said in call.refused(*WORKSPACE, *words, code=2)


def test_without_matplotlib_the_extra_is_named(call, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    said = call.refused(*WORKSPACE, "--output", str(tmp_path / "reach.png"), code=2)
    assert "pip install 'armdrive[plot]'" in said


@pytest.mark.parametrize(("ending", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml")])
@pytest.mark.parametrize("model", ["teachmover", "puma"])
def test_files_are_written(call, tmp_path, model, ending, begins):
    pytest.importorskip("matplotlib", reason="drawing files needs the extra `plot`")
    path = tmp_path / f"reach.{ending}"
    said = call(*WORKSPACE, "--model", model, "--output", str(path), code=0).out
    assert f"written to {path}" in said
    assert path.read_bytes().startswith(begins)


def test_an_unwritable_file_is_reported(call, tmp_path):
    pytest.importorskip("matplotlib", reason="drawing files needs the extra `plot`")
    call.refused(*WORKSPACE, "--output", str(tmp_path / "no" / "reach.png"), code=1)


def test_every_point_of_a_section_is_in_its_box_and_reached():
    arm = preset("minimover5").arm
    sketch = section_sketch(arm, -90.0, 0.0)
    (left, right), (low, high) = sketch.reach_box_mm
    assert sketch.points
    assert all(left <= x <= right and low <= z <= high for x, z in sketch.points)


def test_the_two_views_of_a_chain_share_x():
    side, above = reach_sketches(system("puma").chain())
    assert side.reach_box_mm[0] == above.reach_box_mm[0]


def test_a_square_is_drawn_at_one_scale_for_both_axes():
    corners = ((10.0, 10.0), (50.0, 10.0), (50.0, 50.0), (10.0, 50.0), (10.0, 10.0))
    rows = sketch_rows(Sketch((corners,), (), "x", "y"), 60, 20, braille=False)
    drawn = [row for row in rows if "-" in row or "|" in row or "+" in row]
    width = max(len(row.rstrip()) for row in drawn) - min(
        min(row.find(mark) for mark in "-|+" if mark in row) for row in drawn
    )
    assert len(rows) == 20
    assert all(len(row) == 60 for row in rows)
    assert width == pytest.approx(2 * len(drawn), abs=2)


def test_braille_and_an_empty_sketch():
    rows = sketch_rows(Sketch((), ((1.0, 1.0),), "x", "y"), 10, 4, braille=True)
    assert any(ord(character) > 0x2800 for row in rows for character in row)
    empty = Sketch((), (), "x", "y")
    assert empty.caption == "x across, 0 to 0 mm; y up, 0 to 0 mm"
    assert len(sketch_rows(empty, 10, 4, braille=False)) == 4
