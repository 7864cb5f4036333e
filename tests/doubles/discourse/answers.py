"""The double's responses: fields from its state; other fields that Discourse's OpenAPI document requires are empty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tests.doubles.discourse.document import filled
from tests.doubles.discourse.site import Category, Post, Site, Topic, User

Json = dict[str, Any]
TOPICS_A_PAGE = 30
_AVATAR = "/letter_avatar_proxy/v4/letter/x/{size}.png"


def post(site: Site, p: Post, viewer: User | None, raw: bool = True) -> Json:
    """Return a post like `PostSerializer`; `raw` is included on request only."""
    user, topic = site.users[p.user], site.topics[p.topic]
    mine = viewer is not None and viewer.id == user.id
    known = {
        "id": p.id, "name": user.name, "username": user.username, "avatar_template": _AVATAR, "user_id": user.id,
        "created_at": _iso(p.created_at), "updated_at": _iso(p.updated_at), "cooked": p.cooked,
        "post_number": p.number, "post_type": 1, "posts_count": len(topic.posts), "topic_id": topic.id,
        "topic_slug": slug(topic), "reply_to_post_number": p.reply_to, "version": p.version, "yours": mine,
        "moderator": user.moderator, "admin": user.admin, "staff": user.staff, "trust_level": user.trust_level,
        "hidden": p.hidden, "deleted_at": _iso(p.deleted_at) if p.deleted_at else None, "user_deleted": p.user_deleted,
        "can_edit": mine, "display_username": user.name, "post_url": f"/t/{slug(topic)}/{topic.id}/{p.number}",
    }  # fmt: skip
    return known | {"raw": p.raw} if raw else known


def latest_posts(site: Site, viewer: User, before: int | None) -> Json:
    found = [
        p
        for p in sorted(site.posts.values(), key=lambda p: -p.id)
        if p.deleted_at is None and not p.hidden and site.visible(None, p) | site.visible(viewer, p)
        and (before is None or p.id < before) and not site.topics[p.topic].deleted
    ]  # fmt: skip
    posts = []
    for p in found[:50]:
        topic = site.topics[p.topic]
        more = {"category_id": topic.category, "topic_title": topic.title, "topic_html_title": topic.title}
        posts.append(post(site, p, viewer) | more)
    return filled("get", "/posts.json", {"latest_posts": posts})


def topic_view(site: Site, topic: Topic, viewer: User, username: str | None) -> Json:
    """Return a topic with the first of the selected posts (without raw) and the ids of all of them."""
    seen = [p for n in topic.posts if site.visible(viewer, p := site.posts[n])]
    chosen = [p for p in seen if username is None or p.number == 1 or site.users[p.user].username.lower() == username]
    posts = []
    for p in chosen[: int(site.settings["posts_per_page"])]:
        known = post(site, p, viewer, raw=False) | {"link_counts": [], "reviewable_id": 0}
        del known["posts_count"], known["post_url"]
        posts.append(known)
    begun = site.users[topic.user]
    known = {
        "id": topic.id, "title": topic.title, "fancy_title": topic.title, "slug": slug(topic),
        "posts_count": len(seen), "created_at": _iso(site.posts[topic.posts[0]].created_at),
        "category_id": topic.category, "user_id": topic.user, "closed": topic.closed, "archetype": "regular",
        "highest_post_number": len(topic.posts), "visible": True, "slow_mode_seconds": topic.slow_mode_seconds,
        "post_stream": {"posts": posts, "stream": [p.id for p in chosen]},
        "chunk_size": int(site.settings["posts_per_page"]),
        "details": {"created_by": basic(begun), "last_poster": basic(begun), "can_create_post": not topic.closed},
    }  # fmt: skip
    return filled("get", "/t/{id}.json", known)


def some_posts(site: Site, topic: Topic, viewer: User, ids: Sequence[int], raw: bool) -> Json:
    posts = [
        filled_post(post(site, p, viewer, raw=raw))
        for n in ids
        if (p := site.posts.get(n)) is not None and p.topic == topic.id and site.visible(viewer, p)
    ]
    return {"post_stream": {"posts": sorted(posts, key=lambda p: p["post_number"])}, "id": topic.id}


def filled_post(known: Json) -> Json:
    return filled("get", "/posts/{id}.json", known)


def categories(site: Site, viewer: User) -> Json:
    seen = [
        c for c in site.categories.values() if c.only_group is None or viewer.staff or c.only_group in viewer.groups
    ]
    top = [_category(c) for c in seen if c.parent is None]
    for known in top:
        below = [_category(c) for c in seen if c.parent == known["id"]]
        if below:
            known |= {"has_children": True, "subcategory_ids": [c["id"] for c in below]}
            known["subcategory_list"] = [
                filled("get", "/categories.json", {"category_list": {"categories": [c]}})["category_list"][
                    "categories"
                ][0]
                for c in below
            ]
    return filled("get", "/categories.json", {"category_list": {"categories": top}})


def category_path(site: Site, c: Category) -> str:
    """Return the slugs of a category and its parent; a category without a slug is named by its number."""
    above = f"{category_path(site, site.categories[c.parent])}/" if c.parent else ""
    return above + (c.slug or f"{c.id}-category")


def _category(c: Category) -> Json:
    known: Json = {"id": c.id, "name": c.name, "slug": c.slug, "color": "0088CC", "text_color": "FFFFFF"}
    return known | ({"parent_category_id": c.parent} if c.parent else {})


def category_topics(site: Site, category: Category, viewer: User, page: int) -> Json:
    """Return the topics of a category and its subcategories, latest activity first, thirty per page."""
    wanted = {category.id, *(c.id for c in site.categories.values() if c.parent == category.id)}
    found = [t for t in site.topics.values() if t.category in wanted and site.sees(viewer, t)]
    found.sort(key=lambda t: -t.posts[-1])
    shown = found[page * TOPICS_A_PAGE : (page + 1) * TOPICS_A_PAGE]
    topics = [
        {
            "id": t.id, "title": t.title, "fancy_title": t.title, "slug": slug(t), "posts_count": len(t.posts),
            "highest_post_number": len(t.posts), "created_at": _iso(site.posts[t.posts[0]].created_at),
            "last_posted_at": _iso(site.posts[t.posts[-1]].created_at), "category_id": t.category, "visible": True,
            "bumped_at": _iso(site.posts[t.posts[-1]].created_at), "archetype": "regular",
            "last_poster_username": site.users[site.posts[t.posts[-1]].user].username,
            "posters": [{"user_id": t.user, "description": "Original Poster"}],
        }
        for t in shown
    ]  # fmt: skip
    people = [basic(site.users[n]) for n in dict.fromkeys(t.user for t in shown)]
    listed: Json = {"topics": topics, "per_page": TOPICS_A_PAGE, "can_create_topic": True}
    if len(found) > (page + 1) * TOPICS_A_PAGE:
        listed["more_topics_url"] = f"/c/{category.slug}/{category.id}/l/latest?page={page + 1}"
    return filled("get", "/c/{slug}/{id}.json", {"users": people, "topic_list": listed})


def profile(site: Site, user: User) -> Json:
    """Return `/u/{username}.json`, with the automatic groups, and with a suspension only if there is one."""
    automatic = [f"trust_level_{n}" for n in range(user.trust_level + 1)]
    automatic += [name for name, has in (("admins", user.admin), ("moderators", user.moderator)) if has]
    groups = [{"id": 10 + n, "automatic": True, "name": g, "display_name": g} for n, g in enumerate(automatic)]
    groups += [
        {"id": g, "automatic": False, "name": site.groups[g].name, "public_admission": site.groups[g].public_admission}
        for g in sorted(user.groups)
    ]
    known = basic(user) | {
        "created_at": "2026-01-01T00:00:00.000Z", "trust_level": user.trust_level, "admin": user.admin,
        "moderator": user.moderator, "groups": groups,
    }  # fmt: skip
    if user.suspended_till:
        known |= {"suspended_till": user.suspended_till, "suspend_reason": "test"}
    return filled("get", "/u/{username}.json", {"user": known})


def actions(site: Site, user: User, viewer: User, wanted: set[str], offset: int) -> Json:
    """Return a user's actions, newest first, thirty per page: type 4 for topics, 5 for replies."""
    found = []
    for p in sorted(site.posts.values(), key=lambda p: -p.id):
        kind = 4 if p.number == 1 else 5
        if p.user != user.id or str(kind) not in wanted or not site.visible(viewer, p):
            continue
        topic = site.topics[p.topic]
        found.append(
            {
                "action_type": kind, "created_at": _iso(p.created_at), "slug": slug(topic), "topic_id": topic.id,
                "post_number": p.number, "post_id": p.id, "username": user.username, "user_id": user.id,
                "acting_username": user.username, "acting_user_id": user.id, "title": topic.title,
                "category_id": topic.category, "target_username": user.username, "target_user_id": user.id,
            }
        )  # fmt: skip
    return filled("get", "/user_actions.json", {"user_actions": found[offset : offset + 30]})


def search(site: Site, viewer: User, term: str, page: int) -> Json:
    """Return posts that contain all words, newest first, fifty per page; `#parent:child` selects a category."""
    words = [w for w in term.lower().split() if not w.startswith("#") and ":" not in w]
    places = [w[1:].replace(":", "/") for w in term.split() if w.startswith("#")]
    wanted = {c.id for c in site.categories.values() if not places or category_path(site, c) in places}
    found = [
        p
        for p in sorted(site.posts.values(), key=lambda p: -p.id)
        if words
        and site.visible(viewer, p)
        and p.deleted_at is None
        and site.topics[p.topic].category in wanted
        and all(w in p.raw.lower() for w in words)
    ]
    posts = [
        {"id": p.id, "topic_id": p.topic, "post_number": p.number, "username": site.users[p.user].username,
         "blurb": p.raw[:200], "created_at": _iso(p.created_at)}
        for p in found[(page - 1) * 50 : page * 50]
    ]  # fmt: skip
    about: Mapping[str, Any] = {"term": term, "post_ids": [p["id"] for p in posts]}
    return filled("get", "/search.json", {"posts": posts, "grouped_search_result": about})


def basic(user: User) -> Json:
    return {"id": user.id, "username": user.username, "name": user.name, "avatar_template": _AVATAR}


def slug(topic: Topic) -> str:
    return "-".join("".join(c if c.isascii() and c.isalnum() else " " for c in topic.title.lower()).split()) or "topic"


def _iso(at: Any) -> str:
    return str(at.isoformat(timespec="milliseconds")).replace("+00:00", "Z")
