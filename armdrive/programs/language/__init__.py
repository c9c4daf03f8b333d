"""The language of programs: its words, grammar and values, the checks, and the compiled form."""
