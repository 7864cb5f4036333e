// The live map and the replay: moves the robots of a map by their poses, and opens the 3D view when asked.
// Without scripts the page shows the last picture.

const SMOOTH_MS = 220; // a pose comes five times a second; the robot moves smoothly from one to the next
const MOST_TRAIL = 600;
const OLD_MS = 2500;
const SHAPE_TRIES = 15; // a second apart
const still = matchMedia("(prefers-reduced-motion: reduce)");

const made = (tag, properties = {}, ...children) => {
  const one = Object.assign(document.createElement(tag), properties);
  one.append(...children);
  return one;
};
const line = (points) => points.map(([x, y]) => `${x.toFixed(2)},${(-y).toFixed(2)}`).join(" ");
const turned = (from, to) => ((((to - from + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI;
const between = (a, b, part) => [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part, a[2] + turned(a[2], b[2]) * part];

// ---------------------------------------------------------------- the map
class MapView {
  constructor(section) {
    this.robots = new Map();
    for (const group of section.querySelectorAll("[data-robot]")) {
      this.robots.set(group.dataset.robot, {
        mark: group.querySelector(".map-mark"), plan: group.querySelector(".map-plan"), path: group.querySelector(".map-path"),
      });
    }
  }

  place(name, pose) {
    const robot = this.robots.get(name);
    if (!robot) return;
    const degrees = (-pose[2] * 180) / Math.PI;
    robot.mark.setAttribute("transform", `translate(${pose[0].toFixed(3)} ${(-pose[1]).toFixed(3)}) rotate(${degrees.toFixed(1)})`);
    robot.mark.classList.remove("unknown");
  }

  path(name, plan, trail) {
    const robot = this.robots.get(name);
    if (!robot) return;
    if (plan) robot.plan.setAttribute("points", line(plan));
    robot.path.setAttribute("points", line(trail));
  }
}

// ---------------------------------------------------------------- a view: its map, and its 3D view once opened
class View {
  constructor(section) {
    this.section = section;
    this.stage = section.querySelector(".live-stage");
    this.state = section.querySelector(".live-state");
    this.tools = section.querySelector(".live-tools");
    this.map = new MapView(section);
    this.svg = section.querySelector(".map");
    this.names = [...this.map.robots.keys()];
    this.three = null;
    this.fault = ""; // why there is no 3D view
    this.plans = new Map();
    this.poses = new Map();
    this.changed = () => {};
    if (window.WebGL2RenderingContext && section.dataset.three) {
      this.button = made("button", { type: "button", textContent: "3D", onclick: () => this.toggle() });
      this.button.setAttribute("aria-pressed", "false");
      this.tools.append(this.button);
    }
  }

  say(text) {
    const said = [this.fault, text].filter(Boolean).join(" · ");
    if (this.state.textContent !== said) this.state.textContent = said;
  }

  place(name, pose, body) {
    this.poses.set(name, [pose, body]);
    this.map.place(name, pose);
    if (this.three) this.three.place(name, pose, body);
  }

  path(name, plan, trail) {
    if (plan) this.plans.set(name, plan);
    this.map.path(name, plan, trail);
    if (this.three) this.three.path(name, this.plans.get(name) || [], trail);
  }

  // The camera of the 3D view follows the robot of the page, else the one that moved last.
  moved(name) {
    if (!this.section.dataset.follow && this.followed !== name) {
      this.followed = name;
      if (this.three) this.three.follow(name);
    }
  }

  // Where each robot's shape is; the replay knows its own. An agent makes its robot's shape when it is first wanted.
  async shapes() {
    for (let tries = SHAPE_TRIES; ; tries--) {
      const found = new Map(), missing = [];
      for (const name of this.names) {
        const answer = await fetch(`/api/v1/robots/${encodeURIComponent(name)}/map`);
        const told = answer.ok ? await answer.json() : {};
        if (told.geometry) found.set(name, `/api/v1/geometry/${told.geometry}`);
        else missing.push((told.map && told.map.no_geometry) || "");
      }
      if (found.size) return found;
      if (missing.every(Boolean) || !tries) throw new Error(missing.find(Boolean) || "the robot's agent sends no shape");
      await new Promise((done) => setTimeout(done, 1000));
    }
  }

  async toggle() {
    if (this.three) {
      this.three.close();
      this.three = null;
      this.svg.style.display = "";
    } else {
      this.button.disabled = true;
      this.say("Loading the 3D view…");
      try {
        const shapes = await this.shapes();
        const { openView } = await import(this.section.dataset.three);
        this.three = await openView(this.stage, shapes, this.section.dataset.follow || this.followed || this.names[0]);
        this.svg.style.display = "none";
        for (const [name, [pose, body]] of this.poses) this.three.place(name, pose, body);
        for (const [name, plan] of this.plans) this.three.path(name, plan, []);
      } catch (error) {
        this.button.remove();
        this.fault = `3D is not available here: ${error.message}`;
        this.say("");
        return;
      }
      this.button.disabled = false;
      this.say("");
    }
    this.button.setAttribute("aria-pressed", String(Boolean(this.three)));
    this.button.textContent = this.three ? "Map" : "3D";
    this.changed();
  }
}

// ---------------------------------------------------------------- live
function live(section) {
  const view = new View(section);
  const robots = new Map(); // name -> where it is drawn, where it goes
  let source = null, inView = false, drawing = false, heard = 0;

  const draw = () => {
    let busy = false;
    const now = performance.now();
    for (const [name, robot] of robots) {
      if (!robot.to) continue;
      const part = still.matches ? 1 : Math.min(1, (now - robot.since) / SMOOTH_MS);
      robot.shown = between(robot.from, robot.to, part);
      view.place(name, robot.shown, robot.body);
      busy = busy || part < 1;
    }
    drawing = busy;
    if (busy) requestAnimationFrame(draw);
  };
  const take = (told) => {
    heard = performance.now();
    if (told.plan) {
      const robot = robots.get(told.robot) || {};
      robots.set(told.robot, { ...robot, trail: told.trail });
      view.path(told.robot, told.plan, told.trail);
    }
    if (!told.pose) return;
    section.classList.add("is-live");
    view.say("now");
    const robot = robots.get(told.robot) || {};
    const trail = robot.trail || [];
    const last = trail[trail.length - 1];
    if (last && Math.hypot(told.pose[0] - last[0], told.pose[1] - last[1]) > 0.03) {
      trail.push(told.pose.slice(0, 2));
      if (trail.length > MOST_TRAIL) trail.shift();
      view.path(told.robot, null, trail);
      view.moved(told.robot);
    }
    robots.set(told.robot, {
      trail: last ? trail : [told.pose.slice(0, 2)], from: robot.shown || told.pose, shown: robot.shown || told.pose,
      to: told.pose, since: heard, body: told.body || robot.body,
    });
    if (!drawing) { drawing = true; requestAnimationFrame(draw); }
  };
  const close = () => {
    if (source) { source.close(); source = null; }
    section.classList.remove("is-live");
  };
  const open = () => {
    if (source || !inView || document.hidden) return;
    source = new EventSource(section.dataset.live + (view.three ? "&body=1" : ""));
    source.onmessage = (event) => take(JSON.parse(event.data));
    source.onerror = () => {
      view.say("connection lost");
      if (source && source.readyState === EventSource.CLOSED) { close(); setTimeout(open, 5000); }
    };
  };
  view.changed = () => { close(); open(); };
  setInterval(() => {
    if (source && performance.now() - heard > OLD_MS) {
      section.classList.remove("is-live");
      view.say("no position now: the robot's agent sends none");
    }
  }, 1000);
  let hiding = 0;
  document.addEventListener("visibilitychange", () => {
    clearTimeout(hiding);
    if (document.hidden) hiding = setTimeout(close, 5000);
    else open();
  });
  addEventListener("pagehide", close);
  addEventListener("pageshow", (event) => { if (event.persisted) open(); });
  heard = performance.now();
  new IntersectionObserver((seen) => { inView = seen[seen.length - 1].isIntersecting; inView ? open() : close(); }).observe(section);
}

// ---------------------------------------------------------------- replay
const summed = (differences) => { let sum = 0; return differences.map((value) => (sum += value)); };

async function replay(section) {
  const view = new View(section);
  const name = section.dataset.follow;
  let data;
  try {
    const answer = await fetch(section.dataset.replay);
    if (!answer.ok) throw new Error(String(answer.status));
    data = await answer.json();
  } catch { view.say("The replay could not be loaded"); return; }
  const times = summed(data.t);
  const pose = data.pose.map(summed), body = data.body.map(summed);
  const poseAt = (n) => pose.map((channel) => channel[n] / 1000);
  const bodyAt = (n) => (body.length ? body.map((channel) => channel[n] / 1000) : undefined);
  const end = times[times.length - 1];
  const path = times.map((_, n) => poseAt(n).slice(0, 2));
  view.shapes = async () => {
    if (!data.geometry) throw new Error("the robot's shape was not known");
    return new Map([[name, `/api/v1/geometry/${data.geometry}`]]);
  };
  view.plans.set(name, data.plan);

  let at = end, playing = false, speed = 1, before = 0;
  const play = made("button", { type: "button", textContent: "Play" });
  const slider = made("input", { type: "range", min: 0, max: 100 * Math.ceil(end / 100), step: 100, value: end });
  slider.setAttribute("aria-label", "Time in the replay");
  const clock = made("output");
  const fast = made("select", {}, ...[0.25, 0.5, 1, 2, 4].map((one) => made("option", { value: one, textContent: `${one}×`, selected: one === 1 })));
  fast.setAttribute("aria-label", "Speed");
  const share = made("button", { type: "button", textContent: "Copy link" });
  const step = made("span", { className: "live-step faint" });
  section.append(made("div", { className: "live-controls" }, play, slider, clock, fast, share, step));

  const show = () => {
    let n = 0, high = times.length - 1; // the last sample at or before `at`
    while (n < high) { const middle = (n + high + 1) >> 1; if (times[middle] <= at) n = middle; else high = middle - 1; }
    const next = Math.min(n + 1, times.length - 1);
    const part = next > n ? Math.min(1, (at - times[n]) / (times[next] - times[n])) : 0;
    const [now, then] = [bodyAt(n), bodyAt(next)];
    view.path(name, null, path.slice(0, n + 1));
    view.place(name, between(poseAt(n), poseAt(next), part), now && now.map((value, k) => value + (then[k] - value) * part));
    slider.value = at < end ? at : slider.max;
    clock.textContent = `${(at / 1000).toFixed(1)} / ${(end / 1000).toFixed(1)} s`;
    slider.setAttribute("aria-valuetext", clock.textContent);
    const doing = data.steps.filter(([begun]) => begun <= at).pop();
    step.textContent = doing ? doing[1] : "";
  };
  const tick = (now) => {
    if (!playing) return;
    at = Math.min(end, at + (now - before) * speed);
    before = now;
    show();
    if (at >= end) pause(); else requestAnimationFrame(tick);
  };
  const pause = () => { playing = false; play.textContent = "Play"; };
  play.onclick = () => {
    if (playing) { pause(); return; }
    if (at >= end) at = 0;
    playing = true;
    play.textContent = "Pause";
    before = performance.now();
    requestAnimationFrame(tick);
  };
  slider.oninput = () => { at = Math.min(end, Number(slider.value)); show(); };
  fast.onchange = () => { speed = Number(fast.value); };
  share.onclick = async () => {
    const url = new URL(location.href);
    url.searchParams.set("at", (at / 1000).toFixed(1));
    url.hash = section.id;
    history.replaceState(null, "", url);
    try {
      await navigator.clipboard.writeText(url.href);
      view.say("Link copied");
    } catch { view.say("The address of this page is the link"); }
  };
  view.changed = show;
  const asked = Number(new URL(location.href).searchParams.get("at"));
  if (location.hash === `#${section.id}` && Number.isFinite(asked)) at = Math.max(0, Math.min(end, asked * 1000));
  show();
}

for (const section of document.querySelectorAll(".live-view")) {
  if (section.dataset.replay) replay(section);
  else live(section);
}
