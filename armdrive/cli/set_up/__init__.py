"""Commands that set an arm up: arm files, ports, simulated devices."""
