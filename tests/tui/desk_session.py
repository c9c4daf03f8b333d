"""A desk on a headless terminal, driven key by key."""

import math

from desk_fake import Clock, FakeArm
from desk_planner import at_rest, laid_out
from waiting import until_seen

from armdrive.motion.dead_man import GATE_S, REPEAT_WITHIN_S
from tui.desk import Desk
from tui.keys.presses import QUIET_S
from tui.safety import SafetyPanel
from tui.widgets import PlainText

FILLS = {"$primary", "$warning", "$error", "$success"}
"""Colours of the theme that text has a ground of its own with."""

AGAIN_S = REPEAT_WITHIN_S + 0.05
"""After this long a key that comes again was let go and pressed again."""

NAMES = {"/": "slash", "-": "minus", ".": "full_stop", ",": "comma", ":": "colon"}
"""The framework's names of characters that are typed."""


class AppSession:
    """An app on a headless terminal, driven key by key."""

    def __init__(self, app, *, size=(80, 24)):
        self.app = app
        self._running = app.run_test(size=size)

    async def __aenter__(self):
        self.pilot = await self._running.__aenter__()
        await self.pilot.pause()  # paints, and the app looks at its arm after that
        await self.pilot.pause()
        return self

    async def __aexit__(self, *error):
        await self._running.__aexit__(*error)

    async def press(self, *keys):
        for key in keys:
            await self.pilot.press(key)
        await self.pilot.pause()

    def text(self, name):
        return self.app.screen_stack[0].query_one(f"#{name}", PlainText).shown


class Session(AppSession):
    """A desk on a headless terminal, a fake arm and a clock that the test sets."""

    first = ""  # the screen where a test begins, if it is not the one for jogging

    def __init__(self, arm=None, *, size=(80, 24), braille=True, **more):
        self.arm = arm or FakeArm()
        self.clock = Clock()
        self.desk = Desk(
            self.arm,
            braille=braille,
            clock=self.clock,
            **{"first": self.first, **more},
        )
        self.desk.input.key_age_s = lambda: 0.0  # keys come when they are pressed
        self.desk.input.fresh.suspended_s = self.desk.input.fresh.starved_s = (
            math.inf
        )  # however busy it is
        super().__init__(self.desk, size=size)

    async def __aenter__(self):
        await super().__aenter__()
        self.desk.polling.pause()  # from here on the desk looks when the test lets it
        await self.settle()
        return self

    async def __aexit__(self, *error):
        if self.desk.is_running and self.desk.screen_stack:
            for text in self.desk.screen.query(PlainText):
                for _, style in text._spans:  # fails for a style that could not be painted
                    self.desk.stylesheet.parse_style(style)
                    fills = {"reverse", "on"} & set(style.split())
                    assert fills or not FILLS & set(style.split()), "not to be read on light ground"
        await super().__aexit__(*error)

    async def press(self, *keys, after_s=0.0):
        """Press keys, each so long after the one before on the desk's clock."""
        for key in keys:
            self.clock.now_s += after_s
            await self.pilot.press(key)

    async def tap(self, *keys, after_s=0.0):
        """Press keys, and let each time pass in which another key would take it back."""
        for key in keys:
            await self.press(key, after_s=after_s)
            self.clock.now_s += GATE_S
            if self.desk.hand is not None:
                self.tick()

    async def keys(self, line, after_s=0.0):
        """Press the keys of a line, one after the other; a word after a quote is typed.

        As a person does, each word waits for what came of the one before.
        """
        for word in line.split():
            await self.burst(word, after_s)

    async def burst(self, line, after_s=0.0):
        """Press the keys of a line, and wait only for what came of the last one."""
        for word in line.split():
            typed = [NAMES.get(each, each) for each in word[1:]]
            await self.press(*(typed if word.startswith("'") else [word]), after_s=after_s)
            if word == "y" and len(self.desk.screen_stack) > 1:
                self.clock.now_s += QUIET_S + 0.1  # a yes counts once no other key has followed it
                await self.settle()
        await self.settle()

    async def once(self, key):
        """Press a key after a pause, and wait until no other key can follow."""
        self.clock.now_s += 1.0
        await self.poll()
        await self.press(key)
        await self._let_it_count()

    async def twice(self, key, *, wait_s=0.5):
        """Press a key twice, and wait until that counts as confirmed."""
        await self.press(key)
        await self.press(key, after_s=AGAIN_S)
        await self._let_it_count(wait_s)

    async def _let_it_count(self, wait_s=0.5):
        self.clock.now_s += wait_s
        await self.settle()
        await self.settle()

    async def follow(self, rows):
        """Press the keys of each row; then each part of the screen says what the row says."""
        for line, shown in rows:
            await self.keys(line)
            self.shows(line, **shown)

    def shows(self, what, /, **parts):
        """See that parts of the screen have these words; `not_...` that they have not."""
        for name, words in parts.items():
            text = self.text(name.removeprefix("not_").replace("_", "-"))
            assert (words in text) != name.startswith("not_"), (what, name, words, text)

    @property
    def screen(self):
        return self.desk.current

    async def arm_keys(self):
        self.clock.now_s += 10.0
        await self.press("enter")
        assert self.desk.current.armed
        self.clock.now_s += 10.0

    async def hold(self, key="w"):
        """Arm the keys, and hold one until it moves the arm."""
        await self.arm_keys()
        await self.tap(key)
        await self.tap(key, after_s=0.4)
        assert self.arm.asked("hold")

    async def resize(self, width, height):
        await self.pilot.resize_terminal(width, height)

        def laid_out():
            return (len(self.painted[0]), len(self.painted)) == (width, height)

        await until_seen(laid_out, self.pilot.pause)
        await at_rest(self.pilot)

    @property
    def painted(self):
        """The rows of the terminal."""
        return [strip.text for strip in self.desk.screen._compositor.render_strips()]

    def painted_words(self, name):
        """Return the words of a part of the screen that are really painted."""
        inside = self.desk.current.query_one(f"#{name}").content_region
        rows = self.painted[inside.y : inside.bottom]
        return " ".join(" ".join(row[inside.x : inside.right] for row in rows).split())

    async def send(self, event):
        self.desk.post_message(event)
        await self.pilot.pause()

    async def settle(self):
        """Wait until the desk shows what came of its calls in threads, and begins no more."""
        while True:
            await self.desk.workers.wait_for_complete()
            await self.poll()
            if all(worker.is_finished for worker in self.desk.workers):
                break
        await laid_out(self.pilot)

    async def poll(self):
        self.desk.poll()
        await self.pilot.pause()

    def text(self, name):
        """Return what a part of the screen says: a widget by its id, or one of these names."""
        if name == "title":
            return self.desk.current.query_one(SafetyPanel).arm
        if name == "banner":
            state = self.text("state")
            return "" if state.endswith(f" {self.desk.current.says}") else state
        return self.desk.current.query_one(f"#{name}").shown

    def title(self, name):
        """Return the title of a panel, without what a small terminal shows beside it."""
        return str(self.desk.current.query_one(f"#{name}").border_title).partition("  ")[0]

    @property
    def lit_tab(self):
        """The words on the tabs that are painted in bold: those of the current screen."""
        return "".join(
            segment.text
            for segment in self.desk.screen._compositor.render_strips()[0]
            if segment.style is not None and segment.style.bold
        )

    def tick(self):
        """Let the time of what is held pass, as the desk's own alarm does."""
        self.desk.current.hand.tick()

    @property
    def everything(self):
        names = ("title", "state", "trust", "stopping", "joints", "tip", "gripper", "near",
                 "messages", "footer")  # fmt: skip
        return "\n".join(self.text(name) for name in names)
