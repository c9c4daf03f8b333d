"""One language for scenarios: what happens to an arm, what its program does, and what must hold.

`happenings` is the table of what can happen to the wire, the board, a drive, the program, the disk,
or by hand. `stage` is the simulated arm with all of these; `program` is the time of its programs,
`disk` keeps their records. `actions` has what programs do, and `laws` what must hold meanwhile and
afterwards. The conformance suite is a table of chosen scenarios, the campaign draws them at random,
and `tests/bounds` measures how far an arm goes on.
"""
