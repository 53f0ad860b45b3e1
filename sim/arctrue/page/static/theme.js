"use strict";
// The reader's choice of dark or light, before anything is drawn.
try {
  const kept = localStorage.getItem("theme");
  if (kept) document.documentElement.dataset.theme = kept;
} catch { /* no storage: the system's choice */ }
