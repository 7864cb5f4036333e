"""Findings of `agentrob doctor`, and what to do about each. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from agentrob.config.robots import RobotConfig
from agentrob.model import RobotState
from agentrob.robots.safety.guard import BLIND_MPS, STATE_AGE_S
from agentrob.robots.safety.ranges import NAMES


class Status(StrEnum):
    """`bad` keeps the robot from moving or makes it unsafe, `warning` is worth knowing, `unknown` could not be seen."""

    OK = "ok"
    WARNING = "warning"
    BAD = "bad"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Finding:
    """`check` is a stable word (interface, domain, …); `advice` is what to do, empty when there is nothing to do.

    `command` mends it. Where only hands can (a cable, a battery), the doctor names the command that checks it again.
    """

    check: str
    status: Status
    found: str
    advice: str = ""
    command: str = ""


#: What to do about the mode that a robot is in.
_MODES = {
    "damping": (
        Status.BAD,
        "Make it stand with its remote; the driver never stands up a robot that somebody else put down.",
    ),
    "fallen": (Status.BAD, 'Set it on its feet, or make room around it and ask it to "stand up" through its agent.'),
    "lying": (Status.WARNING, "It must be made to stand before it can walk: by its remote, or `stand up`."),
    "sitting": (Status.WARNING, "It must be made to stand before it can walk: by its remote, or `stand up`."),
    "locked": (Status.OK, "Its joints are locked; the first step makes it ready to walk, which may take 10 s."),
    "gesture": (Status.WARNING, "It is in the middle of something; wait for its end."),
    "walking": (Status.BAD, "Another program or remote moves it now: find out which before you start an agent."),
    "unknown": (
        Status.WARNING,
        "The code of its mode is not one we know (newer firmware?). Move it only 10 cm at first, with a hand on the "
        "remote, and report the code.",
    ),
}


def of_state(state: RobotState) -> list[Finding]:
    """Mode, attitude and position."""
    status, advice = _MODES.get(state.mode, (Status.OK, ""))
    code = "" if state.error_code is None else f" (code {state.error_code})"
    findings = [Finding("mode", status, f"{state.mode}{code}", advice)]
    if state.upright is None:
        what = "It gives no attitude, so a fall would not be seen, and nothing moves it."
        findings.append(Finding("attitude", Status.BAD, what, "Check that its IMU works, by the robot's own app."))
    else:
        status = Status.OK if state.upright else Status.BAD
        findings.append(Finding("attitude", status, "upright" if state.upright else "it lies"))
    if (pose := state.pose) is None:
        what = "Its odometry is missing or not a number, so nothing moves it."
        findings.append(Finding("odometry", Status.BAD, what, "Restart the robot where it stands."))
    else:
        at = f"x {pose.x_m:.2f} m, y {pose.y_m:.2f} m, {math.degrees(pose.yaw_rad):.0f}°"
        findings.append(Finding("odometry", Status.OK, at))
    return findings


def of_battery(percent: float | None, settings: RobotConfig) -> Finding:
    least = settings.least_battery_percent
    if percent is None or not percent >= 0:
        advice = "Check the charge on the robot before each use: a low battery cannot prevent motion."
        return Finding("battery", Status.UNKNOWN, "it does not report its charge", advice)
    if percent < least:
        advice = "Charge it. The level is least_battery_percent in its configuration."
        return Finding("battery", Status.BAD, f"{percent:.0f} %, below the {least:g} % that motion needs", advice)
    if percent < least + 10:
        return Finding("battery", Status.WARNING, f"{percent:.0f} %; below {least:g} % no motion begins", "Charge it.")
    return Finding("battery", Status.OK, f"{percent:.0f} %")


def of_ranges(known: tuple[float | None, ...], settings: RobotConfig) -> Finding:
    """`known`: what the guard would believe of the four readings."""
    dead = [name for name, value in zip(NAMES, known, strict=True) if value is None]
    if not dead:
        values = ", ".join(f"{value:.2f} m {name}" for name, value in zip(NAMES, known, strict=True))
        return Finding("ranges", Status.OK, values)
    what = f"no living range readings {', '.join(dead)}"
    if settings.allow_unknown_ranges:
        return Finding(
            "ranges", Status.WARNING, f"{what}; its owner allows at most {BLIND_MPS} m/s blind", "Keep the way free."
        )
    advice = f"It will not walk that way. The owner may allow {BLIND_MPS} m/s (allow_unknown_ranges = true)."
    return Finding("ranges", Status.BAD, what, advice)


def of_rate(hertz: float, longest_gap_s: float) -> Finding:
    """`hertz` and the longest gap of the state topic while it was listened to."""
    found = f"{hertz:.0f} states a second, longest gap {1000 * longest_gap_s:.0f} ms"
    if longest_gap_s >= STATE_AGE_S or hertz < 5:
        advice = (
            f"A state older than {STATE_AGE_S} s ends every step. Use a cable instead of Wi-Fi; look for a busy host."
        )
        return Finding("state", Status.BAD, found, advice)
    if hertz < 20 or longest_gap_s > 0.2:
        return Finding(
            "state", Status.WARNING, found, "The guard looks 20 times a second: expect steps that end early."
        )
    return Finding("state", Status.OK, found)


def of_settings(settings: RobotConfig) -> list[Finding]:
    """Check settings that an owner should decide before a real robot moves for the first time."""
    if settings.simulated:
        return []
    wide = settings.fence
    size_m = max(wide.x_max_m - wide.x_min_m, wide.y_max_m - wide.y_min_m)
    findings = []
    if settings.limits.speed_mps > 0.3 or size_m > 4:
        found = f"{settings.limits.speed_mps:g} m/s inside a fence of {size_m:g} m"
        advice = "For the first days: speed_mps = 0.2, and a fence no larger than the place that you can see is free."
        findings.append(Finding("limits", Status.WARNING, found, advice))
    if not settings.owner:
        advice = "Set owner to the forum handle of the person responsible for it."
        findings.append(Finding("owner", Status.WARNING, "it has no owner in the configuration", advice))
    return findings
