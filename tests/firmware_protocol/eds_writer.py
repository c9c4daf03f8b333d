"""A dictionary written as the text of an EDS file (CiA 306), to be read again."""

from collections.abc import Iterator, Mapping

from firmware_protocol.canopen.objects import Dictionary, ObjectEntry

VARIABLE, RECORD = 0x7, 0x9
"""Object codes of CiA 301."""

_MANDATORY = frozenset((0x1000, 0x1001, 0x1018))
_MANUFACTURERS = range(0x2000, 0x6000)


def write_eds(dictionary: Dictionary, *, product: str = "drive") -> str:
    """Return the text; what `read_eds` reads of it is the same dictionary."""
    indices = sorted(dictionary.indices)
    optional = [i for i in indices if i not in _MANDATORY and i not in _MANUFACTURERS]
    parts = [
        _section("FileInfo", {"EDSVersion": "4.0", "FileVersion": "1", "FileRevision": "1"}),
        _section("DeviceInfo", {"ProductName": product}),
        _listed("MandatoryObjects", [i for i in indices if i in _MANDATORY]),
        _listed("OptionalObjects", optional),
        _listed("ManufacturerObjects", [i for i in indices if i in _MANUFACTURERS]),
        *(part for index in indices for part in _object(dictionary, index)),
    ]
    return "\n".join(parts)


def _section(name: str, values: Mapping[str, str]) -> str:
    return "".join((f"[{name}]\n", *(f"{key}={value}\n" for key, value in values.items())))


def _listed(name: str, indices: list[int]) -> str:
    rows = {str(number): f"0x{index:04X}" for number, index in enumerate(indices, 1)}
    return _section(name, {"SupportedObjects": str(len(indices)), **rows})


def _object(dictionary: Dictionary, index: int) -> Iterator[str]:
    entries = [entry for entry in dictionary if entry.place.index == index]
    record = any(entry.place.sub for entry in entries)
    if record:
        values = {"ParameterName": entries[0].name, "ObjectType": f"0x{RECORD:X}"}
        yield _section(f"{index:04X}", {**values, "SubNumber": str(len(entries))})
    for entry in entries:
        sub = f"sub{entry.place.sub:X}" if record else ""
        yield _section(f"{index:04X}{sub}", _values(entry))


def _values(entry: ObjectEntry) -> dict[str, str]:
    values = {
        "ParameterName": entry.name,
        "ObjectType": f"0x{VARIABLE:X}",
        "DataType": f"0x{entry.type:04X}",
        "AccessType": entry.access.value,
        "PDOMapping": str(int(entry.mappable)),
    }
    if (default := _default(entry)) is not None:
        values["DefaultValue"] = default
    if entry.unit:
        values["Unit"] = entry.unit
    return values


def _default(entry: ObjectEntry) -> str | None:
    value = entry.default
    if value is None:
        return None
    return f"$NODEID+0x{value:X}" if entry.adds_node else str(value)
