"""Show the progress of the demo on the terminal, and open the browser."""

from __future__ import annotations

import os
import sys
import webbrowser
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

#: The camera of a world without an OpenGL library.
SOFTWARE_CAMERA = "ray"


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """Show what is being started: as a status line on a terminal, else as one line of text.

    Yields the function that says what is started now.
    """
    from rich.console import Console

    console = Console(stderr=True, highlight=False)
    if not console.is_terminal:
        print("AgentRob demo: starting the forum, the room and the robots …", file=sys.stderr)
        yield lambda _: None
        return
    with console.status("AgentRob demo: starting …") as status:
        yield lambda what: status.update(f"AgentRob demo: {what} …")


def welcome(link: str, sentences: Sequence[str], data: str, notes: Sequence[str] = ()) -> str:
    """Return the text of a demo that runs: its address, what to post, where the data is, and how to end it."""
    first, *more = sentences
    return (
        f"\n  Open   {link}\n"
        f"         (signs you in once; `agentrob demo link` prints another)\n"
        f"  Post   {first}\n"
        + "".join(f"    or   {sentence}\n" for sentence in more)
        + "".join(f"  Note   {note}\n" for note in notes)
        + f"  Data   {data} (kept)\n"
        f"  End    Ctrl-C\n"
    )


def has_browser(environment: Mapping[str, str], *, terminal: bool) -> bool:
    """Return whether a person at this terminal sees a browser that is opened here: not in CI, not over SSH."""
    display = any(environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
    elsewhere = any(environment.get(name) for name in ("CI", "SSH_CONNECTION", "SSH_TTY"))
    return terminal and display and not elsewhere


def open_browser(link: Callable[[], str]) -> bool:
    """Open a sign-in link in the browser, if there is one; return whether it was opened."""
    if not has_browser(os.environ, terminal=sys.stdout.isatty()):
        return False
    with suppress(webbrowser.Error):
        return webbrowser.open(link())
    return False
