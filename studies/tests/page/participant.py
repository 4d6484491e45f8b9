"""People who take part in a study: who has a keyboard and a screen reader."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

PATIENCE_S = 40.0
TEXTS = ("What to do", "A break", "Once more")
INTERESTING = {"button", "slider", "heading", "textbox", "checkbox", "radio", "spinbutton",
               "progressbar"}  # fmt: skip


class Reader:
    """Knows of the page what assistive technology is told, and has a keyboard alone."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self._client = page.context.new_cdp_session(page)

    def tree(self) -> list[dict[str, Any]]:
        """What has a role: role, name, value, focused, disabled."""
        nodes = self._client.send("Accessibility.getFullAXTree")["nodes"]
        found = []
        for node in nodes:
            role = node.get("role", {}).get("value")
            if node.get("ignored") or role not in INTERESTING:
                continue
            told = {one["name"]: one["value"].get("value") for one in node.get("properties", [])}
            found.append({
                "role": role,
                "name": node.get("name", {}).get("value", ""),
                "value": node.get("value", {}).get("value"),
                "focused": bool(told.get("focused")),
                "disabled": bool(told.get("disabled")),
            })  # fmt: skip
        return found

    def shown(self) -> tuple[str, str, bool]:
        """What tells one screen from the next: heading, progress, feedback."""
        nodes = self.tree()
        done = next((str(one["value"]) for one in nodes if one["role"] == "progressbar"), "")
        return self.heading(), done, self.enabled("Next")

    def heading(self) -> str:
        return next((one["name"] for one in self.tree() if one["role"] == "heading"), "")

    def focused(self) -> dict[str, Any]:
        return next((one for one in self.tree() if one["focused"]), {"role": "", "name": ""})

    def until(self, condition: Callable[[], Any], what: str) -> Any:
        end = time.monotonic() + PATIENCE_S
        while not (found := condition()):
            told = self.page.text_content("#fault") or self.page.text_content("#said")
            assert time.monotonic() < end, f"waited in vain for {what}; the page says {told!r}"
            self.page.wait_for_timeout(30)
        return found

    def press(self, key: str, times: int = 1) -> None:
        for _ in range(times):
            self.page.keyboard.press(key)

    def go_to(self, role: str, name: str) -> None:
        """Tab until it has the focus."""
        for _ in range(60):
            now = self.focused()
            if now["role"] == role and name in now["name"]:
                return
            self.press("Tab")
        raise AssertionError(f"no {role} {name!r} is reached by Tab in {self.tree()}")

    def push(self, name: str) -> None:
        self.go_to("button", name)
        self.press("Enter")

    def enabled(self, name: str) -> bool:
        return any(
            one["role"] == "button" and name in one["name"] and not one["disabled"]
            for one in self.tree()
        )


def take_part(reader: Reader, answer: Callable[[Reader], None], question: str) -> None:
    """Go through a session, from whatever is shown to its end; `answer` answers a trial."""
    while reader.until(reader.heading, "a heading") != "Thank you":
        step(reader, answer, question)


def step(reader: Reader, answer: Callable[[Reader], None], question: str) -> None:
    """One screen, until another is there."""
    before = reader.shown()
    heading = before[0]
    if heading == question and not reader.enabled("Next"):
        answer(reader)
    elif heading == question:  # how the answer was
        reader.press("Enter")
    elif heading == "Consent":
        reader.go_to("checkbox", "agree")
        reader.press("Space")
        reader.push("Take part")
    elif heading in TEXTS:
        reader.push("Continue" if heading == "A break" else "Start")
    elif heading == "How was it?":
        for scale in [one for one in reader.tree() if one["role"] == "slider"]:
            reader.go_to("slider", scale["name"])
            reader.press("ArrowRight", 2)
        reader.push("Next")
    elif heading == "About you":
        reader.push("Next")  # something is still missing
        reader.go_to("spinbutton", "Age")
        reader.page.keyboard.type("33")
        reader.go_to("checkbox", "guitar")
        reader.press("Space")
        reader.push("Next")
    elif heading == "Comments":
        reader.go_to("textbox", "")
        reader.page.keyboard.type('well, "fine"')
        reader.push("Next")
    elif heading == "Welcome back":
        reader.push("Continue")
    elif heading == "Thank you":
        return
    elif heading != "Almost done":
        reader.push("Begin")
    reader.until(lambda: reader.shown() != before, f"what comes after {before}")
