"""The shell's own words in the table of words are those that it carries out."""

from armdrive.programs.language.words import SHELL
from armdrive.programs.shell import OWN_WORDS
from armdrive.sim.world.table import PARTS


def test_the_table_lists_the_shells_own_words():
    assert [word.name for word in SHELL] == list(OWN_WORDS)
    assert f"put {PARTS}" in [word.pattern for word in SHELL]
