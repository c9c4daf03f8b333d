"""Who can reach an address that a simulated arm is offered at."""

from __future__ import annotations

import ipaddress

from armdrive.transports.serve_network import LOOPBACK, split_address


def beyond_this_computer(address: str) -> str:
    """Return the warning of an address that others can reach; nothing where only we can.

    Raises `PortUnavailable` for what is no address.
    """
    host, _ = split_address(address)
    if host.lower() == "localhost" or _is_loopback(host):
        return ""
    return (
        f"WARNING: whoever reaches {host} over the network can move this simulated arm and hear "
        f"what is said to it; {LOOPBACK} keeps it to this computer"
    )


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:  # a name: nobody knows where it leads
        return False
