"""What an arm does, recorded as it happens, put into words, and replayed against a twin."""
