"""Commands that look at an arm and at recordings of it."""
