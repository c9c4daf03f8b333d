"""Commands that compute and explain without an arm."""
