"""Settings of a speed table and the step rates that they stand for."""

from hypothesis import given
from hypothesis import strategies as st

from armdrive.dialects.speed_table import SpeedTable

TABLE = SpeedTable(((3, 30.0), (140, 150.0), (190, 250.0), (240, 470.0)))


@given(st.floats(1.0, 600.0))
def test_a_rate_gets_the_fastest_setting_that_is_no_faster(rate_hz):
    no_faster = [each for each in range(3, 241) if TABLE.rate_hz(each) <= rate_hz + 1e-9]
    assert TABLE.setting(rate_hz) == max(no_faster, default=3)


def test_a_setting_of_the_table_is_in_the_part_that_it_begins():
    assert [TABLE.part(setting) for setting in (3, 139, 140, 190, 239, 240)] == [0, 0, 1, 2, 2, 3]
    assert [TABLE.rate_hz(setting) for setting, _ in TABLE.points] == [30.0, 150.0, 250.0, 470.0]
