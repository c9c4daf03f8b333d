"""A remedy that names a command names the arm as well, where one was named."""

from __future__ import annotations

from argparse import Namespace

import pytest

from armdrive.cli.presenter import with_arm


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"arm": "bench"}, "run `armdrive home --arm bench`, or call home()"),
        ({"arm": "my arm"}, "run `armdrive home --arm 'my arm'`, or call home()"),
        ({"sim": "cia402", "arm": None}, "run `armdrive home --sim cia402`, or call home()"),
        (
            {"port": "/dev/x", "dialect": "mks"},
            "run `armdrive home --port /dev/x --dialect mks`, or call home()",
        ),
        ({"arm": None, "sim": None}, "run `armdrive home`, or call home()"),
        ({}, "run `armdrive home`, or call home()"),
    ],
)
def test_a_command_names_the_arm_that_was_named(given, said):
    assert with_arm("run `armdrive home`, or call home()", Namespace(**given)) == said


def test_options_stay_and_other_commands_are_left_alone():
    options = Namespace(arm="bench")
    assert with_arm("`armdrive home --confirm`", options) == "`armdrive home --arm bench --confirm`"
    for words in ("`armdrive doctor --can`", "`armdrive ports`", "`armdrive home --arm x`"):
        assert with_arm(words, options) == words


def test_the_remedy_for_settings_names_the_arm_file():
    sentence = "`armdrive doctor --mend` sends these lines"
    assert with_arm(sentence, Namespace(arm="my arm")) == (
        "`armdrive doctor --arm 'my arm' --mend` sends these lines"
    )
    assert with_arm(sentence, Namespace(sim="grbl")) == sentence


def test_a_refused_command_says_so(call):
    sentence = call.refused("move", "--sim", "cia402", "--base", "5", code=3)
    assert "`armdrive home --sim cia402`" in sentence
