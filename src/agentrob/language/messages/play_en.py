"""The sentences about routines, the way home and camera pictures in English."""

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
    "note.routine.patrol": "{words} is taken as {side} m out and back.",
    "note.routine.patrol.times": "{words} is taken as {side} m out and back, {times} times.",
    "home.reached": "I am {metres:.2f} m from home by my odometry, turned {degrees:.0f}° from its direction.",
    "home.missed": "I am still {metres} m from home by my odometry.",
    "eyes.where.ahead": "{thing} straight ahead",
    "eyes.where.left": "{thing} about {degrees}° to the left",
    "eyes.where.right": "{thing} about {degrees}° to the right",
    "eyes.seen": "I see {thing}.",
    "eyes.faced.left": "I turned to {thing}: measured {degrees:.1f}° to the left of straight ahead.",
    "eyes.faced.right": "I turned to {thing}: measured {degrees:.1f}° to the right of straight ahead.",
    "eyes.not_seen": "I do not see {thing} in my camera's picture.",
    "eyes.colours": "I see {things}.",
    "eyes.no_colours": "I see no plain colours ahead, such as red, yellow, green or blue.",
    "eyes.not_ahead": (
        "I do not see {thing} ahead, and to look around through {degrees}° is beyond my limits for one command. "
        "Shall I turn to a side first?"
    ),
    "eyes.not_around": "I looked around and do not see {thing}.",
    "eyes.not_faced": "I turned several times and still see {thing}.",
    "eyes.lost": "I turned towards {thing} and do not see it any more.",
    "eyes.no_picture": "My camera gave no picture.",
    "eyes.failed": "My detector could not read the picture ({error}).",
    "agent.goal.found": "**Done.** {found}",
    "help.play": "Whole routines, which I do as ordinary steps:",
    "help.dance": "dance",
    "help.square": "walk a square",
    "help.circle": "walk in a circle",
    "help.patrol": "patrol",
    "help.home": "come home",
    "help.eyes": "By my camera I know plain colours and simple shapes:",
    "help.face": "turn to the red ball",
    "help.colours": "what colours do you see?",
}
