"""Other keys: layouts, files, what is wrong with them; and that the desk then hears them."""

import pytest
from desk_fake import FakeArm
from desk_session import Session

from armdrive.errors import KeyFileError
from armdrive.moves import Jog
from armdrive.storage import files as places
from tui.keys.keyboard import DEFAULT_KEYS, as_markdown
from tui.keys.remap import LAYOUTS, load_keys
from tui.keys.table import JOG_PAIRS, TABLE


@pytest.fixture
def written(tmp_path):
    """Write a file of keys and return its path."""

    def write(text):
        path = tmp_path / "keys.toml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def test_without_a_file_the_table_is_as_it_stands():
    assert load_keys(None) is DEFAULT_KEYS


def test_the_users_own_file_is_read_where_it_is(monkeypatch, tmp_path):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    places.key_file().parent.mkdir(parents=True)
    places.key_file().write_text('[keys]\narm = "f9"\n')
    assert load_keys(None).of("arm") == ("f9",)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout_gives_every_axis_keys_and_takes_none_away(layout):
    keyboard = load_keys(layout)
    assert {row.id for row in keyboard.rows} == {row.id for row in TABLE}
    assert all(row.keys for row in keyboard.rows)


def test_qwerty_is_the_table():
    assert load_keys("qwerty") == DEFAULT_KEYS


def test_a_file_says_which_layout_and_which_keys_beside_it(written):
    keyboard = load_keys(written('layout = "azerty"\n[keys]\narm = ["f9", "*"]\nfiner = "f10"\n'))
    assert keyboard.label("axis-1-plus") == "a"
    assert keyboard.label("axis-2-plus") == "z"
    assert keyboard.of("arm") == ("f9", "asterisk")
    assert keyboard.label("finer") == "f10"


def test_the_space_bar_stops_whatever_a_file_says(written):
    keyboard = load_keys(written('[keys]\nstop = "f12"\n'))
    assert keyboard.of("stop") == ("space", "f12", "ctrl+c")
    assert keyboard.next_keys("jog")[0].id == "stop"
    assert keyboard.label("stop") == "space"


WRONG = [
    ('[keys]\nfinner = "f8"\n', "'finner'", "did you mean 'finer'?"),
    ('layout = "azertty"\n', "'azertty'", "did you mean 'azerty'?"),
    ('finer = "f10"\n', "'finer'", "did you mean"),
    ('[keys]\narm = "entre"\n', "'entre' is no key", "did you mean 'enter'?"),
    ('[keys]\narm = "space"\n', "space would be both", "arm"),
    ('[keys]\narm = "m"\n', "m would be both", "mode"),
    ('[keys]\narm = "R"\n', "R would be both", "reset"),
    ('[keys]\nno = "y"\n', "y would be both", "yes"),
    ('[keys]\nyes = "escape"\n', "Esc would be both", "stop"),
    ("[keys]\narm = []\n", "arm is a key", "[]"),
    ("[keys]\narm = 7\n", "arm is a key", "7"),
    ("keys = 7\n", "keys is a table", ""),
    ("[keys\n", "is not valid TOML", ""),
]


@pytest.mark.parametrize(("text", "what", "way"), WRONG, ids=[what for _, what, _ in WRONG])
def test_what_is_wrong_is_named_with_what_was_meant(written, text, what, way):
    path = written(text)
    with pytest.raises(KeyFileError) as caught:
        load_keys(path)
    assert path in str(caught.value)
    assert what in str(caught.value)
    assert way in str(caught.value)


def test_a_file_that_is_not_there_may_have_been_meant_for_a_layout():
    with pytest.raises(KeyFileError, match="did you mean 'azerty'"):
        load_keys("azery")


async def test_the_desk_hears_and_shows_the_keys_of_the_layout():
    async with Session(keys=load_keys("azerty")) as session:
        await session.arm_keys()
        await session.tap("a", "q", "z", after_s=3.0)
        jogs = [call[1] for call in session.arm.asked("nudge")]
        assert jogs == [Jog.joint(base=2.0), Jog.joint(base=-2.0), Jog.joint(shoulder=2.0)]
        assert " a  q   base" in session.text("joints")
        await session.press("w", after_s=3.0)
        assert len(session.arm.asked("nudge")) == 3, "w is no key any more"
        await session.press("comma")
        assert "step [1°] 2 mm" in session.text("stopping")


@pytest.mark.parametrize("layout", LAYOUTS)
async def test_every_jog_key_of_every_layout_moves_its_own_axis(layout):
    keyboard = load_keys(layout)
    async with Session(keys=keyboard) as session:
        await session.arm_keys()
        ids = [f"axis-{row}-{way}" for row in range(1, 7) for way in ("plus", "minus")]
        for name in ids:
            await session.tap(keyboard.of(name)[0], after_s=3.0)
        wanted = [Jog.joint(**{p.joint: s}) for p in JOG_PAIRS[:6] for s in (2.0, -2.0)]
        assert [call[1] for call in session.arm.asked("nudge")] == wanted


async def test_a_key_that_was_moved_works_in_dialogs_and_everywhere(written):
    keys = load_keys(written('[keys]\nyes = "o"\nstop = "f12"\nquit = "f10"\n'))
    async with Session(FakeArm(simulated=False), keys=keys) as session:
        await session.press("H", "y")
        assert len(session.desk.screen_stack) == 2
        await session.press("o")
        await session.settle()
        assert session.arm.asked("reference") == [("reference",)]
        session.arm.calls.clear()
        await session.press("H", "f12")
        assert session.arm.calls == [("stop",)]
        await session.press("ctrl+q")
        assert session.desk.is_running
        await session.press("f10")
    assert session.desk.return_value == 0


def test_every_row_stands_in_the_documentation_of_keys():
    lines = list(as_markdown(DEFAULT_KEYS))
    assert len(lines) == len(TABLE) + 2
