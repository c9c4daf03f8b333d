"""Rows of the table of keys for the theory of an arm, and for a model that no arm stands behind."""

from __future__ import annotations

from tui.key_row import DeskKey

THEORY_KEYS = (
    DeskKey("theory-next", ("pagedown", "N"), "turn(1)", "next page",
            "Go on to the next matrices, singularities, solutions.", "theory"),
    DeskKey("theory-previous", ("pageup", "B"), "turn(-1)", "back",
            "Go back to the page before.", "theory"),
    DeskKey("theory-symbols", ("S",), "symbols", "symbols",
            "Switch between numbers and the notes' own C1, S12.", "theory"),
)  # fmt: skip
"""They only turn pages: nothing on the theory screen moves an arm."""

MODEL_KEYS = (
    DeskKey("model-solution", ("G",), "solution", "solution",
            "Put the model into its next solution for the same place of the hand.", "model"),
    DeskKey("model-zero", ("Z",), "zero", "zero",
            "Put every joint of the model at zero, or at the limit nearest to it.", "model"),
)  # fmt: skip
"""Only where no arm is connected: a model may leap."""
