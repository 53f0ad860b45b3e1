"use strict";
// This script draws the plots, shows the progress of the diagnosis and accepts dropped files.
// Without the script the page shows pictures, and all buttons work.

// Plotly can offer a button that sends a chart to another server; these options remove the button.
const OPTIONS = { responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "" };

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function dressed(layout) {
  const axis = { gridcolor: colour("--grid"), linecolor: colour("--axis"), zeroline: false };
  const found = { ...layout, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)" };
  found.font = { color: colour("--ink"), size: 12, family: getComputedStyle(document.body).fontFamily };
  found.hoverlabel = { bgcolor: colour("--paper"), font: { color: colour("--ink") } };
  for (const key of Object.keys(layout)) {
    if (/^[xy]axis/.test(key)) found[key] = { ...axis, ...layout[key] };
  }
  return found;
}

async function draw(place) {
  try {
    const width = Math.round(place.clientWidth);
    const joint = place.dataset.url.includes("?") ? "&" : "?";
    const answer = await fetch(`${place.dataset.url}${joint}width=${width}`);
    if (!answer.ok) throw new Error(`${answer.status}`);
    const figure = await answer.json();
    for (const trace of figure.data) {
      // The server sends the text colour of the light theme; use that of the present theme instead.
      if (trace.line && trace.line.color === "#1c2530") trace.line.color = colour("--ink");
    }
    const layout = dressed(figure.layout);
    place.replaceChildren();
    await Plotly.newPlot(place, figure.data, layout, OPTIONS);
    place.setAttribute("aria-label", figure.words);
    place.dataset.drawn = "1";
  } catch (error) {
    place.textContent = `This figure could not be drawn (${error.message}). Load the page again.`;
  }
}

const drawAll = (root) => Promise.all([...root.querySelectorAll(".plot")].map(draw));

function wire(root) {
  for (const select of root.querySelectorAll("select[data-submits]")) {
    select.addEventListener("change", () => select.form.requestSubmit());
  }
  for (const form of root.querySelectorAll("form")) {
    form.addEventListener("submit", (event) => beforeSending(event, form));
  }
  for (const zone of root.querySelectorAll(".drop")) {
    const input = zone.querySelector("input");
    zone.addEventListener("dragover", (event) => { event.preventDefault(); zone.classList.add("over"); });
    zone.addEventListener("dragleave", () => zone.classList.remove("over"));
    zone.addEventListener("drop", (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      input.files = event.dataTransfer.files;
    });
  }
}

function beforeSending(event, form) {
  const most = Number(form.dataset.mostBytes || 0);
  const files = [...form.querySelectorAll("input[type=file]")].flatMap((input) => [...input.files]);
  const bytes = files.reduce((sum, file) => sum + file.size, 0);
  const problem = form.querySelector("[data-problem]");
  if (most && bytes > most) {
    event.preventDefault();
    problem.textContent = `The files have ${(bytes / 1e6).toFixed(0)} MB together; the limit is ${most / 1e6} MB.`;
    return;
  }
  if (form.dataset.confirm && !confirm(form.dataset.confirm)) {
    event.preventDefault();
    return;
  }
  if (form.method !== "post") return;
  // Disable the buttons after this event, because a disabled button would not send its value.
  setTimeout(() => {
    for (const button of form.querySelectorAll("button")) {
      button.disabled = true;
      if (form.dataset.works) button.textContent = form.dataset.works;
    }
  });
}

async function renewed() {
  // Show new results of the diagnosis; all other parts of the page stay unchanged.
  const answer = await fetch(location.href);
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
  for (const part of document.querySelectorAll("[data-live]")) {
    const other = fresh.getElementById(part.id);
    if (!other || part.contains(document.activeElement) && part.id !== "missing") continue;
    part.replaceChildren(...other.childNodes);
    wire(part);
    await drawAll(part);
  }
}

const ASK_MS = 400, ANSWER_MS = 10000, MOST_SILENT = 5, ASK_GONE_MS = 3000;

// If several requests in sequence get no answer, the server is gone: the page removes the counter of
// seconds and says how to start the server. When the server answers again, the page is loaded again.
function gone(main) {
  const said = document.getElementById("gone");
  const line = said.querySelector("[data-serve]");
  const host = location.hostname.replace(/^\[|\]$/g, "");
  line.textContent = `${line.dataset.serve} --host ${host} --http-port ${location.port || 80}`;
  said.hidden = false;
  main.dataset.state = "gone";
  const doing = document.getElementById("doing");
  if (doing) doing.textContent = "The server does not answer.";
  document.getElementById("counting")?.remove();
  document.querySelector("#ranking progress")?.remove();
}

async function follow(main) {
  let partly = main.dataset.partly === "true", silent = 0;
  for (;;) {
    await new Promise((resolve) => setTimeout(resolve, silent < MOST_SILENT ? ASK_MS : ASK_GONE_MS));
    let state;
    try {
      const answer = await fetch(main.dataset.ranking, { signal: AbortSignal.timeout(ANSWER_MS) });
      state = await answer.json();
    } catch {
      silent += 1; // the server may be busy: request again
      if (silent === MOST_SILENT) gone(main);
      continue;
    }
    if (silent >= MOST_SILENT) {
      location.reload();
      return;
    }
    silent = 0;
    if (state.state !== "running") {
      await renewed();
      main.dataset.state = state.state;
      return;
    }
    if (state.partly && !partly) {
      partly = true;
      await renewed();
    }
    const doing = document.getElementById("doing");
    if (doing) {
      doing.textContent = state.doing;
      document.getElementById("seconds").textContent = state.seconds;
    }
  }
}

document.addEventListener("DOMContentLoaded", async () => {
  wire(document);
  document.getElementById("theme")?.addEventListener("click", () => {
    const root = document.documentElement;
    const dark = root.dataset.theme
      ? root.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    try { localStorage.setItem("theme", root.dataset.theme); } catch { /* the browser does not store it */ }
    drawAll(document);
  });
  const main = document.querySelector("main[data-ranking]");
  if (!main) return;
  await drawAll(document);
  if (main.dataset.state === "running") await follow(main);
});

// After Back the browser may show the page in its last state, with disabled buttons; load it again.
addEventListener("pageshow", (event) => { if (event.persisted) location.reload(); });
