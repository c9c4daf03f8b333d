"""Setting up an arm: its file is made, and its motors are checked."""
