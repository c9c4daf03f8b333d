"""A client and a server of SDO on a bus that may lose, repeat and reorder."""

from collections import deque

from chunks import events

from firmware_protocol import canopen

NODE = 5
ENDINGS = (canopen.Uploaded, canopen.Downloaded, canopen.Aborted)


class SdoBus:
    """Both ends, and an owner who keeps objects.

    Of each frame is asked how often it comes (`copies`), and whether it overtakes all that wait.
    """

    def __init__(self, objects=None, copies=lambda: 1, overtakes=lambda: False) -> None:
        self.client, self.server = canopen.SdoClient(NODE), canopen.SdoServer(NODE)
        self.objects = dict(objects or {})
        self.wire = deque()
        self.heard = []
        self._copies, self._overtakes = copies, overtakes

    def put(self, to, frame) -> None:
        if frame is None:
            return
        for _ in range(self._copies()):
            (self.wire.append if self._overtakes() else self.wire.appendleft)((to, frame))

    def say(self, frame) -> None:
        self.put(self.server, frame)

    def run(self, most=2000) -> None:
        """Carry frames until the bus is silent. Both ends' events are fetched as they come."""
        while self.wire and most:
            most -= 1
            to, frame = self.wire.pop()
            other = self.client if to is self.server else self.server
            self.put(other, to.receive_frame(frame))
            self.heard += events(self.client)
            for asked in events(self.server):
                self._answer(asked)
        assert most, "they do not end talking"

    def ended(self) -> list[object]:
        return [event for event in self.heard if isinstance(event, ENDINGS)]

    def upload(self, place):
        self.heard.clear()
        self.say(self.client.upload(place))
        self.run()
        return self.ended()

    def download(self, place, data):
        self.heard.clear()
        self.say(self.client.download(place, data))
        self.run()
        return self.ended()

    def _answer(self, asked) -> None:
        match asked:
            case canopen.ReadAsked(place) if place in self.objects:
                self.put(self.client, self.server.supply(asked, self.objects[place]))
            case canopen.WriteAsked(place, data):
                self.objects[place] = data
                self.put(self.client, self.server.accept(asked))
            case canopen.ReadAsked():
                self.put(self.client, self.server.refuse(asked, canopen.AbortCode.NO_OBJECT))
