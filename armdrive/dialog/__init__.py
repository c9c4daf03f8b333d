"""Dialogs with the user: the operator who watches an arm, and the questions of a set-up.

What is decided where:

    operator      what `home` and `verify` ask of a person at the arm
    conversation  questions, what reads an answer, and findings
"""
