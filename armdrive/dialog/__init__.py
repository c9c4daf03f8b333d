"""Dialogs with the user: the operator who watches an arm, and the questions of a set-up."""
