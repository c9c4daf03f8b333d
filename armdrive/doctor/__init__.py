"""What is at the other end of a port, found out without moving anything.

`probes` is the table of what is said, `signs` knows what is heard, `probing` goes through both
without a wire or a clock, and `carrying` gives it those. `before` looks at a port that is still
closed, `settings` at a device that is known, `mistaken` at a connection that failed.
"""
