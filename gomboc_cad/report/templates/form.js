"use strict";
// What is folded away is printed too.
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((each) => { each.open = true; }));

// The share of good drops that so many drops with so many misses show: one end of the interval of Clopper and Pearson.
(() => {
  const shown = document.getElementById("share-at-least");
  if (!shown) return;
  const [drops, misses] = ["drops", "misses"].map((id) => document.getElementById(id));
  const whole = (field) => (/^\s*\d{1,6}\s*$/.test(field.value) ? Number(field.value) : NaN);

  // Chance of at most so many misses where a drop is good with the given probability.
  function chance(n, most, good) {
    let term = n * Math.log(good), sum = 0;
    for (let k = 0; k <= most; k++) {
      sum += Math.exp(term);
      term += Math.log((n - k) / (k + 1)) + Math.log1p(-good) - Math.log(good);
    }
    return sum;
  }

  function atLeast(n, missed, confidence) {
    if (missed >= n) return 0;
    let low = 0, high = 1;
    for (let step = 0; step < 60; step++) {
      const middle = (low + high) / 2;
      if (chance(n, missed, middle) < 1 - confidence) low = middle;
      else high = middle;
    }
    return low;
  }

  function show() {
    const n = whole(drops), missed = whole(misses);
    const usable = n > 0 && missed >= 0 && missed <= n;
    shown.textContent = usable
      ? `${(100 * atLeast(n, missed, Number(shown.dataset.confidence))).toFixed(1)} %, with ${100 * shown.dataset.confidence} % confidence`
      : "–";
  }

  for (const field of [drops, misses]) field.addEventListener("input", show);
})();
