// Filters and sorts the cards, and tells the command that fetches a material. Texts of records are never made into markup.
"use strict";

const form = document.getElementById("filters");
const command = document.getElementById("get");

if (command) {
  const local = location.protocol === "file:";
  const address = local ? decodeURIComponent(location.pathname) : location.href.split("#")[0];
  command.textContent = `bsdf catalog get '${address.replaceAll("'", "'\\''")}'`;
  if (local) document.querySelectorAll(".view").forEach((link) => link.remove());
}

if (form) {
  const list = document.getElementById("cards");
  const cards = [...list.children];
  const words = cards.map((card) => card.dataset.words);
  const names = new Map(cards.map((card) => [card, card.querySelector("h2").textContent]));
  const count = document.getElementById("count");
  const fields = [...form.elements].filter((e) => e.name && e.name !== "words" && e.name !== "sort");
  let sorted = "";

  const sort = (by) => {
    if (by === sorted) return;
    sorted = by;
    const order = [...cards];
    if (by === "name") order.sort((a, b) => names.get(a).localeCompare(names.get(b)));
    else if (by) order.sort((a, b) => Number(b.dataset[by]) - Number(a.dataset[by]));
    list.append(...order);
  };

  const apply = () => {
    const asked = form.elements.words.value.toLowerCase().split(/\s+/).filter(Boolean);
    const wanted = fields.filter((f) => f.value).map((f) => [f.name, f.value]);
    let shown = 0;
    cards.forEach((card, k) => {
      const fits = asked.every((w) => words[k].includes(w)) && wanted.every(([n, v]) => card.dataset[n] === v);
      card.hidden = !fits;
      shown += fits;
    });
    sort(form.elements.sort.value);
    count.textContent = shown === cards.length ? "" : `${shown} of ${cards.length}`;
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
