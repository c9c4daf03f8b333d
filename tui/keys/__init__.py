"""What the keys do: their table, the keyboard at hand, and files that change it."""
