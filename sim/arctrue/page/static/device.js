"use strict";
// Reads the device's state from the server each second and shows the state; page.js defines OPTIONS
// and dressed.

const POLL_MS = 1000, POLL_ANSWER_MS = 10000;
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
const FIELDS = [
  ["recorded", "recorded (UTC)", ""], ["result", "result", ""], ["reason", "reason", ""],
  ["separation_deg", "head separation", "°", 5], ["noise_arcsec", "noise of a reading", "″", 3],
  ["residual_arcsec", "residual of the estimate", "″", 3], ["active_arcsec", "error that remains", "″", 3],
  ["temperature_c", "die", "°C", 1], ["table_c", "table", "°C", 1],
];

function rows(body, content) {
  body.replaceChildren(...content.map((cells) => {
    const row = document.createElement("tr");
    for (const text of cells) row.insertCell().textContent = text;
    return row;
  }));
}

function line(name, time, values, errors, index) {
  const colour = COLOURS[index % COLOURS.length];
  const found = { type: "scatter", mode: "lines+markers", name, x: time, y: values, marker: { size: 4 } };
  found.line = { color: colour, dash: DASHES[index % DASHES.length] };
  if (errors) found.error_y = { type: "data", array: errors, color: colour, thickness: 1, width: 0 };
  return found;
}

function chart(id, traces, unit) {
  const layout = { height: 300, margin: { l: 60, r: 10, t: 10, b: 40 }, showlegend: true, uirevision: id };
  layout.xaxis = { title: { text: "time (UTC)" } };
  layout.yaxis = { title: { text: unit }, rangemode: "tozero" };
  if (id !== "chart-orders") delete layout.yaxis.rangemode;
  layout.legend = { orientation: "h", y: 1.15 };
  return Plotly.react(document.getElementById(id), traces, dressed(layout), OPTIONS);
}

function figure(value, digits, unit) {
  return value === null || value === undefined ? "–" : value.toFixed(digits) + unit;
}

function showHeads(heads) {
  document.getElementById("heads").hidden = !heads.rows.length;
  if (!heads.rows.length) return;
  const parity = heads.parity_counts === null || heads.parity_counts === undefined ? "" :
    ` Parity: ${heads.parity_counts.toFixed(1)} counts.`;
  const late = typeof heads.u_late_ns !== "number" ? "" : ` u of a delay: ${heads.u_late_ns.toFixed(1)} ns.`;
  document.getElementById("heads-note").textContent = `From turn ${heads.turn}.${parity}${late}`;
  const [asynchronous, u] = heads.asynchronous;
  document.getElementById("axis-note").textContent = typeof asynchronous !== "number" ? "" :
    `Motion that does not repeat: ${asynchronous.toFixed(3)}″ RMS, u ${u.toFixed(3)}″.`;
  rows(document.querySelector("#heads section tbody"), heads.rows.map(([head, place, u, radius, uRadius, late, left, use]) =>
    [head, figure(place, 4, "°"), figure(u, 1, "″"), figure(radius, 6, ""), figure(uRadius, 6, ""), figure(late, 1, " ns"), figure(left, 3, "″"), use]));
  rows(document.querySelector("#axis-circles tbody"), heads.axis.map(([order, forward, backward]) =>
    [order, figure(forward, 3, "″"), figure(backward, 3, "″")]));
}

function orbitTraces(orbit) {
  const samples = { type: "scatter", mode: "markers", name: "every sample", x: orbit.x, y: orbit.y };
  samples.marker = { size: 2, color: "#888888" };
  const mean = { type: "scatter", mode: "lines", name: "mean of the turns", x: orbit.mean_x, y: orbit.mean_y };
  mean.line = { color: COLOURS[0], width: 2 };
  return [samples, mean];
}

async function showAxis(state) {
  const orbit = state.orbit, circles = state.charts.axis;
  document.getElementById("axis").hidden = !orbit && !circles.length;
  if (circles.length)
    await chart("chart-axis", circles.map((c, n) => line(c.name, state.charts.time, c.arcsec, null, n)), "arcsec");
  if (!orbit) return;
  document.getElementById("orbit-note").textContent = `${orbit.set}, ${orbit.heads} heads; u of a sample: ` +
    `${orbit.u[0].toFixed(3)}″ in x, ${orbit.u[1].toFixed(3)}″ in y. The circle of order 1 in the table's sense is not drawn, because an eccentric disc looks the same.`;
  const layout = { height: 400, margin: { l: 60, r: 10, t: 10, b: 40 }, showlegend: true, uirevision: "orbit" };
  layout.xaxis = { title: { text: "x, arcsec" } };
  layout.yaxis = { title: { text: "y, arcsec" }, scaleanchor: "x" };
  layout.legend = { orientation: "h", y: 1.12 };
  await Plotly.react(document.getElementById("chart-orbit"), orbitTraces(orbit), dressed(layout), OPTIONS);
}

async function show(state) {
  document.getElementById("lost").textContent = state.problem || (state.connected ? "" : "The serial port is lost.");
  const alarms = document.getElementById("alarm-list");
  alarms.textContent = state.alarms.length ? state.alarms.join(", ") : "none";
  alarms.className = state.alarms.length ? "problem" : "";
  document.getElementById("machine-alarms").replaceChildren(...state.machine_alarms.map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
  document.getElementById("events").replaceChildren(...state.events.slice().reverse().map((event) => {
    const item = document.createElement("li");
    item.textContent = `${event.time}  ${event.text}`;
    return item;
  }));
  if (!state.turn) return;
  const turn = { ...state.turn, recorded: state.recorded };
  const known = FIELDS.filter(([key]) => turn[key] !== undefined && turn[key] !== null);
  rows(document.querySelector("#now tbody"), [["turn", turn.turn], ...known.map(([key, name, unit, digits]) =>
    [name, digits === undefined ? turn[key] : `${turn[key].toFixed(digits)} ${unit}`])]);
  showHeads(state.heads);
  const reference = document.getElementById("reference").value, since = state.since[reference];
  document.getElementById("since").textContent = `Since turn ${since.turn} (${since.recorded} UTC), ` +
    (reference === "first" ? "the first turn that the page has." : "the first turn with the present coefficients.");
  const changes = since.changes.slice().sort((a, b) => b.significant - a.significant);
  rows(document.querySelector("#changed tbody"), [
    ...changes.map((c) => [c.quantity, `${c.size_arcsec.toFixed(3)}″`, `${c.u_arcsec.toFixed(3)}″`,
      c.significant ? "changed" : "–"]),
    ...since.temperatures.map((t) => [`temperature, ${t.name}`, `${(t.now - t.before).toFixed(1)} °C`, "", ""]),
  ]);
  const { time, separation, u_separation: u, die, table } = state.charts;
  await chart("chart-orders", since.orders.map((o, n) => line(`order ${o.order}`, time, o.change, o.u, n)), "arcsec");
  await chart("chart-separation", [line("head 2", time, separation, u, 0)], "arcsec");
  await chart("chart-temperatures", [line("die", time, die, null, 0), line("table", time, table, null, 1)], "°C");
  await showAxis(state);
}

document.addEventListener("DOMContentLoaded", async () => {
  const main = document.querySelector("main[data-device]");
  for (;;) {
    try {
      const answer = await fetch(main.dataset.device, { signal: AbortSignal.timeout(POLL_ANSWER_MS) });
      const state = await answer.json();
      // The capture has ended: after a reload the server shows the diagnosis or the reason of the failure.
      if (main.dataset.capture && state.capture !== main.dataset.capture) return location.reload();
      await show(state);
      main.dataset.turn = state.turn ? state.turn.turn : "";
    } catch (error) {
      document.getElementById("lost").textContent = `The page's server does not answer (${error.message}).`;
    }
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
});
