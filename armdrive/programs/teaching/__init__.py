"""Teaching: places of the arm become points, and the lines of a program that goes to them.

Which file decides what:

    recording    how a motion, the fingers and a delay are written as lines of a program; when a
                 place at rest becomes a line
    rows         a program as rows for an arm's own memory, and back
"""
