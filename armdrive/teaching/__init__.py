"""Teaching: what an arm was shown, edited, and what its own pendant has taught it."""
