"""What robots say in English of routines, of the way home, and of what they see in their camera."""

from __future__ import annotations

PHRASES = {
    "ask.routine.times": "{words}: that is too much for one command; at most {times} times here.",
    "ask.routine.square": "{words}: that size does not fit my limits; sides of at most {metres} m here.",
    "ask.routine.circle": "{words}: that size does not fit my limits; at most {metres} m across here.",
    "ask.routine.circle_radius": "{words}: that size does not fit my limits; a radius of at most {metres} m here.",
    "ask.routine.patrol": "{words}: that size does not fit my limits; at most {metres} m out and back here.",
    "ask.routine.not_here": (
        "{words}: that does not fit my abilities and limits here ({steps} steps, {metres} m and {seconds} s a command)."
    ),
    "note.routine.dance": "{words} is taken as turns to both sides and gestures.",
    "note.routine.square": "{words} is taken as {sides} sides of {side} m with left turns of 90°.",
    "note.routine.circle": "{words} is taken as {sides} sides of {side} m, since I walk straight and turn.",
    "note.routine.patrol": "{words} is taken as {side} m out and back; times: {times}.",
}
