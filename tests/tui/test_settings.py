"""Mode, increment and speed, and what a jog key means under them."""

from armdrive.moves import Jog, Space
from tui.settings import INCREMENTS, SPEEDS, Settings


def test_increments_and_speeds_stop_at_the_ends_of_their_rows():
    assert Settings().with_increment(99).increment == INCREMENTS[-1]
    assert Settings().with_increment(-99).increment == INCREMENTS[0]
    assert Settings().with_speed(99).speed == SPEEDS[-1]
    assert Settings().with_speed(-99).speed == SPEEDS[0]


def test_the_mode_goes_to_and_fro():
    assert Settings().other_mode().cartesian
    assert Settings().other_mode().other_mode() == Settings()


def test_a_tap_is_a_distance_and_a_hold_a_direction():
    coarse = Settings().with_increment(1)
    assert coarse.increment_of("a") == Jog.joint(base=-5.0)
    assert coarse.direction_of("a") == Jog.joint(base=-1.0)
    assert coarse.other_mode().increment_of("up") == Jog(Space.CARTESIAN, (("z", 5.0),))


def test_frames_go_round_and_count_only_where_the_tip_is_jogged():
    settings = Settings(frames=("base", "tool"))
    assert settings.with_next_frame().with_next_frame() == settings
    tool = settings.with_next_frame()
    assert tool.increment_of("up").frame == "base"  # a joint turns in no frame
    assert tool.other_mode().increment_of("up") == Jog(Space.CARTESIAN, (("z", 2.0),), "tool")
