"""Strict reading and writing of text: TOML, JSON, and what a person types.

Which file decides what:

    reading     files from elsewhere, within limits of size and depth
    toml        schemas, for TOML and JSON: each key with its type, bounds, help, misspellings
    toml_amend  single keys changed in a file that a person keeps
    json_forms  how moves, poses, status and errors look in JSON
    numbers     numbers and speeds as people type them
"""
