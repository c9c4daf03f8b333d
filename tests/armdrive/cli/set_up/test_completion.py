"""`armdrive completion`: scripts for three shells, and what bash completes with its own."""

import os
import shutil
import subprocess

import pytest

from armdrive.cli.commands import COMMANDS
from armdrive.cli.set_up.arguments import SHELLS
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


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")
def test_bash_completes_commands_options_names_and_files(call, tmp_path):
    script = tmp_path / "completion.bash"
    script.write_text(call("completion", "bash", code=0).out, encoding="utf-8")
    (tmp_path / "stack.arm").write_text("", encoding="utf-8")
    expected = {
        "armdrive mo": "move",
        "armdrive move --sp": "--speed",
        "armdrive status --sim ": " ".join(DIALECTS),
        "armdrive points g": "go",
        "armdrive errors E50": "E501 E502 E503 E504 E505 E506",
        "armdrive run st": "stack.arm",
        "armdrive help verif": "verify",
    }
    ended = subprocess.run(
        ["bash", "-c", TRY, "bash", *expected],
        capture_output=True, text=True, check=True, cwd=tmp_path,
        env={**os.environ, "SCRIPT": str(script)},
    )  # fmt: skip
    assert dict(zip(expected, ended.stdout.splitlines(), strict=True)) == expected
