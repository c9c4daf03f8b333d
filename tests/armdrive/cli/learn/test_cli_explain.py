"""`armdrive explain`: the worked example of a named system or of the reader's own link table."""

import re

import pytest

from kinematics.textbook.systems import SYSTEMS


def test_the_list_names_every_system_with_its_source(call):
    said = call("explain", "--list", code=0).out
    for name, each in SYSTEMS.items():
        assert name in said
        assert each.notes.source in said
    assert call("explain", code=0).out == said
    listed = call("explain", "--list", "--json", code=0).json["systems"]
    assert [each["name"] for each in listed] == list(SYSTEMS)


@pytest.mark.parametrize("name", ["three-link", "puma"])
def test_a_system_is_explained(call, name):
    said = call("explain", name, code=0).out
    assert said.startswith(SYSTEMS[name].title)
    for heading in ("Figure", "Links", "A matrices", "Forward", "How it is solved", "Inverse"):
        assert f"\n== {heading}" in said
    found = call("explain", name, "--json", code=0).json
    assert len(found["links"]) == len(found["joints"])
    assert found["branches"]
    for section in found["sections"]:  # one text, for people and for programs
        assert "\n".join(["", f"== {section['title']}", *section["lines"], ""]) in said
    (product,) = re.findall(r"^T = (.*)$", said, re.MULTILINE)
    assert f"T = {product} =\n" in call("explain", name, "--symbolic", code=0).out


@pytest.mark.parametrize("goal", [("99.51", "57.45", "296.42"), ("99.51", "57.45", "290")])
def test_a_goal_read_off_a_page_is_met(call, goal):
    called = call("explain", "two-link-2", "--goal", *goal)
    if called.code:  # off the sphere: what is offered instead is met, as it is printed
        instead = re.findall(r"[xyz] (-?[\d.]+) mm", called.err.rpartition("reaches: ")[2])
        called = call("explain", "two-link-2", "--goal", *instead)
    assert called.code == 0
    assert "2 solutions" in called.out


def test_ones_own_link_table_is_explained(call, own):
    said = call("explain", own, "0", "-40", "60", "-110", "0", code=0).out
    assert said.startswith("Alpha II with a pen\nsource: Asokan")
    assert "base: frame 0 in the world" in said
    assert "tool: the tool in the last frame" in said
    assert "the goal is met" in said
    said = call("explain", own, "--goal", "300", "40", "150", code=0).out
    assert said.endswith("\ncomes to x 300 mm, y 40 mm, z 150 mm\nthe goal is met\n")
    said = call.refused("explain", own, "--goal", "300", "40", code=2)
    assert "or x_mm, y_mm, z_mm alone, not 2 numbers" in said


def test_symbols_are_written_in_the_notation_of_the_notes(call, own):
    said = call("explain", "two-link-1", "--symbolic", code=0).out
    assert "[ C12  -S12  0  l1 C1 + l2 C12 ]" in said
    assert "theta1 = direction - lift" in said
    said = call("explain", own, "--symbolic", code=0).out
    assert "T = base A1 A2 A3 A4 A5 tool" in said
    _, product, solutions = call("explain", "two-link-1", "--symbolic", "--json", code=0).json[
        "sections"
    ]
    assert product["lines"][1] == "[ C12  -S12  0  l1 C1 + l2 C12 ]"
    assert solutions["lines"][:2] == ["elbow up", "  D = sqrt(x^2 + y^2)"]
    said = call("explain", "three-link", "--symbolic", code=0).out
    assert re.search(r"^tool =\n\[ .* l3 \]$", said, re.MULTILINE)


def test_latex_is_only_formulas_and_comments(call):
    said = call("explain", "two-link-1", "--latex", code=0).out
    assert said.startswith("% Type 1 two-link manipulator")
    assert r"\theta_{1} = \mathrm{direction} - \mathrm{lift}" in said
    for block in re.sub(r"\\\[.*?\\\]", "", said, flags=re.DOTALL).splitlines():
        assert not block.strip() or block.startswith("%")
    assert "l_{1} C_{1} + l_{2} C_{12}" in said


def lines_of(call, *words):
    """Return the lines of a page's sections by their titles."""
    sections = call("explain", *words, "--json", code=0).json["sections"]
    return {each["title"]: [line.split() for line in each["lines"]] for each in sections}


def test_accuracy_tells_what_steps_and_errors_do(call):
    assert "== what a motor step does to the tip" in call("explain", "accuracy", code=0).out
    found = lines_of(call, "accuracy", "teachmover", "10", "40", "-60", "-70", "0")
    base, shoulder, elbow, *_ = found["what a motor step does to the tip"]
    assert (base[0], shoulder[0], elbow[0]) == ("base", "shoulder", "elbow")
    assert 0.2 < float(elbow[1]) < 0.3
    ((rms_mm, *_, bound_mm, _, _, _),) = found["rounding to whole steps"]
    assert float(rms_mm) < float(bound_mm)


def test_efficiency_prints_counts(call, own):
    said = call("explain", "efficiency", code=0).out
    assert "== Mini-mover 5" in said
    (mine,) = lines_of(call, "efficiency", own).values()
    assert len(mine) == 7  # three ways forward, their heading and what they are; none inverse
    (found,) = lines_of(call, "efficiency", "two-link-1").values()
    assert found[0][:2] == ["forward", "multiplications"]
    products = {line[0]: int(line[2]) for line in found[1:4]}
    assert products["full"] > products["own"] > 0


STAGES = ("The joints", "Frame 0", "Frame 1", "Frame 2", "Link 1, joint theta1", "Link 2")


@pytest.mark.parametrize("convention", ["standard", "craig"])
def test_frames_are_found_from_axes_in_drawn_steps(call, convention):
    said = call("explain", "--axes", "two-link-2", "--convention", convention, code=0).out
    found = [said.index(f"\n== {stage}") for stage in STAGES]
    assert found == sorted(found)
    for number in range(1, 14):
        assert f"\n{number}. " in said
    first_link = said[found[-2] : found[-1]]
    for label in ("L0", "b1", "z0", "x1", "joint axis"):
        assert label in first_link.split("13. ")[1], f"{label} is drawn"
    assert f"two-link-2: {convention} convention" in said


def test_a_file_of_axes_is_any_command_s_model(call, tmp_path):
    path = tmp_path / "planar.toml"
    path.write_text(
        "[[axes]]\npoint_mm = [0, 0, 0]\ndirection = [0, 0, 1]\n"
        "[[axes]]\npoint_mm = [200, 0, 0]\ndirection = [0, 1e-8, 1]\n"
        "[tip]\npoint_mm = [350, 0, 0]\n",
        encoding="utf-8",
    )
    said = call("explain", "--axes", str(path), code=0).out
    assert "axes 1 and 2 are nearly parallel (1e-08 rad apart), and taken as parallel" in said
    found = call("fk", "--model", str(path), "90", "-90", "--json", code=0).json
    assert found["position_mm"] == pytest.approx([150, 200, 0], abs=1e-4)
    path.write_text(path.read_text(encoding="utf-8").replace("1e-8, 1]", "0, 0]"), encoding="utf-8")
    refused = call.refused("explain", "--axes", str(path), code=2)
    assert "axes[2].direction: the zero vector has no direction" in refused
