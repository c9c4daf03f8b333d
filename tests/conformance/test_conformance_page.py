"""The page and the table show what was run: no row is missing, and each broken row is named."""

import re

from pages import page_path

from armdrive.registry import DIALECTS

from .behaviour import EVERYWHERE
from .running import BEHAVIOURS, BENCHES, RowResult, Verdict
from .table import page, text

PAGE = page_path("conformance")
SOME = BEHAVIOURS[:2]


def result(verdict=Verdict.KEPT, transport="memory", words="", row=SOME[0]):
    return RowResult(row.name, "teachmover", transport, verdict, words)


def test_the_page_has_every_behaviour_and_every_dialect():
    shown = PAGE.read_text(encoding="utf-8")
    both = re.sub(
        r"^([-|] .*), in motion and standing(.*)$",
        r"\1, in motion\2\n\1, standing\2",
        shown,
        flags=re.MULTILINE,
    )
    names = set(re.findall(r"^[-|] (.*?)(?: \||$)", both, re.MULTILINE))
    assert {row.name for row in BEHAVIOURS} <= names
    assert f"| behaviour | {' | '.join(DIALECTS)} |" in shown


def test_a_single_word_holds_for_all_transports():
    found = [result(), result(transport="pty"), result(row=SOME[1]), result(Verdict.BROKEN, "pty")]
    assert f"- {SOME[0].name}\n" in page(SOME, found[:3], "make it")
    assert f"| {SOME[0].name} | yes · NO |" in page(SOME, [found[0], found[3]], "make it")


def test_a_row_for_one_transport_shows_that_one():
    own = next(row for row in BEHAVIOURS if row.transports == ("udp",))
    found = [result(transport=each) for each in ("memory", "pty")]
    found.append(result(transport="udp", row=own))
    shown = page((SOME[0], own), found, "make it")
    assert f"- {SOME[0].name}\n" in shown
    assert f"- {own.name}\n" in shown


def test_every_row_is_run_somewhere():
    assert set(BENCHES) | {"port"} >= set(EVERYWHERE)
    assert not [row.name for row in BEHAVIOURS if not set(row.transports) & set(BENCHES)]


def test_a_broken_row_is_named():
    found = [result(Verdict.BROKEN, words="it moved")]
    sentence = f"{SOME[0].name} (teachmover, memory): it moved"
    assert sentence in text(SOME, found)
    assert f"- {sentence}" in page(SOME, found, "make it")
    assert "0 kept, 1 broken" in text(SOME, found)


def test_a_row_that_is_not_applicable_is_shown_with_its_reason():
    found = [result(Verdict.NOT_APPLICABLE, words="no such switch")]
    assert "- no such switch (teachmover)" in page(SOME, found, "make it")
