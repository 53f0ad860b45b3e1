"use strict";
// Waits until the running step has ended, then loads the page again, which shows the step's result.
const STEP_POLL_MS = 500, STEP_ANSWER_MS = 10000;

document.addEventListener("DOMContentLoaded", async () => {
  const main = document.querySelector("main[data-commissioning]");
  while (main.dataset.running) {
    await new Promise((resolve) => setTimeout(resolve, STEP_POLL_MS));
    try {
      const answer = await fetch(main.dataset.commissioning, { signal: AbortSignal.timeout(STEP_ANSWER_MS) });
      if ((await answer.json()).running !== main.dataset.running) return location.reload();
      document.getElementById("lost").textContent = "";
    } catch (error) {
      document.getElementById("lost").textContent = `The page's server does not answer (${error.message}).`;
    }
  }
});
