"""The language of programs: its words, grammar and values, the checks, and the compiled form.

Which file decides what:

    words      every word of programs: one table for checks, help and docs
    grammar    `program.lark` made into a tree, and the sentences about mistakes
    syntax     the tree; `writing` turns it back into text
    values     numbers, truth, texts, places
    checking   values of each line: how many, of which kind, within which bounds
    compiling  the whole program: names, blocks, and the list of instructions
"""

# How the name of a program's file ends.
ENDING = ".arm"
