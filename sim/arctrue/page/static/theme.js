"use strict";
// Applies the reader's choice of dark or light before the browser draws the page.
try {
  const kept = localStorage.getItem("theme");
  if (kept) document.documentElement.dataset.theme = kept;
} catch { /* without storage, the system's choice applies */ }
