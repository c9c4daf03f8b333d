"""The language of programs: its words, grammar and values, and the checks.

Which file decides what:

    words      every word of programs: one table for checks, help and docs
    grammar    lines by `program.lark`, nested to a tree; the sentences about mistakes
    syntax     the tree
    values     numbers, truth, texts, places
    checking   the whole program: names, labels, loops, and the values of each line
"""

# How the name of a program's file ends.
ENDING = ".arm"
