"""What characters a terminal can show."""

from __future__ import annotations

from collections.abc import Mapping

_PLAIN_TERMINALS = ("linux", "dumb")
"""The Linux console has no braille in its font; a dumb terminal has nothing."""

_LOCALE_VARIABLES = ("LC_ALL", "LC_CTYPE", "LANG")
"""In the order of POSIX: the first one that is set decides."""


def can_braille(encoding: str | None, environ: Mapping[str, str]) -> bool:
    """Return whether braille characters would be legible there.

    Needs an output encoding of UTF-8, a locale that does not contradict it, and a terminal whose
    font has the characters. `encoding` is the output stream's, for example `sys.stdout.encoding`.
    """
    if not _is_utf8(encoding or "") or environ.get("TERM", "") in _PLAIN_TERMINALS:
        return False
    locale = next((environ[name] for name in _LOCALE_VARIABLES if environ.get(name)), None)
    return locale is None or _is_utf8(locale)


def _is_utf8(name: str) -> bool:
    codeset = name.rpartition(".")[2].partition("@")[0]
    return codeset.lower().replace("-", "").replace("_", "") == "utf8"
