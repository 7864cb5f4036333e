"""The fencing token by which a driver tells a robot's newest holder from an earlier one."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FencingToken:
    """A number that grows each time a worker takes a robot from a journal's database. A driver that has seen it refuses
    smaller ones, so that a worker that lost the robot cannot move it any more.

    `store` identifies the database: numbers of different databases cannot be compared.
    """

    store: str
    number: int
