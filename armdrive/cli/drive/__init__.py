"""Commands that drive an arm, and those that ask the program that drives it."""
