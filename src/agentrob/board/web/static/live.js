// Live updates of pages: new and edited posts, the robot's state and camera, stop without leaving the page.
// All of it is optional: without scripts the same forms and links work.
"use strict";

const main = document.getElementById("main");
const live = document.getElementById("live");
document.documentElement.classList.add("scripted");

const say = (text) => { if (live && live.textContent !== text) live.textContent = text; };

// Create an element with these properties and attributes.
function make(tag, properties, attributes = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// Fetch a fragment of a page; null if the server does not return one.
async function piece(address, how = {}) {
  const answer = await fetch(address, { headers: { Accept: "text/html" }, ...how });
  return answer.ok ? new DOMParser().parseFromString(await answer.text(), "text/html").body : null;
}

// ---------------------------------------------------------------- times in the reader's own zone
// Those of lists and posts as "3 min ago", kept up to date, with the exact time on hover; others as a clock shows them.
const UNITS = [["min", 60], ["h", 3600], ["day", 86400]];

function ago(at) {
  const seconds = (Date.now() - at) / 1000;
  if (seconds < 45) return seconds > -60 ? "just now" : null; // null: not in the past
  if (seconds > 30 * 86400) return null;
  const [unit, size] = UNITS.findLast(([, size]) => Math.round(seconds / 60) * 60 >= size) || UNITS[0];
  const count = Math.max(1, Math.round(seconds / size));
  return `${count} ${unit}${unit === "day" && count > 1 ? "s" : ""} ago`;
}

function localTimes(root) {
  const today = new Date().toDateString();
  for (const time of root.querySelectorAll("time[datetime]")) {
    const at = new Date(time.dateTime);
    if (Number.isNaN(at.getTime())) continue;
    const clock = at.toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit", second: "2-digit" });
    const day = at.toLocaleDateString("en-GB", { day: "numeric", month: "short", year: "numeric" });
    const exact = at.toDateString() === today ? clock : `${day}, ${clock.slice(0, -3)}`;
    const shown = ("ago" in time.dataset && ago(at)) || exact;
    if (time.textContent !== shown) time.textContent = shown;
    time.title = at.toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "long" });
  }
}
localTimes(document);
setInterval(() => { if (!document.hidden) localTimes(document); }, 20000);

// Make elements that scroll sideways reachable by keyboard.
function reachable(root) {
  for (const one of root.querySelectorAll(".body table, pre, .wide-table:not([role])")) {
    if (one.scrollWidth > one.clientWidth) one.tabIndex = 0;
    else one.removeAttribute("tabindex");
  }
}
reachable(document);
addEventListener("resize", () => reachable(document));

// ---------------------------------------------------------------- the event stream
// Closed while the page is hidden (a browser has few connections to one server), resumed after the last event seen.
function listen(query, after, handle) {
  let source = null;
  let last = after;
  let retry = 0;
  const open = () => {
    if (source) return;
    source = new EventSource(`/api/v1/events?${query}after=${encodeURIComponent(last)}`);
    source.onopen = () => { retry = 0; document.documentElement.dataset.live = "on"; say(""); };
    source.onerror = () => {
      document.documentElement.dataset.live = "off";
      say("Connection lost, trying again…");
      if (source.readyState !== EventSource.CLOSED) return; // the browser reconnects
      close();
      retry = Math.min(retry + 1, 5);
      setTimeout(() => { if (!document.hidden) resume(); }, 1000 * 2 ** retry);
    };
    for (const kind of ["post.created", "post.edited", "post.removed"]) {
      source.addEventListener(kind, (event) => {
        last = event.lastEventId || last;
        handle(kind, JSON.parse(event.data));
      });
    }
  };
  const resume = async () => {
    try {
      const answer = await fetch(`/api/v1/changes?limit=1&after=${encodeURIComponent(last)}`);
      // The board was restored from a backup: this page may show posts that no longer exist.
      if (answer.status === 404) return offer("The forum was restored from a backup: reload this page", location.pathname + location.search);
    } catch { /* the server is not available yet */ }
    open();
  };
  const close = () => { if (source) { source.close(); source = null; } };
  let hiding = 0;
  document.addEventListener("visibilitychange", () => {
    clearTimeout(hiding);
    if (document.hidden) hiding = setTimeout(close, 20000);
    else open();
  });
  addEventListener("pagehide", close);
  addEventListener("pageshow", (event) => { if (event.persisted) open(); });
  open();
}

// ---------------------------------------------------------------- a topic
const posts = document.getElementById("posts");

// Keep the visible text in place while `change` alters the page above it.
function inPlace(change) {
  const composer = document.getElementById("reply");
  const writing = composer && composer.contains(document.activeElement);
  const seen = writing ? composer : [...posts.children].find((post) => post.getBoundingClientRect().bottom > 0);
  const before = seen ? seen.getBoundingClientRect().top : 0;
  const kept = change(seen) || seen;
  if (kept && kept.isConnected) {
    const moved = kept.getBoundingClientRect().top - before;
    if (moved) scrollBy({ top: moved, behavior: "instant" });
  }
}

// An edit keeps pictures that are loaded, which would flicker if they were drawn anew, and what the reader unfolded.
function keepSeen(old, fresh) {
  const loaded = new Map([...old.querySelectorAll("img")].map((image) => [image.getAttribute("src"), image]));
  for (const image of fresh.querySelectorAll("img")) {
    const same = loaded.get(image.getAttribute("src"));
    if (!same) continue;
    loaded.delete(image.getAttribute("src"));
    same.alt = image.alt;
    same.hidden = false;
    image.replaceWith(same);
  }
  if (old.querySelector("details[open]")) for (const fold of fresh.querySelectorAll("details")) fold.open = true;
}

function place(fresh) {
  const old = document.getElementById(fresh.id);
  if (old && Number(old.dataset.version) >= Number(fresh.dataset.version) && !fresh.classList.contains("removed")) return;
  if (!old && !("last" in main.dataset)) { offer("New posts", `/p/${fresh.dataset.post}`); return; }
  localTimes(fresh);
  inPlace((seen) => {
    if (old) {
      const focused = old.contains(document.activeElement) ? document.activeElement : null;
      keepSeen(old, fresh);
      old.replaceWith(fresh);
      if (focused) (fresh.querySelector(focused.matches(".stop") ? ".stop" : "a") || main).focus({ preventScroll: true });
      return seen === old ? fresh : seen;
    }
    fresh.classList.add("new");
    const next = [...posts.children].find((post) => Number(post.dataset.post) > Number(fresh.dataset.post));
    posts.insertBefore(fresh, next || null);
    return seen;
  });
  reachable(fresh);
  if (!old && fresh.getBoundingClientRect().top > innerHeight) offerMore(fresh.id);
}

// Count new posts below the screen; the button leads to the first of them.
let below = [];
function offerMore(id) {
  below = document.querySelector(".pill") ? [...below, id] : [id];
  offer(below.length > 1 ? `${below.length} new posts below` : "1 new post below", `#${below[0]}`);
}

function offer(text, href) {
  let pill = document.querySelector(".pill");
  if (!pill) {
    pill = make("a", { className: "pill button primary" });
    document.body.append(pill);
    const gone = () => {
      if (live && live.textContent === pill.textContent) say("");
      pill.remove();
    };
    pill.addEventListener("click", gone);
    addEventListener("scroll", () => {
      const first = pill.isConnected && pill.hash && document.getElementById(pill.hash.slice(1));
      if (first && first.getBoundingClientRect().top < innerHeight) gone();
    }, { passive: true });
  }
  pill.textContent = text;
  pill.setAttribute("href", href);
  say(text);
}

const pending = new Map(); // post id -> whether to fetch once more, so that many edits need few requests

async function refresh(id) {
  if (pending.has(id)) { pending.set(id, true); return; }
  pending.set(id, false);
  try {
    const seen = "last" in main.dataset && !document.hidden ? "?seen=1" : "";
    const fresh = (await piece(`/p/${id}/fragment${seen}`))?.querySelector("article.post");
    if (fresh) place(document.adoptNode(fresh));
  } catch { setTimeout(refresh, 2000, id); } // the event is not sent again
  for (const [address, renew] of parts) if (address.startsWith("/robots?")) renew();
  const again = pending.get(id);
  pending.delete(id);
  if (again) refresh(id);
}

if (main.dataset.topic) {
  listen(`topic_id=${encodeURIComponent(main.dataset.topic)}&`, main.dataset.after, (_, event) => {
    if (event.post) refresh(event.post.id);
  });
}

// ---------------------------------------------------------------- a board: announce new topics
if (main.dataset.board) {
  listen("", main.dataset.after, (kind, event) => {
    const fresh = document.getElementById("fresh");
    if (kind !== "post.created" || !event.post || event.post.board_id !== main.dataset.board || fresh.firstChild) return;
    fresh.append(make("a", { className: "button", href: location.pathname, textContent: "New posts: show them" }));
  });
}

// ---------------------------------------------------------------- stop without leaving the page
document.addEventListener("submit", async (event) => {
  const form = event.target.closest("[data-stop]");
  if (!form) return;
  event.preventDefault();
  const button = form.querySelector("button");
  const label = [...button.childNodes];
  const what = "estop" in form.dataset ? "Emergency stop" : "Stop";
  button.replaceChildren(`Sending ${what.toLowerCase()}…`);
  try {
    const sent = { method: "POST", body: new FormData(form), headers: { "X-Live": "1" }, keepalive: true };
    const answer = await fetch(form.action, { ...sent, signal: AbortSignal.timeout(3000) });
    if (!answer.ok) throw new Error(String(answer.status));
    button.replaceChildren(`${what} sent`);
    say(`${what} sent to @${form.dataset.stop}. ${form.dataset.next}`);
    setTimeout(() => button.replaceChildren(...label), 3000);
  } catch {
    form.submit(); // without scripts, which also shows the error
  }
});

// Escape presses the Stop buttons of the robots on this page that move; pressed twice, those of all of them.
let pressed = -Infinity;
document.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || event.repeat || event.isComposing || document.querySelector("dialog[open]")) return;
  const forms = new Map();
  for (const form of document.querySelectorAll("[data-stop]:not([data-estop])")) {
    const moves = Boolean(form.querySelector(".moves"));
    if (moves || !forms.has(form.dataset.stop)) forms.set(form.dataset.stop, { form, moves });
  }
  const every = [...forms.values()];
  const moving = every.filter((one) => one.moves);
  if (!every.length || (event.defaultPrevented && !moving.length)) return;
  const again = performance.now() - pressed < 5000;
  pressed = performance.now();
  if (!moving.length && !again) return say("No robot on this page is shown as moving. Press Escape again to stop them all.");
  for (const { form } of moving.length ? moving : every) form.requestSubmit();
});

// ---------------------------------------------------------------- pictures open in place
let shownPicture = null;
document.addEventListener("click", (event) => {
  const link = event.target.closest("a[data-picture]");
  if (!link || !link.querySelector("img") || event.button || event.ctrlKey || event.metaKey || event.shiftKey) return;
  event.preventDefault();
  if (!shownPicture) {
    shownPicture = make("dialog", { className: "lightbox" }, { "aria-label": "Picture" });
    const close = make("button", { type: "button", textContent: "Close" });
    shownPicture.append(make("img"), make("p"), close);
    shownPicture.addEventListener("click", (click) => { if (click.target !== shownPicture.querySelector("p")) shownPicture.close(); });
    document.body.append(shownPicture);
  }
  const small = link.querySelector("img");
  Object.assign(shownPicture.querySelector("img"), { src: link.href, alt: small.alt });
  shownPicture.classList.toggle("plot", Boolean(link.closest(".plot")));
  shownPicture.querySelector("p").textContent = link.closest("figure")?.querySelector("figcaption")?.textContent || "";
  shownPicture.showModal();
});

// A recording plays again and again; paused, its first picture is shown.
document.addEventListener("click", (event) => {
  const button = event.target.closest("[data-pause]");
  if (!button) return;
  const image = button.closest("figure").querySelector("img");
  const still = button.closest("figure").querySelector("canvas");
  if (still) still.remove();
  else {
    const canvas = make("canvas", { width: image.naturalWidth, height: image.naturalHeight }, { role: "img", "aria-label": image.alt });
    canvas.getContext("2d").drawImage(image, 0, 0);
    image.after(canvas);
  }
  image.hidden = !still;
  button.textContent = still ? "Pause" : "Play";
});

// ---------------------------------------------------------------- the state of robots, updated while visible
const parts = [];
for (const part of document.querySelectorAll("[data-refresh]")) {
  const renew = async () => {
    if (document.hidden || part.contains(document.activeElement)) return;
    try {
      const fresh = await piece(part.dataset.refresh);
      if (!fresh || fresh.innerHTML === part.dataset.shown) return;
      part.dataset.shown = fresh.innerHTML;
      part.replaceChildren(...fresh.childNodes);
      localTimes(part);
    } catch { /* retried with the next update */ }
  };
  parts.push([part.dataset.refresh, renew]);
  setInterval(renew, Number(part.dataset.every) || 3000);
}

// The camera runs only while its picture is visible, because viewers make the robot's room render.
const camera = document.querySelector("[data-camera]");
if (camera) {
  const picture = make("img", { alt: `Live picture of the room with @${camera.dataset.name}` });
  let inView = false;
  const look = () => {
    if (!inView || document.hidden) {
      picture.removeAttribute("src"); // ends the stream; an empty URL would be an error
      picture.remove();
    } else if (!picture.isConnected) {
      picture.src = `${camera.dataset.camera}?t=${Date.now()}`;
      camera.append(picture);
    }
  };
  picture.addEventListener("error", () => { picture.remove(); setTimeout(look, 3000); });
  new IntersectionObserver((seen) => { inView = seen[seen.length - 1].isIntersecting; look(); }).observe(camera);
  document.addEventListener("visibilitychange", look);
}
