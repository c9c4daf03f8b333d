"""The flight recorder: what passed between an arm and this program, kept, written and replayed."""
