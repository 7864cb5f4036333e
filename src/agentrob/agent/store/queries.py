"""The journal's queries, the same for SQLite and PostgreSQL.

They are built once: that takes longer than to execute them. `:this_robot` is whose rows, `:this_key` which of them;
the other parameters of an `update` are the columns to set.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

from sqlalchemy import (
    BigInteger,
    Connection,
    Double,
    Integer,
    Table,
    Text,
    and_,
    bindparam,
    delete,
    exists,
    func,
    not_,
    or_,
    select,
    update,
)
from sqlalchemy.dialects import postgresql, sqlite

from agentrob.agent.store.schema import (
    APPROVAL,
    ASSESSMENT,
    CLAIM,
    HOLDER,
    JOINT,
    META,
    MOTION,
    PREVIEW,
    SCHEDULE,
    now_s,
)
from agentrob.model import ScheduleEnd

ROBOT, KEY = bindparam("this_robot", type_=Text), bindparam("this_key", type_=Text)


def _ours(table: Table) -> Any:
    return table.c.robot == ROBOT


def _this(table: Table) -> Any:
    return and_(_ours(table), table.primary_key.columns[1] == KEY)


_CLAIMS = select(
    CLAIM.c.command, CLAIM.c.boot, CLAIM.c.accepted_s, now_s() - CLAIM.c.at, CLAIM.c.status_post, CLAIM.c.final,
    CLAIM.c.ended, MOTION.c.state, JOINT.c.waits_since, JOINT.c.released_at,
    APPROVAL.c.asked_at, APPROVAL.c.until_at, APPROVAL.c.said,
).select_from(
    CLAIM.outerjoin(APPROVAL, and_(APPROVAL.c.robot == CLAIM.c.robot, APPROVAL.c.post == CLAIM.c.post))
    .outerjoin(MOTION, and_(MOTION.c.robot == CLAIM.c.robot, MOTION.c.post == CLAIM.c.post))
    .outerjoin(JOINT, and_(JOINT.c.robot == CLAIM.c.robot, JOINT.c.post == CLAIM.c.post))
).where(_ours(CLAIM))  # fmt: skip
NEWEST_NUMBER = select(func.coalesce(func.max(CLAIM.c.number), 0)).where(_ours(CLAIM))

# ---------------------------------------------------------------- reading
THIS_CLAIM = _CLAIMS.where(CLAIM.c.post == KEY)
OPEN_CLAIMS = _CLAIMS.where(CLAIM.c.final.is_(None)).order_by(CLAIM.c.number)
NEWEST_CLAIM = _CLAIMS.where(CLAIM.c.status_post.is_not(None)).order_by(CLAIM.c.number.desc()).limit(1)
KNOWN = select(CLAIM.c.post).where(_this(CLAIM))
THIS_MOTION = select(MOTION.c.state, MOTION.c.result).where(_this(MOTION))
THIS_ASSESSMENT = select(ASSESSMENT.c.result).where(_this(ASSESSMENT))
DECIDED_BY = select(APPROVAL.c.post).where(_ours(APPROVAL), APPROVAL.c.said_by == KEY)
VALUE = select(META.c.value).where(_this(META))
THIS_PREVIEW = select(PREVIEW.c.data, PREVIEW.c.shown_at, PREVIEW.c.pictures).where(_this(PREVIEW))
_SCHEDULES = select(
    SCHEDULE.c.data, SCHEDULE.c.next_at, SCHEDULE.c.runs_left, SCHEDULE.c.ended, SCHEDULE.c.told
).where(_ours(SCHEDULE))  # fmt: skip
THIS_SCHEDULE = _SCHEDULES.where(SCHEDULE.c.post == KEY)
#: Those with further runs, or whose end must still be reported.
SCHEDULES = _SCHEDULES.where(SCHEDULE.c.told == 0).order_by(SCHEDULE.c.next_at, SCHEDULE.c.post)
#: Those that ended by the limit of runs or days, and may be renewed.
RENEWABLE_SCHEDULES = _SCHEDULES.where(SCHEDULE.c.ended == ScheduleEnd.LIMIT.value).order_by(SCHEDULE.c.post)
THIS_WAIT = select(JOINT.c.waits_since, JOINT.c.released_at).where(_this(JOINT))
#: The posts whose parts this robot sums up.
SUMMARIES = select(JOINT.c.summary).where(_ours(JOINT), JOINT.c.summary.is_not(None), JOINT.c.told == 0)
#: The newest plans that were done in a topic.
PLANS = (
    select(CLAIM.c.plan)
    .where(_ours(CLAIM), CLAIM.c.topic == KEY, CLAIM.c.plan.is_not(None))
    .where(func.coalesce(CLAIM.c.final, "done") == "done")
    .order_by(CLAIM.c.number.desc())
    .limit(bindparam("limit", type_=Integer))
)

# ---------------------------------------------------------------- writing
SET_CLAIM = update(CLAIM).where(_this(CLAIM))
#: The first reason counts.
END_CLAIM = SET_CLAIM.where(CLAIM.c.ended.is_(None))
SET_MOTION = update(MOTION).where(_this(MOTION))
UNDO_BEGIN = delete(MOTION).where(_this(MOTION), MOTION.c.state == "begun")
#: While nothing moves, a denial counts also after an approval; otherwise the first decision.
DENY = update(APPROVAL).where(_this(APPROVAL), not_(exists().where(_this(MOTION))))
APPROVE = DENY.where(APPROVAL.c.said.is_(None))
SET_SCHEDULE = update(SCHEDULE).where(_this(SCHEDULE))
#: The first reason counts.
END_SCHEDULE = SET_SCHEDULE.where(SCHEDULE.c.ended.is_(None))
SET_ENDED = SET_SCHEDULE.where(SCHEDULE.c.ended.is_not(None))
#: Only one that ended by the limit of runs or days.
SET_RENEWABLE = SET_SCHEDULE.where(SCHEDULE.c.ended == ScheduleEnd.LIMIT.value)
#: Only from the run that was the next one, so that no run is taken twice.
ADVANCE_SCHEDULE = END_SCHEDULE.where(SCHEDULE.c.next_at == bindparam("was_next", type_=Text))
SET_JOINT = update(JOINT).where(_this(JOINT))
SET_SUMMARY = SET_JOINT.where(JOINT.c.summary.is_(None))
#: The first end of a wait counts.
BEGIN_WAIT = SET_JOINT.where(JOINT.c.waits_since.is_(None))
END_WAIT = SET_JOINT.where(JOINT.c.released_at.is_(None))
SET_PREVIEW = update(PREVIEW).where(_this(PREVIEW))
FORGET_PREVIEW = delete(PREVIEW).where(_this(PREVIEW))
FORGET_ASSESSMENT = delete(ASSESSMENT).where(_this(ASSESSMENT))
FORGET_ASSESSMENTS = delete(ASSESSMENT).where(_ours(ASSESSMENT))
#: The posts of a forum that was replaced.
_MARK = bindparam("mark", type_=Text)
SET_ASIDE = (
    update(CLAIM).where(_ours(CLAIM))
    .values(post=_MARK + CLAIM.c.post, topic="", final=func.coalesce(CLAIM.c.final, "cancelled")),
    update(MOTION).where(_ours(MOTION)).values(post=_MARK + MOTION.c.post),
    update(APPROVAL).where(_ours(APPROVAL)).values(post=_MARK + APPROVAL.c.post, said_by=None),
    delete(SCHEDULE).where(_ours(SCHEDULE)),
    delete(JOINT).where(_ours(JOINT)),
    delete(PREVIEW).where(_ours(PREVIEW)),
    FORGET_ASSESSMENTS,
)  # fmt: skip


def _prune() -> tuple[Any, ...]:
    before, day = (now_s() - bindparam(name, type_=Double) for name in ("age_s", "least_s"))
    newest = select(CLAIM.c.number).where(_ours(CLAIM)).order_by(CLAIM.c.number.desc())
    beyond = newest.offset(bindparam("commands", type_=Integer)).limit(1).scalar_subquery()
    old = or_(CLAIM.c.at < before, and_(CLAIM.c.at < day, CLAIM.c.number <= beyond))
    ended = _ours(CLAIM), CLAIM.c.final.is_not(None), old
    posts = select(CLAIM.c.post).where(*ended)
    of_them = (delete(t).where(_ours(t), t.c.post.in_(posts)) for t in (MOTION, APPROVAL, ASSESSMENT))
    # Posts that were cancelled before anybody claimed them.
    unclaimed = MOTION.c.post.not_in(select(CLAIM.c.post).where(_ours(CLAIM)))
    reported = delete(SCHEDULE).where(
        _ours(SCHEDULE), SCHEDULE.c.told == 1, SCHEDULE.c.post.not_in(select(CLAIM.c.post).where(_ours(CLAIM)))
    )
    joint = delete(JOINT).where(_ours(JOINT), JOINT.c.told == 1, JOINT.c.post.in_(posts))
    return (
        *of_them,
        joint,
        delete(CLAIM).where(*ended),
        delete(MOTION).where(_ours(MOTION), MOTION.c.at < before, unclaimed),
        reported,
    )


#: Claims that ended more than `:age_s` ago, or more than `:least_s` ago and before the newest `:commands`.
PRUNE = _prune()

# ---------------------------------------------------------------- the holder, on PostgreSQL
_FENCE = bindparam("this_number", type_=BigInteger)
#: Leaves a mark, and locks the row until the commit. Changes nothing once another worker has taken the robot.
CHECK_FENCE = update(HOLDER).where(_ours(HOLDER), HOLDER.c.number == _FENCE)
#: The mark of the newest transaction that was committed; waits for one that still may be.
MARK = select(HOLDER.c.written).where(_ours(HOLDER)).with_for_update()


@cache
def _insert(dialect: str, table: Table) -> Any:
    query = (postgresql.insert if dialect == "postgresql" else sqlite.insert)(table)
    if table is CLAIM:
        query = query.values(number=NEWEST_NUMBER.scalar_subquery() + 1, at=now_s())
    elif table is MOTION:
        query = query.values(at=now_s())
    return query.on_conflict_do_nothing().execution_options(preserve_rowcount=True)


@cache
def _put(dialect: str) -> Any:
    query = (postgresql.insert if dialect == "postgresql" else sqlite.insert)(META)
    return query.on_conflict_do_update(index_elements=["robot", "key"], set_={"value": query.excluded.value})


def insert_new(db: Connection, table: Table, **row: Any) -> bool:
    """Insert a row of now unless its key is there already; False if it is: the first one wins."""
    more = {"this_robot": row["robot"]} if table is CLAIM else {}
    return db.execute(_insert(db.dialect.name, table), row | more).rowcount == 1


def insert_all(db: Connection, table: Table, rows: Sequence[dict[str, Any]]) -> None:
    """Insert those rows whose key is not there yet."""
    if rows:
        query = postgresql.insert if db.dialect.name == "postgresql" else sqlite.insert
        db.execute(query(table).on_conflict_do_nothing(), rows)


def put(db: Connection, robot: str, **values: str) -> None:
    """Write values of `META`, over those that are there."""
    db.execute(_put(db.dialect.name), [{"robot": robot, "key": key, "value": value} for key, value in values.items()])
