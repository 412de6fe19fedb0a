// Filters and sorts the cards, and tells the command that fetches a material. Texts of records are never made into markup.
"use strict";

const form = document.getElementById("filters");
const command = document.querySelector("code#get");

if (command) {
  const local = location.protocol === "file:";
  const address = local ? decodeURIComponent(location.pathname) : location.href.split("#")[0];
  command.textContent = `bsdf catalog get '${address.replaceAll("'", "'\\''")}'`;
  if (local) document.querySelectorAll(".view").forEach((link) => link.remove());
}

if (form) {
  const list = document.getElementById("cards");
  const cards = [...list.children];
  const words = new Map(cards.map((card) => [card, card.dataset.words]));
  const names = new Map(cards.map((card) => [card, card.querySelector("h2").textContent]));
  const count = document.getElementById("count");
  const fields = [...form.elements].filter((e) => e.name && e.name !== "words" && e.name !== "sort");
  // What is found is a list of copies, and the one before is hidden: laying out thousands of cards, or taking them out of the
  // page, takes longer than a letter. The first copies are there at once, the others by and by.
  const AT_ONCE = 60;
  const SLICE = 100;
  const TURN = 30;
  const orders = new Map([["", cards]]);
  let listed = cards;
  let found = list;
  let later = 0;

  const ordered = (by) => {
    if (!orders.has(by)) {
      const number = new Map(cards.map((card) => [card, Number(card.dataset[by])]));
      const compare = by === "name" ? new Intl.Collator().compare : (a, b) => b - a;
      const key = by === "name" ? names : number;
      orders.set(by, [...cards].sort((a, b) => compare(key.get(a), key.get(b))));
    }
    return orders.get(by);
  };

  const show = (wanted) => {
    if (wanted.length === listed.length && wanted.every((card, k) => card === listed[k])) return;
    listed = wanted;
    clearTimeout(later);
    const fresh = list.cloneNode(false);
    fresh.removeAttribute("id");
    fresh.style.display = "";
    const add = (from, to) => fresh.append(...wanted.slice(from, to).map((card) => {
      const copy = card.cloneNode(true);
      copy.removeAttribute("id");
      return copy;
    }));
    add(0, AT_ONCE);
    found.after(fresh);
    found.style.display = "none";
    if (found !== list) clear(found);
    found = fresh;
    const more = (from) => {
      if (from >= wanted.length) return;
      later = setTimeout(() => {
        add(from, from + SLICE);
        more(from + SLICE);
      }, TURN);
    };
    more(AT_ONCE);
  };

  const clear = (old) => {
    if (old.children.length <= SLICE) return old.remove();
    for (let k = 0; k < SLICE; k++) old.lastElementChild.remove();
    setTimeout(() => clear(old), TURN);
  };

  const apply = () => {
    const asked = form.elements.words.value.toLowerCase().split(/\s+/).filter(Boolean);
    const wanted = fields.filter((f) => f.value).map((f) => [f.name, f.value]);
    const fits = (card) => asked.every((w) => words.get(card).includes(w)) && wanted.every(([n, v]) => card.dataset[n] === v);
    const shown = ordered(form.elements.sort.value).filter(fits);
    show(shown);
    count.textContent = shown.length === cards.length ? "" : `${shown.length} of ${cards.length}`;
    const state = new URLSearchParams([...new FormData(form)].filter(([, v]) => v));
    history.replaceState(null, "", state.size ? `?${state}` : location.pathname);
  };

  for (const [name, value] of new URLSearchParams(location.search)) {
    if (form.elements[name]) form.elements[name].value = value;
  }
  form.hidden = false;
  form.addEventListener("input", apply);
  form.addEventListener("submit", (event) => event.preventDefault());
  apply();
}
