"""The drivers of controllers: one subpackage a dialect, and what they share."""
