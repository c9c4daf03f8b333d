"""How a program's lines and times are shown while it runs."""

import pytest

from armdrive.cli.program.run_common import duration, line_words


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("approach pick, 60      # to 60 mm before it", "approach pick, 60"),
        ('type "no. #1", n  # says so', 'type "no. #1", n'),
        ('arm.points["it\'s #1"]', 'arm.points["it\'s #1"]'),
        ("name = 'a#b'  # one", "name = 'a#b'"),
        ('type "never closed # here', 'type "never closed # here'),
        ("ready", "ready"),
    ],
)
def test_a_line_is_shown_without_its_comment(text, shown):
    assert line_words(3, text) == f"line 3: {shown}"


def test_times_are_written_in_what_they_are_counted_in():
    times = {4.26: "4.3 s", 42.4: "42 s", 100.0: "1 min 40 s", 7500.0: "2 h 5 min"}
    assert {time_s: duration(time_s) for time_s in times} == times
