"""Sans-IO codecs for the arm controllers' dialects: messages to bytes and back, for both ends."""
