"""The questions of `agentrob init`; what is answered by an option is not asked."""

from __future__ import annotations

import getpass
import re
import shutil
import socket
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TextIO

from rich.console import Console
from rich.prompt import Confirm, Prompt

from agentrob.config import load as configuration
from agentrob.errors import ConfigError
from agentrob.plugins import names
from agentrob.robots.diagnostics import network
from agentrob.setup.answers import Answers, RobotAnswers, Services, check_address

HANDLE = re.compile(r"[a-z][a-z0-9_-]{1,31}")
NO_ROBOT, SIMULATED, REAL = "none", "simulated", "real"


class Dialogue:
    """Asks on a console. `stream` is read instead of the terminal."""

    def __init__(self, console: Console, stream: TextIO | None = None) -> None:
        self._console, self._stream = console, stream

    def complete(self, given: Answers, *, asked: Sequence[str]) -> Answers:
        """Return the answers, with those named in `asked` from the person. Raises `EOFError` if nobody answers."""
        answers = given
        if "admin" in asked:
            answers = replace(answers, admin=self._text("Your handle on the forum, its first admin", _user(), _handle))
        if "title" in asked:
            answers = replace(answers, title=self._text("Name of the forum", answers.title))
        if "listen" in asked:
            words = "Host and port where it listens (others reach it through a proxy with TLS)"
            answers = replace(answers, listen=self._text(words, answers.listen, _listen))
        if "robot" in asked:
            answers = replace(answers, robot=self._robot())
        if "services" in asked:
            answers = replace(answers, services=self._services())
        if "walk" in asked and answers.robot and answers.services is not Services.NONE:
            answers = replace(answers, walk=self._walk(answers.robot))
        return answers

    def _robot(self) -> RobotAnswers | None:
        which = self._choice("A robot", [SIMULATED, REAL, NO_ROBOT], SIMULATED)
        if which == NO_ROBOT:
            return None
        name = self._text("Its name, which is its handle too", "rex", _handle)
        kinds = [kind for kind in names("robots") if kind != "fake"]
        if which == SIMULATED:
            return RobotAnswers(name, self._choice("Its kind", _simulated(kinds), "go2"))
        model = self._choice("Its kind", [kind for kind in kinds if not kind.endswith("-sim")], "go2")
        self._console.print(f"Interfaces of this machine: {network.others('lo')}", highlight=False)
        interface = self._text("Network interface of the robot's cable", "eth0", _interface)
        return RobotAnswers(name, model, False, interface, int(self._text("DDS domain", "0", _domain)))

    def _services(self) -> Services:
        print_line = self._console.print
        print_line("Who runs the processes: user (systemd, as you), system (systemd, as root), compose (Docker), none")
        return Services(self._choice("Services", list(Services), available()))

    def _walk(self, robot: RobotAnswers) -> bool:
        if robot.simulated:
            return self._confirm("Let it walk 0.3 m at the end", True)
        words = "Does it stand, with 2 m of free space around it and somebody at its remote, so that it may walk 0.1 m"
        return self._confirm(words, False)

    # ------------------------------------------------------------------ one question
    def _text(self, words: str, default: str, check: Callable[[str], None] | None = None) -> str:
        """Ask until the answer is valid."""
        while True:
            answer = Prompt.ask(words, console=self._console, default=default, stream=self._stream).strip()
            try:
                if check is not None:
                    check(answer)
            except ValueError as e:
                self._console.print(f"  {e}", style="yellow", highlight=False)
            else:
                return answer

    def _choice(self, words: str, choices: Sequence[str], default: str) -> str:
        found = list(map(str, choices))
        return Prompt.ask(words, console=self._console, choices=found, default=str(default), stream=self._stream)

    def _confirm(self, words: str, default: bool) -> bool:
        return Confirm.ask(words, console=self._console, default=default, stream=self._stream)


def available() -> Services:
    """Return what can run services here: systemd of this user if it answers, else nothing."""
    if shutil.which("systemctl") is None:
        return Services.NONE
    asked = ["systemctl", "--user", "show-environment"]
    answered = subprocess.run(asked, capture_output=True, timeout=10, check=False).returncode == 0
    return Services.USER if answered else Services.NONE


def _simulated(kinds: Sequence[str]) -> list[str]:
    """The kinds that can be simulated: those of the world, and those whose package brings a simulation."""
    return sorted({*({"go2", "g1"} & set(kinds)), *names("simulators")})


def _user() -> str:
    name = getpass.getuser().lower()
    return name if HANDLE.fullmatch(name) and name != "root" else "chief"


# ---------------------------------------------------------------------- checks
def _handle(answer: str) -> None:
    if not HANDLE.fullmatch(answer):
        raise ValueError(f"{answer!r} is not valid: 2 to 32 of a-z, 0-9, - and _, the first a letter")


def _listen(answer: str) -> None:
    try:
        check_address(answer)
        configuration.parse({"board": {"listen": answer}}, "listen")
    except ConfigError as e:
        raise ValueError(str(e)) from None


def _interface(answer: str) -> None:
    there = [name for _, name in socket.if_nameindex()]
    if answer not in there:
        raise ValueError(f"{answer!r} is not on this machine; valid: {', '.join(there)}")


def _domain(answer: str) -> None:
    if not answer.isdecimal() or int(answer) > 230:
        raise ValueError(f"{answer!r} is not a DDS domain; valid: 0 to 230")
