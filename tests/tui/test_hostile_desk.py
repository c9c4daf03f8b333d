"""Text of an arm, a device or a file reaches the terminal of the desk as printable text alone."""

import pytest
from desk_fake import FakeArm
from desk_session import Session
from hostile import HOSTILE_TEXT, unprintable
from textual.app import App

from armdrive.status import State
from tui.app import KeyApp
from tui.keys.keyboard import DEFAULT_KEYS
from tui.widgets import PlainText


def painted(app):
    """Return the text of every line that is sent to the terminal."""
    return "\n".join(strip.text for strip in app.screen._compositor.render_strips())


async def test_the_desk_paints_what_an_arm_says_as_printable_text():
    async with Session(FakeArm(state=State.ERROR_STOP), size=(120, 40)) as session:
        for name, text in HOSTILE_TEXT.items():
            said = ("arm", "title", "link", "trust_reason", "last_sent", "last_answer")
            session.arm.set(**dict.fromkeys(said, text), error=f"the device said {text}")
            session.desk.message = text
            await session.poll()
            assert not unprintable(painted(session.desk)), name
        for key in ("question_mark", "escape"):  # a dialog over it, and what is shown after that
            await session.press(key)
            await session.poll()
            assert not unprintable(painted(session.desk)), key


class Plain(App):
    """One text and one list of rows."""

    def compose(self):
        yield PlainText(id="text")
        yield PlainText(id="rows")


async def test_text_and_rows_are_painted_without_control_characters_and_without_markup():
    app = Plain()
    async with app.run_test(size=(80, 10)) as pilot:
        for name, text in HOSTILE_TEXT.items():
            app.query_one("#text", PlainText).show(f"before {text} behind")
            row = f"row {text} and a good deal more of it"
            app.query_one("#rows", PlainText).show_lines([(row, "bold")])
            await pilot.pause()
            seen = painted(app)
            assert not unprintable(seen), name
            assert "before" in seen, name
            assert "row" in seen, name
            if text.isprintable():
                assert seen.count(text) == 2, f"{name}: markup too is text"


class Failing(KeyApp):
    """An app with a fault."""

    def on_mount(self):
        raise LookupError("\x1b[31m nobody foresaw this")


def test_a_fault_of_the_desk_is_raised_and_not_printed(capsys, monkeypatch):
    app = Failing(DEFAULT_KEYS, braille=True)
    monkeypatch.setattr(app, "run", lambda: KeyApp.run(app, headless=True))
    with pytest.raises(LookupError, match="nobody foresaw this"):
        app.run_or_raise()
    said = capsys.readouterr()
    assert "Traceback" not in said.out + said.err
    assert "nobody foresaw" not in said.out + said.err
