"""`armdrive points`: naming, listing, going, running; each command goes on from the last one."""

import pytest
from cli_calls import write_arm_file, write_bench

from armdrive.storage import files as places


@pytest.fixture
def taught(call):
    """A simulated arm with two points."""
    call("home", code=0)
    call("move", "--x", "250", "--z", "120", "--pitch", "-90", code=0)
    call("points", "save", "above", "--note", "over the block", code=0)
    call("move", "--z", "60", "--line", code=0)
    call("points", "save", "pick", code=0)
    return call


def joints(call):
    return call("status", "--json", code=0).json["joints"]


def test_points_are_listed_shown_and_gone_to(taught):
    listed = taught("points", "list", code=0).out
    assert str(places.points_file("sim:teachmover")) in listed
    assert "over the block" in listed
    view = taught("points", "list", "--json", code=0).json
    assert list(view["points"]) == ["above", "pick"]
    shown = taught("points", "show", "above", code=0).out
    assert "tip x 250." in shown
    assert taught("points", "show", "pick", "--json", code=0).json["pose"]["z_mm"] == pytest.approx(
        60, abs=0.5
    )
    before = joints(taught)
    preview = taught("points", "go", "above", "--line", "--preview", code=0).out
    assert "-> elbow up" in preview
    assert joints(taught) == before
    gone = taught("points", "go", "above", "--line", "--speed", "0.5", "--json", code=0).json
    assert gone["pose"]["z_mm"] == pytest.approx(120, abs=0.5)


def test_points_are_renamed_and_deleted(taught):
    taught("points", "rename", "pick", "grip", code=0)
    assert list(taught("points", "list", "--json", code=0).json["points"]) == ["above", "grip"]
    assert taught("points", "delete", "grip", "--json", code=0).json["done"]
    assert "grip" not in taught("points", "list", code=0).out


def test_a_sequence_that_a_person_wrote_is_shown_and_run(taught):
    path = places.points_file("sim:teachmover")
    path.write_text(
        path.read_text(encoding="utf-8")
        + '[sequences.lift]\nsteps = [{ point = "above" }, { wait_s = 0.1 }, { point = "pick", how = "line" }]\n',  # noqa: E501
        encoding="utf-8",
    )
    assert "3 steps" in taught("points", "list", code=0).out
    assert "along a line" in taught("points", "show", "lift", code=0).out
    assert taught("points", "show", "lift", "--json", code=0).json["steps"][1] == "delay 0.1 s"
    ran = taught("points", "run", "lift", code=0).out
    assert "  3  to pick along a line" in ran
    assert "used by lift" in taught.refused("points", "delete", "pick", code=2)
    taught("points", "rename", "pick", "grip", code=0)
    assert taught("points", "run", "lift", "--json", code=0).json["pose"]["z_mm"] < 61
    taught("points", "delete", "lift", code=0)
    assert "lift" not in taught("points", "list", code=0).out


def test_what_is_wrong_is_one_sentence(taught):
    assert "did you mean 'pick'" in taught.refused("points", "go", "pikc", code=2)
    assert "already" in taught.refused("points", "save", "pick", code=2)
    taught("points", "save", "pick", "--again", "--json", code=0)
    assert "is not a valid name" in taught.refused("points", "save", "a b", code=2)
    assert "no sequence" in taught.refused("points", "run", "pick", code=2)
    places.points_file("sim:teachmover").write_text("[points.a]\nknee = 3\n", encoding="utf-8")
    assert "unknown key 'knee'" in taught.refused("points", "list", "--json", code=2)


def test_no_points_say_how_one_is_made_and_need_no_port(call):
    write_arm_file(
        "bench", 'model = "teachmover"\n[connection]\ndialect = "teachmover"\nport = "/dev/none"\n'
    )
    assert "points save NAME" in call("points", "list", "--arm", "bench", code=0).out
    assert not places.points_file("bench").exists()


def test_the_place_of_an_unreferenced_arm_is_not_taught(call):
    call.refused("points", "save", "pick", "--fresh", code=3)


@pytest.mark.parametrize(
    "words",
    ["points save 9a", "points go nowhere", "points run nowhere", "teach here 9a",
     "teach here tour --point 9a"],
)  # fmt: skip
def test_a_wrong_name_is_refused_before_the_arm_is_opened(call, words):
    write_bench()  # whose port is not there
    call.refused(*words.split(), "--arm", "bench", code=2)
