"""What a device's objects hold, read and written by the rules of its dictionary."""

from __future__ import annotations

from firmware_protocol.canopen.cob import checked_node
from firmware_protocol.canopen.datatypes import Value
from firmware_protocol.canopen.objects import Dictionary, ObjectEntry
from firmware_protocol.canopen.sdo_codes import AbortCode
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.canopen.sdo_server import Ask, ReadAsked, SdoServer
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame


class ObjectStore:
    """The values of a device. What has no value yet is told to be so, not made up."""

    def __init__(self, dictionary: Dictionary, node: int) -> None:
        self._dictionary = dictionary
        self._node = checked_node(node)
        self._values: dict[Place, bytes] = {}
        self.restore()

    def restore(self) -> None:
        """Begin anew with what the dictionary says of each object."""
        initial = ((entry, entry.initial(self._node)) for entry in self._dictionary)
        self._values = {
            entry.place: entry.type.pack(value) for entry, value in initial if value is not None
        }

    def value(self, place: Place) -> Value | None:
        """Return what an object holds, None where nothing yet. Raises `BadField` if unknown."""
        entry = self._entry(place)
        data = self._values.get(place)
        return None if data is None else entry.type.unpack(data)

    def set(self, place: Place, value: Value) -> None:
        """Set an object from inside the device, whatever its access. Raises `BadField`."""
        self._values[place] = self._entry(place).type.pack(value)

    def read(self, place: Place) -> bytes | AbortCode:
        """Return what a client is told, or why it is not."""
        entry = self._dictionary.find(place)
        if entry is None:
            return self._missing(place)
        if not entry.access.readable:
            return AbortCode.WRITE_ONLY
        return self._values.get(place, AbortCode.NO_DATA)

    def write(self, place: Place, data: bytes, *, exact: bool = True) -> AbortCode | None:
        """Take what a client writes; returns why not, or None. Unasked-for bytes are cut off."""
        entry = self._dictionary.find(place)
        if entry is None:
            return self._missing(place)
        if not entry.access.writable:
            return AbortCode.READ_ONLY
        size = entry.type.size
        if size is not None and len(data) < size:
            return AbortCode.TOO_SHORT
        if size is not None and len(data) > size and exact:
            return AbortCode.TOO_LONG
        try:
            self._values[place] = entry.type.pack(entry.type.unpack(data, exact=exact))
        except (BadField, RemoteProtocolError):  # text that is none
            return AbortCode.VALUE
        return None

    def answer(self, server: SdoServer, ask: Ask) -> Frame | None:
        """Answer what a server was asked; returns the frame, None where nobody awaits it."""
        if isinstance(ask, ReadAsked):
            told = self.read(ask.place)
            if isinstance(told, AbortCode):
                return server.refuse(ask, told)
            return server.supply(ask, told)
        refusal = self.write(ask.place, ask.data, exact=ask.exact)
        return server.accept(ask) if refusal is None else server.refuse(ask, refusal)

    def _entry(self, place: Place) -> ObjectEntry:
        entry = self._dictionary.find(place)
        if entry is None:
            raise BadField("place", str(place), "an object of this dictionary")
        return entry

    def _missing(self, place: Place) -> AbortCode:
        known = place.index in self._dictionary.indices
        return AbortCode.NO_SUB_INDEX if known else AbortCode.NO_OBJECT
