"""The flight recorder: what an arm does, recorded, described in words, and replayed on a twin.

Which file decides what:

    entries    an entry, and the ring: how much of the past is kept
    recorder   which events become entries, and when a recording is written
    files      the file of a recording, and how many are kept
    log        entries in words
    replay     a recording against a simulated device: the first difference
"""
