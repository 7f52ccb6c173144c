// What every page needs: its data, elements, and light or dark.

/** The bytes of a block of data in this page. */
async function bytes(name) {
  const text = atob(document.getElementById(name).textContent);
  const packed = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

async function json(name) {
  return JSON.parse(new TextDecoder().decode(await bytes(name)));
}

/** An element with attributes (null: none; a function: a listener) and children, texts or elements. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name, value);
    else if (value !== null) made.setAttribute(name, value);
  }
  made.append(...children.map((child) => (child instanceof Node ? child : String(child))));
  return made;
}

function place(id) {
  return document.getElementById(id);
}

/** A number for a reader; a dash for none. */
function figure(value, digits = 3) {
  return value === null || value === undefined ? "–" : value.toFixed(digits);
}

function listenToTheme() {
  const root = document.documentElement;
  root.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  place("theme").addEventListener("click", () => {
    root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark";
    document.dispatchEvent(new Event("themechange"));
  });
}

/** A table; `columns` are [title, cell of a row, class], a cell a text or an element. */
function tableOf(columns, rows) {
  const head = columns.map(([name, , kind]) => element("th", { scope: "col", class: kind }, name));
  const body = rows.map((row, at) =>
    element("tr", {}, ...columns.map(([, cell, kind]) => element("td", { class: kind }, cell(row, at)))),
  );
  return element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...body));
}

/** Run the page's program; what goes wrong is said on the page. */
async function showPage(program) {
  listenToTheme();
  try {
    await program(await json(document.body.dataset.index));
    document.body.dataset.ready = "yes";
  } catch (error) {
    document.querySelector("main").prepend(element("p", { class: "note" }, `This page could not be drawn: ${error.message}`));
    throw error;
  }
}

/** An element of an SVG. */
function drawn(tag, attributes) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
