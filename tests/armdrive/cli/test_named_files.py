"""Files that a person names: each is written once, and overwritten only with --force."""

import pytest

OLD = "what was there before\n"
LONG = "n" * 300
"""More than a file's name may have."""
PROGRAM = "{folder}/ready.arm"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "ready.arm").write_text("ready\n", encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("file", "words", "needed"),
    [
        ("reach.svg", ["plot", "--output"], "matplotlib"),
        ("path.svg", ["run", PROGRAM, "--plot"], "matplotlib"),
        ("it.jsonl", ["run", PROGRAM, "--record"], "homed"),
        ("rows.pendant", ["pendant", "read"], ""),
    ],
)
def test_a_file_goes_into_a_folder_that_exists_and_over_another_only_with_force(
    call, folder, file, words, needed
):
    if needed == "homed":
        call("home", code=0)
    words = [word.format(folder=folder) for word in words]
    missing = folder / "misspelt"
    said = call.refused(*words, str(missing / file), code=2)
    assert f"could not be written: there is no folder {missing}; make it first" in said
    assert not missing.exists()
    ending = file.partition(".")[2]
    for long in (folder / f"{LONG}.{ending}", folder / LONG / file):
        assert "could not be written" in call.refused(*words, str(long), code=2)
    path = folder / file
    words.append(str(path))
    path.write_text(OLD, encoding="utf-8")
    said = call.refused(*words, code=2)
    assert f"{path} exists already: name another file, or add `--force`" in said
    assert path.read_text(encoding="utf-8") == OLD
    if needed == "matplotlib":
        pytest.importorskip("matplotlib")
    call(*words, "--force", code=0)
    assert path.read_text(encoding="utf-8") != OLD
