"""The dialects of arm controllers as sans-IO codecs: messages to bytes and back, both ends."""
