"""Semantic search: posts whose meaning is similar to the query's, most similar first, across languages.

Every embedding is compared. The database then selects, among the most similar posts, those that the viewer may see
and whose text has not changed since. Rights, hidden posts and edits count exactly as in full-text search.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import BindParameter, String, bindparam, text

from agentrob.board.db.cursors import from_cursor, to_cursor
from agentrob.board.db.fulltext import TAGGED
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import StoredPost
from agentrob.board.search.embeddings import EmbeddingIndex
from agentrob.board.search.search import boards_seen, given_up, in_order, terms
from agentrob.errors import BoardError
from agentrob.model import Page
from agentrob.semantic.encoder import MIN_SIMILARITY, EncoderError

#: The largest number of results; later ones have little to do with the query.
MOST = 100
#: The number of posts in one query of the database.
_ASKED = 400
_BOARDS = bindparam("boards", expanding=True, type_=String)
_VISIBLE = (
    "SELECT p.id, p.version FROM posts p JOIN topics t ON t.id = p.topic_id "
    "WHERE p.id IN :ids AND NOT p.removed AND p.raw <> '' AND t.board_id IN :boards "
)


def find(
    reader: Reader,
    meanings: EmbeddingIndex,
    query: str,
    cursor: str | None = None,
    limit: int = 20,
    board_id: str | None = None,
    tag: str | None = None,
) -> Page[StoredPost]:
    """Posts with a similar meaning, most similar first, of one board or of all visible ones, of topics with a tag if
    given. Raises `BoardError` 422, 503."""
    begin = from_cursor(cursor) if cursor else 0
    end = min(begin + limit, MOST)
    if not terms(query) or begin >= end:
        return Page(())
    try:
        (vector,) = meanings.encoder.encode([query])
    except EncoderError as e:
        raise BoardError(503, "model_out", str(e), "try again in a moment, or search for words", 5.0) from e
    ids, versions, alike = meanings.compared(vector)
    found: list[int] = []
    with given_up(reader):
        for some in _most_alike_first(alike):
            found += _visible(reader, ids[some].tolist(), versions[some].tolist(), boards_seen(reader, board_id), tag)
            if len(found) > end:
                break
    more = len(found) > end and end < MOST
    return Page(in_order(reader, found[begin:end]), to_cursor(end) if more else None)


def _most_alike_first(alike: NDArray[np.float32]) -> Iterator[NDArray[np.int64]]:
    """The positions of sufficiently similar posts, in batches, most similar first, then newest first."""
    places = np.flatnonzero(alike >= MIN_SIMILARITY)
    if len(places) > _ASKED:  # nearly always the first batch is enough
        nearest = np.argpartition(-alike[places], _ASKED)
        first = places[nearest[:_ASKED]]
        yield first[np.lexsort((-first, -alike[first]))]
        places = places[nearest[_ASKED:]]
    places = places[np.lexsort((-places, -alike[places]))]
    for n in range(0, len(places), _ASKED):
        yield places[n : n + _ASKED]


def _visible(
    reader: Reader, ids: Sequence[int], versions: Sequence[int], boards: Sequence[str], tag: str | None
) -> list[int]:
    """Which of these posts are visible and still have that version, in their order."""
    ids_in: BindParameter[int] = bindparam("ids", expanding=True)
    statement = text(_VISIBLE + ("" if tag is None else TAGGED)).bindparams(ids_in, _BOARDS)
    values = {"ids": list(ids), "boards": list(boards)} | ({} if tag is None else {"tag": tag})
    now = {row.id: row.version for row in reader.rows(statement, **values)}
    return [i for i, version in zip(ids, versions, strict=True) if now.get(i) == version]
