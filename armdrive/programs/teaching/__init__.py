"""Taught sequences: their steps, recording, stepping through them, shaping points, exporting.

Which file decides what:

    steps      how a step is typed, and how steps are edited
    sequence   when a place at rest becomes a step, and stepping there and back
    shape      points mirrored, shifted and turned
    export     a sequence as a program, or as rows for an arm's own memory
"""
