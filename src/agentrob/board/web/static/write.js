// The editor: preview, pictures by paste and drop, names with the robots' state, quoting in place.
// All of it is optional: without scripts the same forms and links work.
"use strict";

const csrf = document.querySelector("meta[name=csrf]").content;
const text = document.querySelector("[data-compose]");

if (text) {
  const form = text.form;
  const told = form.querySelector("[data-told]");
  const tell = (words) => { told.textContent = words; };

  // -------------------------------------------------------------- preview without leaving the page
  form.addEventListener("submit", async (event) => {
    if (event.submitter?.value !== "preview") return;
    event.preventDefault();
    const shown = form.querySelector("[data-preview]");
    try {
      const body = new URLSearchParams({ csrf, body: text.value, board: form.dataset.board || "" });
      shown.replaceChildren(...(await piece("/preview", { method: "POST", body })).childNodes);
      tell("");
    } catch {
      tell("The preview failed. Is the forum reachable, and is the text short enough?");
    }
  });

  // -------------------------------------------------------------- what the robots would do, while it is written
  const reading = document.querySelector("meta[name=reads]") && form.querySelector("[data-reading]");
  const title = form.querySelector("[data-title]");
  const topic = document.getElementById("main").dataset.topic || "";
  let pause = 0;
  let request = null;
  // A line in which words between backticks are code, as in the robots' replies.
  const shownLine = (line) => line.split(/`([^`]+)`/).map((part, n) => (n % 2 ? make("code", { textContent: part }) : part));
  const read = async () => {
    request?.abort();
    request = new AbortController();
    const mine = request;
    try {
      const answer = await fetch("/api/v1/commands/read", {
        method: "POST", signal: mine.signal, headers: { "Content-Type": "application/json", "X-CSRF-Token": csrf },
        body: JSON.stringify({ text: text.value, board_id: topic ? "" : form.dataset.board || "", topic_id: topic }),
      });
      if (mine !== request) return;
      const found = answer.ok ? await answer.json() : { line: "", robots: [] };
      const lines = found.line ? found.line.split("\n") : [];
      reading.replaceChildren(...lines.flatMap((line, n) => [...(n ? [make("br")] : []), ...shownLine(line)]));
      const would = found.robots.length && found.robots.every((one) => !["refuse", "ask_back", "nothing"].includes(one.outcome));
      reading.dataset.outcome = would ? "would" : "not";
    } catch { /* a newer text is read, or the server is not available */ }
  };
  const reread = () => { clearTimeout(pause); pause = setTimeout(read, 60); };
  const titled = () => {
    if (!title) return;
    const first = text.value.split("\n").find((line) => line.trim()) || "";
    title.placeholder = first.trim().replace(/^(?:[@＠][\w-]+[\s,;:，：、]*)+/, "").slice(0, 80);
  };
  if (reading) {
    text.addEventListener("input", () => { if (text.value.length <= 2000) reread(); else reading.replaceChildren(); });
    if (text.value.trim()) reread();
  }
  text.addEventListener("input", titled);
  titled();
  document.addEventListener("click", (event) => {
    const example = event.target.closest("[data-fill]");
    if (!example || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    text.value = example.dataset.fill;
    text.focus();
    text.dispatchEvent(new Event("input"));
    text.scrollIntoView({ block: "nearest" });
  });
  text.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) form.requestSubmit(form.querySelector("button.primary"));
  });

  // -------------------------------------------------------------- pictures
  const thumbs = form.querySelector("[data-thumbs]");
  const take = async (files) => {
    for (const file of [...files].filter((file) => file.type.startsWith("image/"))) {
      tell(`Uploading ${file.name}…`);
      const body = new FormData();
      body.append("file", file);
      try {
        const answer = await fetch("/api/v1/images", { method: "POST", body, headers: { "X-CSRF-Token": csrf } });
        const image = await answer.json();
        if (!answer.ok) { tell(`${file.name}: ${[image.detail, image.hint].filter(Boolean).join("; ")}.`); continue; }
        thumbs.append(thumb(image, file.name));
        tell(`${file.name} is attached.`);
      } catch {
        tell(`${file.name} could not be uploaded.`);
      }
    }
  };
  const thumb = (image, name) => {
    const item = make("li");
    const away = make("button", { type: "button", textContent: "Remove" }, { "aria-label": `Remove ${name}` });
    away.addEventListener("click", () => { item.remove(); text.focus(); });
    const sent = make("input", { type: "hidden", name: "images", value: image.id });
    item.append(make("img", { src: `/images/${image.id}/small`, alt: name }), sent, away);
    return item;
  };
  if (thumbs) {
    const chosen = form.querySelector("input[type=file]");
    chosen.addEventListener("change", async () => { const files = [...chosen.files]; chosen.value = ""; await take(files); });
    text.addEventListener("dragover", (event) => { event.preventDefault(); text.classList.add("dropping"); });
    text.addEventListener("dragleave", () => text.classList.remove("dropping"));
  }
  for (const kind of ["paste", "drop"]) text.addEventListener(kind, (event) => {
    text.classList.remove("dropping");
    const files = (event.clipboardData || event.dataTransfer).files;
    if (!files.length) return;
    event.preventDefault();
    if (thumbs) take(files);
    else tell("Only operators can add pictures here; an administrator can give you that role.");
  });

  // -------------------------------------------------------------- names
  // A list below the text: arrows select, Enter and Tab insert, Escape closes; the text keeps the focus.
  const offer = make("ul", { className: "offer", id: "offer", hidden: true }, { role: "listbox", "aria-label": "Names" });
  text.after(offer);
  const attributes = { "aria-autocomplete": "list", "aria-haspopup": "listbox", "aria-controls": "offer" };
  for (const [name, value] of Object.entries(attributes)) text.setAttribute(name, value);
  let at = -1;
  let asked = 0;

  const begun = () => /(?:^|[^A-Za-z0-9_@/.+-])[@＠]([A-Za-z][A-Za-z0-9_-]{0,31})?$/.exec(text.value.slice(0, text.selectionStart));
  const close = () => {
    asked += 1; // an answer that arrives later does not open the list again
    if (!offer.hidden) tell("");
    offer.hidden = true;
    text.removeAttribute("aria-activedescendant");
  };
  const choose = (next) => {
    const items = [...offer.children];
    at = (next + items.length) % items.length;
    items.forEach((item, n) => item.setAttribute("aria-selected", String(n === at)));
    text.setAttribute("aria-activedescendant", items[at].id);
  };
  const accept = (name) => {
    const found = begun();
    if (!found) return close();
    const start = text.selectionStart - (found[1] || "").length;
    text.setRangeText(`${name} `, start, text.selectionStart, "end");
    close();
    text.focus();
  };
  const item = (one, n) => {
    const made = make("li", { id: `offer-${n}` }, { role: "option", "data-name": one.name });
    if (one.robot) made.append(make("span", { className: `dot ${one.live ? "on" : "off"}` }));
    made.append(make("strong", { textContent: `@${one.name}` }), make("span", { className: "faint", textContent: one.state }));
    made.addEventListener("pointerdown", (event) => { event.preventDefault(); accept(one.name); });
    return made;
  };
  text.addEventListener("input", async () => {
    const found = begun();
    const mine = ++asked;
    if (!found) return close();
    try {
      const answer = await fetch(`/names?q=${encodeURIComponent(found[1] || "")}`);
      const names = answer.ok ? await answer.json() : [];
      if (mine !== asked) return;
      if (!names.length) return close();
      offer.replaceChildren(...names.map(item));
      offer.hidden = false;
      tell(`${names.length} ${names.length > 1 ? "names" : "name"}: arrow keys choose, Enter inserts.`);
      choose(0);
    } catch { close(); }
  });
  text.addEventListener("keydown", (event) => {
    if (event.isComposing) return;
    if (offer.hidden) { if (event.key === "Escape") close(); return; }
    if (event.key === "ArrowDown") choose(at + 1);
    else if (event.key === "ArrowUp") choose(at - 1);
    else if (event.key === "Enter" || event.key === "Tab") accept(offer.children[at].dataset.name);
    else if (event.key === "Escape") close();
    else return;
    event.preventDefault();
  });
  text.addEventListener("blur", close);

  // -------------------------------------------------------------- replying in place: the text is kept
  const answers = form.querySelector("[data-answers]");
  const answer = (post) => {
    answers.hidden = !post;
    answers.querySelector("input").value = post;
    if (post) {
      const to = answers.querySelector("a");
      to.href = `/p/${post}`;
      to.textContent = document.querySelector(`#post-${post} .who`)?.textContent || "an earlier post";
    }
    text.focus();
  };
  const quote = async (link) => {
    try {
      const raw = await fetch(`/p/${link.dataset.quote}/raw`);
      if (!raw.ok) throw new Error(String(raw.status));
      const lines = (await raw.text()).trim().split("\n").slice(0, 40).map((line) => `> ${line}`.trimEnd());
      const before = text.value.slice(0, text.selectionStart).trimEnd();
      const words = `${before ? "\n\n" : ""}${lines.join("\n")}\n\n`;
      text.setRangeText(words, before.length, text.selectionEnd, "end");
      answer(link.dataset.quote);
    } catch { location.href = link.href; }
  };
  document.addEventListener("click", (event) => {
    const link = event.target.closest("[data-quote], [data-reply], [data-answers-none]");
    if (!answers || !link || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    if (link.dataset.quote) quote(link);
    else answer(link.dataset.reply || "");
  });
}
