"""`armdrive completion`: scripts for three shells, and what bash completes with its own."""

import os
import shutil
import subprocess
import sys

import pytest
from cli_calls import write_bench

from armdrive.cli.commands import COMMANDS
from armdrive.cli.set_up.arguments import COMPLETED, SHELLS
from armdrive.cli.set_up.completion import NAMES
from armdrive.registry import DIALECTS

# what bash does on Tab, without a terminal: it calls the function with the words typed so far
TRY = """
source "$SCRIPT"
for line in "$@"; do
    read -ra COMP_WORDS <<< "$line"
    [[ "$line" == *" " ]] && COMP_WORDS+=("")
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    COMPREPLY=()
    complete=$(complete -p armdrive)
    [[ "$complete" =~ -F\\ ([^ ]+) ]]
    "${BASH_REMATCH[1]}" armdrive "${COMP_WORDS[-1]}" "${COMP_WORDS[-2]}"
    echo "${COMPREPLY[*]}"
done
"""


@pytest.mark.parametrize("shell", SHELLS)
def test_a_script_of_every_shell_knows_every_command(call, shell):
    script = call("completion", shell, code=0).out
    assert all(name in script for name in COMMANDS)
    assert "allow-restored" in script
    assert "armdrive completion --names arms" in script
    if shell == "zsh":  # asks for names on Tab, and not while it loads the script
        asking = [line for line in script.splitlines() if "$(armdrive completion" in line]
        assert all(line.startswith('  compadd "$@" -- ') for line in asking)
        assert len(asking) == len(NAMES)


def test_every_name_that_a_script_asks_for_is_given(call, monkeypatch):
    assert set(COMPLETED) == set(NAMES)
    assert call("completion", "--names", "arms", code=0).out == ""
    write_bench()
    assert call("completion", "--names", "arms", code=0).out == "bench\n"
    call("home", code=0)
    call("points", "save", "pick", code=0)
    assert call("completion", "--names", "points", code=0).out == "pick\n"
    monkeypatch.setenv("ARMDRIVE_ARM", "nowhere")  # a file that cannot be read completes nothing
    called = call("completion", "--names", "points", code=0)
    assert (called.out, called.err) == ("", "")


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")
def test_bash_completes_commands_options_names_and_files(call, tmp_path):
    write_bench()
    script = tmp_path / "completion.bash"
    script.write_text(call("completion", "bash", code=0).out, encoding="utf-8")
    command = tmp_path / "armdrive"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m armdrive "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    (tmp_path / "stack.arm").write_text("", encoding="utf-8")
    expected = {
        "armdrive mo": "move",
        "armdrive move --sp": "--speed",
        "armdrive status --sim ": " ".join(DIALECTS),
        "armdrive points g": "go",
        "armdrive status --arm b": "bench",
        "armdrive errors E50": "E501 E502 E503 E504 E505 E506",
        "armdrive run st": "stack.arm",
        "armdrive help verif": "verify",
    }
    environment = {
        **os.environ,
        "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": os.pathsep.join(sys.path),
        "SCRIPT": str(script),
    }
    ended = subprocess.run(
        ["bash", "-c", TRY, "bash", *expected],
        capture_output=True, text=True, check=True, cwd=tmp_path, env=environment,
    )  # fmt: skip
    assert dict(zip(expected, ended.stdout.splitlines(), strict=True)) == expected
