"""Lets the tests of every protocol import the cases that stand beside this file."""
