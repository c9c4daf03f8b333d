"""Lets the tests of every subject import the cases that stand beside this file."""
