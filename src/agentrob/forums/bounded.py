"""A dictionary with a maximum size."""

from __future__ import annotations

from collections import OrderedDict, UserDict
from typing import TypeVar

#: Default number of posts, topics, keys or accounts that an adapter remembers.
MOST_KNOWN = 1_000
K = TypeVar("K")
V = TypeVar("V")


class BoundedDict(UserDict[K, V]):
    """Keeps at most `most` entries: another one drops the entry that was set longest ago. Reading does not renew."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self.data: OrderedDict[K, V] = OrderedDict()
        self._most = most

    def __setitem__(self, key: K, value: V) -> None:
        self.data[key] = value
        self.data.move_to_end(key)
        if len(self.data) > self._most:
            self.dropped(*self.data.popitem(last=False))

    def dropped(self, key: K, value: V) -> None:
        """Called for each dropped entry, for subclasses."""
