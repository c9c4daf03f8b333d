"""Setting an arm up: ports that are found, files that are written, motors that are tried."""
